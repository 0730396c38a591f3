"""Wrong arguments: every one an exception with words, never a crash."""

import gc
import os
import unittest

import numpy as np

import support
import tremolo


class Coordinates(unittest.TestCase):
    def test_of_a_wrong_shape_are_refused(self):
        m = support.clamped_bar()
        for q in (np.zeros(3), np.zeros((2, 3)), np.zeros((1, 2, m.modes)), 1.0, [[1.0], [2.0, 3.0]], []):
            for function in (m.energy, m.force, m.tangent):
                with self.assertRaises((ValueError, TypeError)):
                    function(q)

    def test_of_a_wrong_type_are_refused(self):
        m = support.clamped_bar()
        r = m.modes
        for q in (np.zeros(r, dtype=complex), np.array(["1.0"] * r), np.array([None] * r), "text", None, {}, b"bytes",
                  np.zeros(r, dtype="datetime64[s]")):
            with self.assertRaises(TypeError):
                m.energy(q)

    def test_that_are_not_finite_give_numbers_that_are_not(self):
        m = support.clamped_bar()
        self.assertTrue(np.isnan(m.energy(np.full(m.modes, np.nan))))
        self.assertFalse(np.isfinite(m.force(np.full(m.modes, 1e200))).all())


class Results(unittest.TestCase):
    def test_are_not_written_into_unsuitable_arrays(self):
        m = support.clamped_bar()
        q = support.some_states(m, 4)
        read_only = np.zeros_like(q)
        read_only.flags.writeable = False
        unaligned = np.frombuffer(bytearray(8 * q.size + 1), dtype=np.uint8)[1:].view(np.float64).reshape(q.shape)
        self.assertFalse(unaligned.flags.aligned)
        for out in (np.zeros((4, 3)), np.zeros((4, m.modes), dtype=np.float32), np.asfortranarray(np.zeros_like(q)),
                    read_only, unaligned, np.zeros((4, 2 * m.modes))[:, ::2], [[0.0]], "x",
                    np.zeros((4, m.modes), dtype=">f8"), np.zeros((0, m.modes))):
            with self.assertRaises((ValueError, TypeError)):
                m.force(q, out=out)
        self.assertFalse(read_only.any())
        b = m.body()
        s = len(m.vertices)
        for out in (np.zeros((s, 3), dtype=int), np.zeros(3 * s), np.zeros((s, 3), order="F"), np.zeros((s - 1, 3)), 7):
            with self.assertRaises((ValueError, TypeError)):
                b.positions(out=out)
            with self.assertRaises((ValueError, TypeError)):
                b.boundary_positions(out=out)
        with self.assertRaises(TypeError):
            b.positions(dtype=np.int32)
        good = np.zeros((s, 3))
        for names in ({"into": good}, {"out": good, "into": good}, {"dtype": "text"}, {"dtype": 3}):
            with self.assertRaises(TypeError):
                b.positions(**names)
        for arguments in ((good, good), (good, np.float64)):
            with self.assertRaises(TypeError):
                b.positions(*arguments)
        with self.assertRaises(TypeError):
            b.positions(good, out=good)
        with self.assertRaises(TypeError):
            tremolo.Body.positions(m)
        for empty in (np.zeros((0, 3)), np.zeros(0), np.zeros((0, 0))):
            with self.assertRaises(ValueError):
                b.positions(out=empty)
        locked = np.zeros((s, 3), dtype=np.float32)
        locked.flags.writeable = False
        with self.assertRaisesRegex(tremolo.UsageError, "read-only"):
            b.positions(out=locked)
        self.assertFalse(locked.any())


class Indices(unittest.TestCase):
    def test_out_of_range_are_refused(self):
        m = support.clamped_bar()
        b = m.body()
        n = m.vertex_count
        for vertex in (-1, n, 2**31 - 1, 2**40):
            with self.assertRaises((ValueError, TypeError)):
                b.position(vertex)
            with self.assertRaises(ValueError):
                b.add_load([vertex], (0.0, 0.0, 1.0))
            with self.assertRaises(ValueError):
                b.apply_force([vertex], (0.0, 0.0, 1.0))
            with self.assertRaises(ValueError):
                b.grab(vertex, 1.0)
            with self.assertRaises(ValueError):
                m.reduced_force([vertex], [(0.0, 0.0, 1.0)])
        for wrong in ([1.5], "no-such-set", None):
            with self.assertRaises((ValueError, TypeError)):
                b.apply_force(wrong, (0.0, 0.0, 1.0))
        for number in (-1, 0, 99):
            with self.assertRaises((ValueError, TypeError)):
                b.release(number)

    def test_of_loads_fit_their_forces(self):
        b = support.clamped_bar().body()
        with self.assertRaisesRegex(tremolo.UsageError, "2 forces for 3 vertices"):
            b.add_load([78, 79, 80], np.zeros((2, 3)))
        for force in ((0.0, 1.0), (0.0, np.nan, 0.0), "up", np.zeros((3, 2))):
            with self.assertRaises((ValueError, TypeError)):
                b.add_load([78, 79, 80], force)


