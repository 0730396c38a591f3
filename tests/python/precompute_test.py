"""tremolo.precompute and tremolo.reference: arrays instead of files."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

import numpy as np

import support
import tremolo


def program_file(folder, mesh_name, words):
    """The bytes that the program writes of a mesh in the folder."""
    subprocess.run([tremolo.find_program("tremolo-precompute"), mesh_name, *words, "-o", "out.tremolo"], cwd=folder,
                   check=True, stderr=subprocess.DEVNULL)
    with open(os.path.join(folder, "out.tremolo"), "rb") as file:
        return file.read()


WORDS = ["--young", "500000.0", "--poisson", "0.4", "--density", "1100.0"]


class Files(unittest.TestCase):
    def test_of_arrays_are_those_of_the_mesh_file_byte_by_byte(self):
        mesh = support.bar_mesh()
        with tempfile.TemporaryDirectory() as folder:
            tremolo.write_msh(os.path.join(folder, "mesh.msh"), mesh)
            same = program_file(folder, "mesh.msh", [*WORDS, "--fix", "x<0.001", "--order", "1", "--modes", "6"])
        model = tremolo.precompute(*mesh, **support.MATERIAL, fixed="x<0.001", order=1, r=6)
        self.assertEqual(model.file_bytes(), same)

    def test_of_a_sample_mesh_read_by_meshio_are_those_of_its_file_byte_by_byte(self):
        import meshio

        folder = os.path.join(support.SOURCE, "assets", "meshes")
        mesh = meshio.read(os.path.join(folder, "beam.msh"))
        words = [*WORDS, "--fix", "x<0.004", "--order", "1", "--linear-modes", "3", "--modes", "5"]
        with tempfile.TemporaryDirectory() as other:
            os.symlink(os.path.join(folder, "beam.msh"), os.path.join(other, "beam.msh"))
            same = program_file(other, "beam.msh", words)
        model = tremolo.precompute(mesh, **support.MATERIAL, fixed="x<0.004", order=1, linear_modes=3, r=5,
                                   name="beam.msh")
        self.assertEqual(model.file_bytes(), same)

    def test_are_written_where_they_are_wanted(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "büro.tremolo")
            model = tremolo.precompute(*support.bar_mesh(), **support.MATERIAL, fixed="x<0.001", order=1, r=4,
                                       linear_modes=2, output=path)
            self.assertEqual(model.path, path)
            self.assertEqual(os.listdir(folder), ["büro.tremolo"])

    def test_leave_nothing_behind(self):
        before = set(os.listdir("/dev/shm")) if os.path.isdir("/dev/shm") else set()
        with self.assertRaises(tremolo.ContentError):
            tremolo.precompute(*support.bar_mesh(), young=-1.0)
        if before:
            left = {name for name in os.listdir("/dev/shm") if name.startswith("tremolo-")} - before
            self.assertEqual(left, set())


class Choices(unittest.TestCase):
    def test_of_vertices_are_a_selector_a_mask_or_indices(self):
        mesh = support.bar_mesh()
        held = mesh.vertices[:, 0] < 0.001
        options = {**support.MATERIAL, "order": 1, "r": 4, "linear_modes": 2}
        hashes = {tremolo.precompute(*mesh, fixed=fixed, **options).content_hash
                  for fixed in ("x<0.001", ["x<0.001"], held, np.flatnonzero(held), list(np.flatnonzero(held)))}
        self.assertEqual(len(hashes), 1)

    def test_of_a_surface_are_its_own_vertices(self):
        # Eight corners: the tetrahedra have other vertices, those at x = 0 lie in the face of the four held corners.
        corners = np.array([(x, y, z) for x in (0.0, 0.4) for y in (0.0, 0.06) for z in (0.0, 0.04)])
        faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
                 (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
        options = {**support.MATERIAL, "order": 1, "r": 4, "linear_modes": 2, "tets": 600}
        held = corners[:, 0] == 0.0
        by_place = tremolo.precompute(corners, faces, fixed="x<1e-6", **options)
        for fixed in (held, np.flatnonzero(held)):
            model = tremolo.precompute(corners, faces, fixed=fixed, load_at=[7], load_force=(0, 0, -1), **options)
            np.testing.assert_array_equal(model.frequencies, by_place.frequencies)
            at, _ = model.default_load
            place = model.vertices[np.flatnonzero(model.vertex_ids == at[0])[0]]
            np.testing.assert_allclose(place, corners[7], atol=1e-12)

    def test_on_a_slender_surface_warn_of_its_volume(self):
        # A rod of twelve sides, of which the mesh keeps a few: the truth is the prism's volume.
        turn = 2 * np.pi * np.arange(12) / 12
        ring = np.stack([np.zeros(12), 0.001 * np.cos(turn), 0.001 * np.sin(turn)], axis=1)
        rod = np.concatenate([ring, ring + [0.5, 0, 0]])
        faces = [(0, i + 1, i) for i in range(1, 11)] + [(12, 12 + i, 13 + i) for i in range(1, 11)]
        for i in range(12):
            k = (i + 1) % 12
            faces += [(i, k, 12 + k), (i, 12 + k, 12 + i)]
        volume = 0.5 * 12 * 0.5 * 0.001**2 * np.sin(turn[1])
        with self.assertWarnsRegex(UserWarning, "less volume than the surface") as caught:
            tremolo.precompute(rod, faces, young=1e6, poisson=0.3, density=1000.0, linear=True, linear_modes=6)
        path = os.path.join(support.folder(), "rod.ply")
        tremolo.write_ply(path, tremolo.Mesh(rod, np.array(faces)))
        printed = json.loads(tremolo.run_program("tremolo-precompute", [
            path, "--fix", "none", "--linear", "--linear-modes", "6", "--density", "1000", "--json", "-o",
            os.path.join(support.folder(), "rod.tremolo")]))
        lost = 100 * (1 - printed["total_mass_kg"] / (1000.0 * volume))
        self.assertGreater(lost, 2)
        self.assertIn(f"has {lost:.2g} % less", str(caught.warning))
        self.assertEqual(printed["warnings"], [str(caught.warning)])
        self.assertTrue(caught.filename.endswith("precompute_test.py"))

    def test_without_which_a_force_is_refused(self):
        with self.assertRaisesRegex(tremolo.UsageError, "load_at"):
            tremolo.precompute(*support.bar_mesh(), fixed="x<0.001", load_force=(0, 0, 1))
        with self.assertRaisesRegex(tremolo.UsageError, "no model"):
            tremolo.precompute(*support.bar_mesh(), fixed="x<0.001", select="x<0.001")

    def test_reach_the_program_as_flags(self):
        m = tremolo.precompute(*support.bar_mesh(), **support.MATERIAL, fixed="x<0.001", order=1, linear_modes=3,
                               linear=True, keep_elements=True, certify=None)
        self.assertTrue(m.linear)
        self.assertEqual(m.modes, 3)

    def test_of_the_order_add_edge_points(self):
        m = tremolo.precompute(*support.bar_mesh(), **support.MATERIAL, fixed="x<0.001", order=2, r=4, linear_modes=2,
                               keep_elements=True)
        self.assertEqual(m.vertex_count, 81 + len(m.edges))


class Progress(unittest.TestCase):
    def test_is_reported_by_stage(self):
        stages = []
        tremolo.precompute(*support.bar_mesh(), **support.MATERIAL, fixed="x<0.001", order=1, r=4, linear_modes=2,
                           progress=lambda stage, seconds, detail: stages.append((stage, seconds, detail)))
        names = [stage for stage, _, _ in stages]
        self.assertEqual(names[0], "mesh")
        self.assertEqual(names[-1], "file")
        self.assertIn("coefficients", names)
        self.assertIn("81 vertices", stages[0][2])

    def test_that_raises_ends_the_program(self):
        class Enough(Exception):
            pass

        def stop(*_):
            raise Enough

        with self.assertRaises(Enough):
            tremolo.precompute(*support.bar_mesh(), **support.MATERIAL, fixed="x<0.001", progress=stop)

    @unittest.mock.patch.dict(os.environ)
    def test_ends_with_control_c_and_so_does_the_program(self):
        # Libraries of sanitizers (sanitized.sh) are for this process: with them the program does not end.
        os.environ.pop("LD_PRELOAD", None)
        mesh = tremolo.box((1.0, 1.0, 1.0), (14, 14, 14))
        timer = threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            while True:  # however fast the machine is
                tremolo.precompute(*mesh, **support.MATERIAL, fixed="z<0.001", order=2)
        timer.join()
        self.assertLess(time.monotonic() - begin, 60.0)
        children = subprocess.run(["ps", "--ppid", str(os.getpid()), "-o", "comm="], capture_output=True, text=True,
                                  check=False).stdout
        self.assertNotIn("tremolo", children)


class Reference(unittest.TestCase):
    def test_is_what_a_reduced_body_does_in_a_small_motion(self):
        mesh = support.bar_mesh()
        model = tremolo.precompute(*mesh, **support.MATERIAL, fixed="x<0.001", load_at="x>0.399",
                                   load_force=(0.0, 0.0, -0.05), order=1, r=20, linear_modes=20, linear=True)
        vertex = 80
        whole = tremolo.reference(*mesh, **support.MATERIAL, fixed="x<0.001", load_at="x>0.399",
                                  load_force=(0.0, 0.0, -0.05), order=1, load="square", step=2e-3, duration=0.1,
                                  probe=vertex)
        body = model.body(step=2e-3)
        body.add_load(signal="square")
        reduced = [0.0]
        for _ in range(50):
            body.step()
            reduced.append(body.displacement(vertex)[2])
        full = whole.columns[f"u{vertex}z"]
        self.assertEqual(len(full), 51)
        # The basis leaves out the modes above the twentieth, and the step's dispersion differs.
        self.assertLess(np.abs(full - reduced).max(), 0.03 * np.abs(full).max())
        self.assertEqual(whole.report["exit_code"], 0)

    def test_takes_masks_paths_and_vectors(self):
        mesh = support.bar_mesh()
        model = support.clamped_bar()
        end = mesh.vertices[:, 0] > 0.399
        options = {**support.MATERIAL, "fixed": "x<0.001", "order": 1, "step": 0.01, "duration": 0.03}
        texts = tremolo.reference(*mesh, **options, gravity="0,0,-9.81", probe="x>0.399", compare=[model])
        arrays = tremolo.reference(*mesh, **options, gravity=(0, 0, -9.81), probe=end,
                                   compare=support.file_of(model, "compared.tremolo"))
        self.assertEqual(list(texts.columns), list(arrays.columns))
        self.assertGreater(len(texts.columns), 10)
        for name, column in texts.columns.items():
            np.testing.assert_array_equal(column, arrays.columns[name])
        for compare in (model, [model]):
            self.assertTrue(tremolo.reference(*mesh, **options, gravity=np.array([0, 0, -1.0]), compare=compare).report)
        with self.assertRaises(TypeError):
            tremolo.reference(*mesh, **options, compare=[3])

    def test_at_rest_is_the_equilibrium(self):
        mesh = support.bar_mesh()
        whole = tremolo.reference(*mesh, **support.MATERIAL, fixed="x<0.001", load_at="x>0.399",
                                  load_force=(0.0, 0.0, -1.0), order=1, static=True, probe=["80"])
        self.assertEqual(whole.report["exit_code"], 0)


class Programs(unittest.TestCase):
    def test_are_found_in_the_folder_that_is_given(self):
        command = "import tremolo; print(tremolo.find_program('tremolo-precompute'))"
        environment = {**os.environ, "TREMOLO_BIN": "/nowhere"}
        run = subprocess.run([sys.executable, "-c", command], env=environment, capture_output=True, text=True,
                             check=False)
        self.assertIn("FileError: /nowhere/tremolo-precompute: there is no such program", run.stderr)

    def test_are_found_in_a_folder_that_is_given_from_here(self):
        folder = os.path.dirname(tremolo.find_program("tremolo-precompute"))
        environment = {**os.environ, "TREMOLO_BIN": os.path.relpath(folder)}
        # The program runs in another folder.
        command = ("import tremolo; print(tremolo.precompute(*tremolo.box((1, 1, 1), (1, 1, 1)), young=1e6, "
                   "poisson=0.3, density=1000, fixed='x<0.1', order=1, r=2).modes)")
        run = subprocess.run([sys.executable, "-c", command], env=environment, capture_output=True, text=True,
                             check=False)
        self.assertEqual((run.returncode, run.stdout.strip()), (0, "2"), run.stderr)


if __name__ == "__main__":
    unittest.main()