class Bodies(unittest.TestCase):
    def test_of_wrong_choices_are_refused_with_the_known_ones(self):
        m = support.clamped_bar()
        with self.assertRaisesRegex(tremolo.UsageError, "unknown integrator 'magic'; known: verlet"):
            m.body(integrator="magic")
        with self.assertRaisesRegex(tremolo.UsageError, "unknown frame 'loose'"):
            m.body(frame="loose")
        for options in ({"step": 0.0}, {"step": np.nan}, {"alpha": -1.0}, {"frame": "free"}, {"split": "half"},
                        {"integrator": "imexv", "split": 99}, {"damping_ratio": "1:2"}, {"tolerance": 0.0},
                        {"damping_ratio": -0.1}, {"damping_ratio": "150%"}, {"damping_ratio": [0.01] * 500},
                        {"damping_ratio": "1:0.1,2:0.1", "alpha": 1.0}, {"max_iterations": 0}, {"step": "long"}):
            with self.assertRaises((ValueError, TypeError)):
                m.body(**options)

    def test_refuse_what_their_frame_does_not_have(self):
        b = support.clamped_bar().body()
        with self.assertRaises(tremolo.UsageError):
            b.move_to((0.0, 0.0, 1.0))
        with self.assertRaises(tremolo.UsageError):
            b.set_motion((0.0, 0.0, 1.0))
        driven = support.clamped_bar().body(frame="driven")
        for rotation in ((2.0, 0.0, 0.0, 0.0), (np.nan, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0)):
            with self.assertRaises(ValueError):
                driven.move_to((0.0, 0.0, 0.0), rotation)

    def test_refuse_wrong_counts_of_steps(self):
        b = support.clamped_bar().body()
        for n in (-1, 1.5, "many", None, 2**70):
            with self.assertRaises((ValueError, TypeError)):
                b.step(n)
        b.step(0)
        self.assertEqual(b.steps, 0)

    def test_are_not_made_without_a_model(self):
        for kind in (tremolo.Body, tremolo.Model, tremolo.NodalBody, tremolo.NodalScene, tremolo.World,
                     tremolo.Recorder):
            with self.assertRaisesRegex(TypeError, "has no constructor"):
                kind()
            with self.assertRaises(TypeError):
                kind.__new__(kind)
            with self.assertRaises(TypeError):
                object.__new__(kind)

    def test_refuse_signals_that_are_none(self):
        b = support.clamped_bar().body()
        for options in ({"signal": "noise"}, {"signal": ([0.0, 1.0], [1.0])}, {"signal": ([1.0, 0.0], [1.0, 1.0])},
                        {"signal": 3}, {"signal": "sine", "frequency": -1.0}, {"signal": "square", "frequency": 1.0},
                        {"start": np.nan}, {"scale": np.inf}, {"signal": "chirp", "sweep": (1.0,)},
                        {"reduced": [1.0]}, {"reduced": np.zeros(10), "at": [1], "force": (0, 0, 1)},
                        {"at": [1]}, {"force": (0.0, 0.0, 1.0)}):
            with self.assertRaises((ValueError, TypeError), msg=str(options)):
                b.add_load(**options)


class Files(unittest.TestCase):
    def test_that_are_no_models_are_refused(self):
        with self.assertRaises(tremolo.FileError):
            tremolo.load("/nowhere/at/all.tremolo")
        with self.assertRaises(OSError):
            tremolo.load("/nowhere/at/all.tremolo")
        with self.assertRaises(tremolo.ContentError):
            tremolo.load(__file__)
        for path in (3, None, 1.5, ["a"], object()):
            with self.assertRaises(TypeError):
                tremolo.load(path)
        with self.assertRaises(ValueError):
            tremolo.load("a\0b")
        with self.assertRaises((tremolo.Error, UnicodeError)):
            tremolo.load("\udcff.tremolo")
        data = support.clamped_bar().file_bytes()
        for damaged in (b"", data[:100], data[:-1], data[:500] + b"x" + data[501:]):
            with self.assertRaises(tremolo.ContentError):
                tremolo.load_bytes(damaged)
        with self.assertRaises(tremolo.UsageError):
            tremolo.load_bytes(data, modes=99)
        with self.assertRaises(TypeError):
            tremolo.load_bytes("text")


    def test_whose_paths_are_no_text_are_refused(self):
        recorder = tremolo.recorder()
        recorder.add(support.clamped_bar().body(), "bar")
        recorder.frame()
        for path in (3, None, 1.5, ["a"], object(), b"a\0b", "a\0b"):
            for call in (tremolo.load, tremolo.load_scene, tremolo.world, recorder.write,
                         lambda p: tremolo.write_msh(p, support.bar_mesh())):
                with self.assertRaises((TypeError, ValueError)):
                    call(path)


class Arguments(unittest.TestCase):
    def test_vertices_that_do_not_exist_are_one_kind_of_error(self):
        body = support.clamped_bar().body()
        for vertex in (-1, 10**7, 10**12):
            with self.assertRaisesRegex(tremolo.UsageError, str(vertex)):
                body.apply_force(vertex, (0.0, 0.0, 1.0))

    def test_a_box_needs_lengths_above_zero_and_whole_numbers_of_cells(self):
        for size in ((1, 0, 1), (-1, 1, 1), (1, np.nan, 1), (1, np.inf, 1), (1, 1)):
            with self.assertRaisesRegex(tremolo.UsageError, "size"):
                tremolo.box(size=size, cells=(1, 1, 1))
        for cells in ((1.5, 1, 1), (0, 1, 1), (1, 1), (1, 1, np.nan)):
            with self.assertRaisesRegex(tremolo.UsageError, "cells"):
                tremolo.box(size=(1, 1, 1), cells=cells)

    def test_meshes_of_the_other_kind_and_files_that_cannot_be_written_are_refused(self):
        tets = support.bar_mesh()
        triangles = tremolo.Mesh(tets.vertices, tets.cells[:, :3])
        path = os.path.join(support.folder(), "mesh")
        with self.assertRaisesRegex(tremolo.UsageError, "write_msh writes them"):
            tremolo.write_ply(path, tets)
        with self.assertRaisesRegex(tremolo.UsageError, "write_ply writes them"):
            tremolo.write_msh(path, triangles)
        for write, mesh in ((tremolo.write_ply, triangles), (tremolo.write_msh, tets)):
            for bad in ("/dev/full", os.path.join(path, "no", "folder")):
                with self.assertRaisesRegex(tremolo.FileError, bad + ": cannot be written"):
                    write(bad, mesh)
            write(path, mesh)
            self.assertEqual([name for name in os.listdir(support.folder()) if "part" in name], [])

    def test_a_recorder_refuses_rates_and_late_bodies_at_once(self):
        for rate in (0, -5, float("nan"), float("inf")):
            with self.assertRaisesRegex(tremolo.UsageError, "rate"):
                tremolo.recorder(rate=rate)
        recorder = tremolo.recorder()
        recorder.add(support.clamped_bar().body(), "bar")
        recorder.frame()
        with self.assertRaisesRegex(tremolo.UsageError, "late.*before the first"):
            recorder.add(support.clamped_bar().body(), "late")
        with self.assertRaisesRegex(tremolo.UsageError, r"\.obj, a page of the motion in \.html"):
            recorder.write("x.foo")

    def test_an_empty_path_is_named(self):
        with self.assertRaisesRegex(tremolo.UsageError, "the path is empty"):
            tremolo.load("")

    def test_errors_of_a_scene_that_is_a_dict_name_its_key(self):
        scene = {"step": 0.003, "no_such_key": 3, "bodies": [{"name": "a", "model": "missing.tremolo", "kind": "free"}]}
        for make in (tremolo.world, tremolo.load_scene):
            with self.assertRaises(tremolo.Error) as caught:
                make(scene)
            self.assertIn("the scene's 'no_such_key'", str(caught.exception))
            self.assertNotIn(os.path.join(os.getcwd(), "scene"), str(caught.exception))
            with self.assertRaisesRegex(tremolo.FileError, "missing.tremolo"):
                make({key: value for key, value in scene.items() if key != "no_such_key"})


class Pickles(unittest.TestCase):
    def things(self):
        m = support.clamped_bar()
        b = m.body()
        b.add_load(signal=([0.0, 1.0], [0.0, 1.0]))
        b.add_load([78, 79], [(0.0, 0.0, 1.0)] * 2, signal="sine", frequency=2.0)
        yield m
        yield b
        yield tremolo.world({"step": 0.003, "bodies": [
            {"name": "bar", "model": support.file_of(support.free_bar(), "free.tremolo"), "kind": "free"}]})

    def replaced(self, value, junk):
        """The value with one of its parts, at any depth, replaced by the junk; one after another."""
        yield junk
        if isinstance(value, (tuple, list)):
            for i, part in enumerate(value):
                for other in self.replaced(part, junk):
                    yield type(value)([*value[:i], other, *value[i + 1:]])

    def test_of_wrong_values_are_refused_or_harmless(self):
        for thing in self.things():
            make, (state,) = thing.__reduce__()
            make(state)
            for junk in (None, -1, 99, 2**40, "text", b"bytes", (), [1.0], [(), 1], float("nan"), object()):
                for wrong in self.replaced(state, junk):
                    try:
                        made = make(wrong)
                    except (ValueError, TypeError, OSError):
                        continue
                    try:
                        if hasattr(made, "step"):
                            made.step()
                    except tremolo.SolverError:  # a load that is not finite
                        pass

    def test_of_another_version_name_both(self):
        for thing in self.things():
            make, (state,) = thing.__reduce__()
            with self.assertRaisesRegex(tremolo.ContentError, "of version 7, not [12]: make it again"):
                make((state[0], 7, *state[2:]))


class Views(unittest.TestCase):
    def test_outlive_what_they_show(self):
        scene = {"step": 0.003, "bodies": [
            {"name": "bar", "model": support.file_of(support.free_bar(), "free.tremolo"), "kind": "free"}]}
        views = [tremolo.world(scene)["bar"].q, tremolo.world(scene)["bar"].model.U,
                 tremolo.load_bytes(support.clamped_bar().file_bytes()).Lambda, support.clamped_bar().body().p]
        kept = [view.copy() for view in views]
        gc.collect()
        junk = [np.full(4096, np.nan) for _ in range(64)]
        for view, copy in zip(views, kept):
            np.testing.assert_array_equal(view, copy)
        del junk
        views[0][:] = 1.0  # it belongs to nothing any more
        self.assertEqual(views[0].sum(), len(views[0]))


class Meshes(unittest.TestCase):
    def test_with_wrong_arrays_are_refused_before_the_program_starts(self):
        v, c = support.bar_mesh()
        bad_vertex = v.copy()
        bad_vertex[5, 1] = np.nan
        cases = [
            (v[:, :2], c, "shape"), (v, c[:, :2], "shape"), (v[:0], c, "empty"), (v, c[:0], "empty"),
            (bad_vertex, c, "vertex 5 is not finite"), (v, c + 70, "has the vertex"), (v, c - 1, "has the vertex -1"),
            (v, c.astype(float), "integers"), (v.astype(complex), c, "numbers"), (v.astype(str), c, "numbers"),
            (v.ravel(), c, "shape"),
        ]
        for vertices, cells, words in cases:
            with self.assertRaisesRegex((ValueError, TypeError), words):
                tremolo.precompute(vertices, cells, **support.MATERIAL)
            with self.assertRaisesRegex((ValueError, TypeError), words):
                tremolo.matrices(vertices, cells, **support.MATERIAL)
        for thing in (None, "mesh.msh", 3, (v,), object()):
            with self.assertRaises(TypeError):
                tremolo.precompute(thing)

    def test_that_cannot_be_computed_with_have_the_words_of_the_program(self):
        v, c = support.bar_mesh()
        with self.assertRaisesRegex(tremolo.ContentError, "degenerate|volume"):
            tremolo.precompute(v * [1.0, 1.0, 0.0], c, **support.MATERIAL, fixed="x<0.001")
        with self.assertRaisesRegex(tremolo.ContentError, "Poisson"):
            tremolo.precompute(v, c, young=1e5, poisson=0.5, fixed="x<0.001")
        with self.assertRaises(tremolo.UsageError):
            tremolo.precompute(v, c, fixed="x<0.001", no_such_flag=3)
        with self.assertRaises(TypeError):
            tremolo.precompute(v, c, young="stiff")
        with self.assertRaises(tremolo.UsageError):
            tremolo.precompute(v, c, name="../mesh.msh")
        for fixed in ([], np.zeros(81, dtype=bool), [81], [-1], np.zeros((2, 2)), np.array(["a", 1], dtype=object)):
            with self.assertRaises((ValueError, TypeError)):
                tremolo.precompute(v, c, **support.MATERIAL, fixed=fixed)
        with self.assertRaises(tremolo.UsageError):
            tremolo.precompute(v, c, **support.MATERIAL, fixed="x<0.001", load_at="x>0.3")
        with self.assertRaises(tremolo.FileError):
            tremolo.precompute(v, c, **support.MATERIAL, fixed="x<0.001", output="/nowhere/a.tremolo")

    def test_of_the_wrong_material_have_no_matrices(self):
        mesh = support.bar_mesh()
        for options in ({"young": -1.0}, {"poisson": 0.5}, {"density": 0.0}, {"order": 3}, {"mass": "heavy"}):
            with self.assertRaises(ValueError):
                tremolo.matrices(*mesh, **{**support.MATERIAL, **options})


if __name__ == "__main__":
    unittest.main()
