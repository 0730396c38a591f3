"""Tetrahedra and cloths in worlds, and scenes of tetrahedra or of cloths alone."""

import copy
import functools
import json
import os
import pickle
import threading
import unittest

import numpy as np

import support
import tremolo

G = 9.81


@functools.lru_cache(maxsize=None)
def block(fixed=()):
    """The file of a block of tetrahedra of 0.2 m x 0.1 m x 0.1 m, at the origin."""
    path = os.path.join(support.folder(), f"block-{len(fixed)}")
    tremolo.write_msh(path + ".msh", tremolo.box((0.2, 0.1, 0.1), (4, 2, 2)))
    words = ["tets", path + ".msh", "--young", "2e5", "--poisson", "0.4", "--density", "1000", "-o", path + ".tets"]
    for selector in fixed or ("none",):
        words += ["--fix", selector]
    tremolo.run_program("tremolo-precompute", words)
    return path + ".tets"


def tets(name="block", **more):
    return {"name": name, "kind": "tets", "model": block(), "integrator": "implicit-euler", "degree": "linear", **more}


def marble(**more):
    return {"name": "marble", "kind": "rigid", "shape": "sphere", "radius": 0.03, "mass": 0.5, **more}


def sheet(**more):
    return {"name": "sheet", "columns": 6, "rows": 5, "width": 0.5, "height": 0.4, "drag": 0.0, **more}


def report_of(scene):
    """What `tremolo run` of the scene prints as JSON."""
    path = os.path.join(support.folder(), "scene.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(tremolo.scene_text(scene))
    return json.loads(tremolo.run_program("tremolo", ["run", path, "--json"]))


class WorldsWithTetrahedra(unittest.TestCase):
    def on_a_floor(self):
        return {"step": 0.004, "duration": 0.2, "gravity": [0, 0, -G],
                "bodies": [tets(position=[0, 0, 0.01]), marble(position=[0.1, 0.05, 0.16])],
                "colliders": [{"name": "floor", "shape": "plane"}]}

    def test_have_bodies_of_both_kinds(self):
        w = tremolo.world(self.on_a_floor())
        self.assertEqual(w.names, ["marble", "block"])
        self.assertEqual(len(w), 2)
        b = w["block"]
        self.assertIsInstance(b, tremolo.NodalBody)
        self.assertIsInstance(w["marble"], tremolo.Body)
        self.assertIs(w[1], b)
        self.assertEqual((b.name, b.kind), ("block", "tets"))
        self.assertAlmostEqual(b.mass, 0.2 * 0.1 * 0.1 * 1000)
        self.assertFalse(b.held.any())
        # The boundary is drawn; the mesh's vertices come first among its points.
        np.testing.assert_allclose(b.positions().min(axis=0), (0, 0, 0.01), atol=1e-12)
        np.testing.assert_allclose(b.points[:45].max(axis=0), (0.2, 0.1, 0.11), atol=1e-12)
        self.assertLess(b.triangles.max(), len(b.positions()))

    def test_are_those_of_the_program(self):
        scene = self.on_a_floor()
        w = tremolo.world(scene)
        w.step(50)
        known = {body["body"]: body for body in report_of(scene)["bodies"]}["block"]
        account = w.account("block")
        self.assertEqual(account["at_start"], known["energy_initial"])
        self.assertEqual(account["total"], known["energy_final"])
        for cause, key in (("gravity", "gravity"), ("contact", "contact_given"), ("friction", "friction"),
                           ("restitution", "restitution"), ("method", "method")):
            self.assertAlmostEqual(account[key], known["energy_by_cause"][cause], delta=1e-15)
        self.assertEqual(w.contacts("block"), known["contacts"])
        self.assertGreater(w.contacts("block"), 0)
        self.assertAlmostEqual(0.2 * w.penetration("block"), known["penetration_max"])
        np.testing.assert_array_equal(w.momenta("block")[0], known["linear_momentum_final"])
        self.assertFalse(w.failed("block") or w.asleep("block"))

    def test_let_a_body_fall_as_gravity_says(self):
        w = tremolo.world({"step": 0.004, "gravity": [0, 0, -G], "bodies": [
            tets(velocity=[1, 0, 0]), marble(position=[0, 0, 5])]})
        b = w["block"]
        w.step(25)
        mass, t = b.mass, 0.1
        # Implicit Euler's impulse is exact; the tolerance is that of its solves.
        np.testing.assert_allclose(b.linear_momentum, (mass, 0, -mass * G * t), rtol=1e-6, atol=1e-9)
        # Its fall is g h^2 n (n + 1)/2.
        drop = G * 0.004**2 * 25 * 26 / 2
        np.testing.assert_allclose(b.points[0], (0.1, 0, -drop), atol=1e-6)
        np.testing.assert_allclose(b.velocities(), np.broadcast_to((1, 0, -G * t), b.positions().shape), atol=1e-5)

    def test_keep_the_momentum_of_two_bodies_that_meet(self):
        w = tremolo.world({"step": 0.002, "bodies": [
            tets(), marble(position=[0.1, 0.05, 0.14], velocity=[0, 0, -1])]})
        before = w.momenta("block")[0] + w.momenta("marble")[0]
        np.testing.assert_allclose(before, (0, 0, -0.5))
        w.step(60)
        self.assertGreater(w.contacts("block") + w.contacts("marble"), 0)
        self.assertLess(w["block"].linear_momentum[2], -0.05)
        np.testing.assert_allclose(w.momenta("block")[0] + w.momenta("marble")[0], before, atol=1e-6)  # of the solves

    def test_of_a_file_are_those_of_its_dict(self):
        scene = self.on_a_floor()
        path = os.path.join(support.folder(), "mixed.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(tremolo.scene_text(scene))
        one, other = tremolo.world(scene), tremolo.load_scene(path)
        self.assertIsInstance(other, tremolo.World)
        for w in (one, other):
            w.step(20)
        np.testing.assert_array_equal(one["block"].points, other["block"].points)

    def test_of_a_copy_a_pickle_and_a_saved_state_go_on_with_the_same_bits(self):
        scene = self.on_a_floor()
        w = tremolo.world(scene)
        w.step(20)
        saved, copied, pickled = w.save(), copy.copy(w), pickle.loads(pickle.dumps(w))
        restored = tremolo.world(scene)
        restored.restore(saved)
        for other in (copied, pickled, restored):
            self.assertEqual(other.steps, 20)
        w.step(30)
        for other in (copied, pickled, restored):
            other.step(30)
            self.assertEqual(other.save(), w.save())
            np.testing.assert_array_equal(other["block"].points, w["block"].points)
            self.assertEqual(other.account("block"), w.account("block"))
        with self.assertRaises(tremolo.ContentError):
            w.restore(saved[:-1])

    def test_refuse_what_the_engine_does_not_have(self):
        scene = self.on_a_floor()
        w = tremolo.world(scene)
        with self.assertRaisesRegex(tremolo.UsageError, "bodies of other kinds"):
            w.set_step(0.001)
        with self.assertRaisesRegex(tremolo.UsageError, "block"):
            w.set_method("block", "ep2")
        with self.assertRaisesRegex(tremolo.ContentError, "vertex 99999 is not in the mesh"):
            tremolo.world({**scene, "hands": [{"body": "block", "at": "vertex:99999", "pin": True}]})
        with self.assertRaisesRegex(tremolo.ContentError, "inside collider 'floor'"):
            tremolo.world({**scene, "bodies": [tets(position=[0, 0, -0.05]), scene["bodies"][1]]})
        with self.assertRaisesRegex(tremolo.ContentError, "two bodies are called 'block'"):
            tremolo.world({**scene, "bodies": [tets(), tets(), scene["bodies"][1]]})
        with self.assertRaisesRegex(tremolo.ContentError, "creep"):
            tremolo.world({**scene, "bodies": [tets(creep=0.1), scene["bodies"][1]]})
        with self.assertRaisesRegex(tremolo.FileError, "tremolo-precompute tets"):
            tremolo.world({**scene, "bodies": [tets(model="/nowhere.tets"), scene["bodies"][1]]})

    def test_name_a_body_whose_step_cannot_be_solved(self):
        w = tremolo.world({"step": 0.01, "bodies": [tets(), marble(position=[0, 0, 5])]})
        b = w["block"]
        before = b.points
        b.set_state(velocities=1e200 * np.random.default_rng(1).normal(size=before.shape))
        with self.assertRaisesRegex(tremolo.SolverError, "block: the step to t = 0.01 s could not be solved"):
            w.step(3)
        self.assertTrue(b.failed and w.failed("block"))
        np.testing.assert_array_equal(b.points, before)
        w.step()  # it is not stepped again
        np.testing.assert_array_equal(b.points, before)


class WorldsWithCloth(unittest.TestCase):
    def on_a_box(self):
        return {"step": 0.002, "duration": 0.4, "gravity": [0, 0, -G],
                "bodies": [{"name": "table", "kind": "rigid", "mass": 1, "shape": "box", "half-extents": [0.1, 0.1, 0.1],
                            "position": [0, 0, 0.1003]},
                           sheet(kind="cloth", corner=[-0.25, -0.2, 0.206])],
                "colliders": [{"name": "floor", "shape": "plane"}]}

    def test_are_those_of_the_program(self):
        w = tremolo.load_scene(self.on_a_box())
        self.assertIsInstance(w, tremolo.World)
        self.assertEqual(w.names, ["table", "sheet"])
        w.step(200)
        reported = report_of(self.on_a_box())["bodies"][1]
        account = w.account("sheet")
        self.assertEqual(account["total"], reported["energy_final"])
        for cause, key in (("contact_given", "contact"), ("friction", "friction"), ("restitution", "restitution")):
            self.assertEqual(account[cause], reported["energy_by_cause"][key])
        self.assertEqual(w["sheet"].kind, "cloth")
        self.assertEqual(w["sheet"].positions().shape, (30, 3))
        self.assertGreater(w.contacts("sheet"), 0)
        # Its middle lies on the box, its corners hang beside it.
        self.assertGreater(w["sheet"].positions()[:, 2].max(), 0.2)
        self.assertLess(w["sheet"].positions()[:, 2].min(), 0.2)

    def test_hang_on_grabs(self):
        """Two grabs carry the sheet: their springs are extended by half its weight each."""
        w = tremolo.world({**self.on_a_box(), "bodies": [marble(position=[9, 0, 0.5]), sheet(
            kind="cloth", corner=[-0.25, -0.2, 1.0], across=[0, 0, 1], density=0.5, structural=[200, 0.05])]})
        b = w["sheet"]
        top = [int(np.argmin(np.linalg.norm(b.positions() - corner, axis=1))) for corner in
               ([-0.25, -0.2, 1.4], [0.25, -0.2, 1.4])]
        places = b.positions()[top]
        grabs = [b.grab(vertex, stiffness=20.0, damping=0.5) for vertex in top]
        w.step(3000)
        drop = places[:, 2] - b.positions()[top][:, 2]
        self.assertAlmostEqual(drop.sum(), b.mass * G / 20.0, delta=0.02 * b.mass * G / 20.0)
        for number, place in zip(grabs, places):
            b.move_grab(number, place + (0, 0, 0.1))
        w.step(3000)
        self.assertAlmostEqual((places[:, 2] + 0.1 - b.positions()[top][:, 2]).sum(), drop.sum(), delta=0.02 * drop.sum())
        for number in grabs:
            b.release(number)
        for call in (lambda: b.release(grabs[0]), lambda: b.move_grab(5, places[0]), lambda: b.grab(99),
                     lambda: b.grab(0, stiffness=-1.0)):
            with self.assertRaises(tremolo.UsageError):
                call()
        before, v = b.energy["gravity"] / (b.mass * G), b.linear_momentum[2] / b.mass
        w.step(50)
        self.assertAlmostEqual(b.energy["gravity"] / (b.mass * G) - before, v * 0.1 - 0.5 * G * 0.01, delta=0.02)


class ScenesOfTetrahedra(unittest.TestCase):
    def scene(self, **more):
        return {"step": 0.01, "duration": 0.3, "gravity": [0, 0, -G], "bodies": [tets(position=[0, 0, 0.05], **more)],
                "colliders": [{"name": "floor", "shape": "plane"}]}

    def test_are_those_of_the_program(self):
        s = tremolo.load_scene(self.scene())
        self.assertIsInstance(s, tremolo.NodalScene)
        self.assertEqual((s.kind, s.names, len(s), s.duration, s.step_size), ("tets", ["block"], 1, 0.3, 0.01))
        s.step(30)
        self.assertEqual((s.steps, s.time), (30, 0.3))
        known = report_of(self.scene())
        energy = s.energy
        for key, name in (("kinetic", "kinetic"), ("potential", "elastic"), ("gravity", "gravity")):
            self.assertEqual(energy[key], known["energies_final"][name])
            self.assertEqual(s["block"].energy[key], energy[key])
        np.testing.assert_array_equal(s["block"].linear_momentum, known["bodies"][0]["linear_momentum_final"])
        self.assertEqual(energy["total"], sum(energy[k] for k in ("kinetic", "potential", "gravity", "contact")))
        self.assertEqual(s.colliders[0]["shape"], "plane")
        np.testing.assert_array_equal(s.linear_momentum, s["block"].linear_momentum)

    def test_pull_a_grabbed_vertex_and_release_it(self):
        s = tremolo.load_scene({"step": 0.01, "bodies": [tets(drag=5.0)]})
        b = s["block"]
        at = b.positions()[0]
        number = b.grab(0)
        for k in range(1, 301):
            b.move_grab(number, at + (0, 0, min(0.001 * k, 0.1)))
            s.step()
        # At rest nothing pulls: the vertex is where the grab is.
        np.testing.assert_allclose(b.positions()[0], at + (0, 0, 0.1), atol=2e-3)
        with self.assertRaisesRegex(tremolo.UsageError, "release it first"):
            b.grab(1)
        b.release(number)
        for call in (lambda: b.release(number), lambda: b.move_grab(number, at), lambda: b.release(-1)):
            with self.assertRaisesRegex(tremolo.UsageError, "no grab"):
                call()
        number = b.grab(3, stiffness=100.0, damping=1.0)
        for stiffness in (-1.0, np.nan):
            b.release(number) if number is not None else None
            number = None
            with self.assertRaises(tremolo.UsageError):
                b.grab(3, stiffness=stiffness, damping=0.0)
        s.step(10)

    def test_sleep_and_wake(self):
        s = tremolo.load_scene({**self.scene(beta=0.01), "sleep-time": 0.1, "sleep-speed": 0.05})
        b = s["block"]
        for _ in range(300):
            s.step()
            if b.asleep:
                break
        self.assertTrue(b.asleep)
        self.assertLessEqual(s.energy["sleep"], 0.0)
        b.set_state(velocities=np.broadcast_to((0.0, 0.0, 1.0), b.points.shape))
        self.assertFalse(b.asleep)
        before = b.points[0, 2]
        s.step()
        self.assertGreater(b.points[0, 2], before)

    def test_hold_fixed_vertices(self):
        s = tremolo.load_scene({"step": 0.01, "gravity": [0, 0, -G],
                                "bodies": [tets(model=block(("x<0.001",)))]})
        b = s["block"]
        rest = b.points
        self.assertTrue(b.held.any())
        s.step(20)
        np.testing.assert_array_equal(b.points[b.held], rest[b.held])
        self.assertGreater(np.abs(b.points - rest).max(), 1e-3)


class ScenesOfCloths(unittest.TestCase):
    def test_fall_as_gravity_says(self):
        s = tremolo.load_scene({"step": 0.01, "integrator": "midpoint", "gravity": [0, 0, -G], "cloths": [sheet()]})
        self.assertEqual((s.kind, s.names, s["sheet"].kind), ("cloth", ["sheet"], "cloth"))
        b = s["sheet"]
        s.step(50)
        # The midpoint rule has the parabola; 1e-12 m is the tolerance of its solves.
        np.testing.assert_allclose(b.positions()[:, 2], -G * 0.5**2 / 2, atol=1e-11)
        np.testing.assert_allclose(b.velocities(), np.broadcast_to((0, 0, -G * 0.5), (30, 3)), atol=1e-10)
        self.assertAlmostEqual(b.mass, 0.2 * 0.5 * 0.4)
        np.testing.assert_allclose(s.linear_momentum, (0, 0, -b.mass * G * 0.5), atol=1e-11)
        np.testing.assert_allclose(b.angular_momentum, s.angular_momentum, atol=1e-12)

    def test_balance_their_energy(self):
        s = tremolo.load_scene({"step": 0.01, "integrator": "energy", "gravity": [0, 0, -G],
                                "cloths": [sheet(pins=["top-left", "top-right"])]})
        start = s.energy["total"]
        s.step(100)
        e = s.energy
        given = e["damping"] + e["wind"] + e["pins"] + e["contact_given"] + e["method"]
        self.assertLess(e["damping"], 0.0)
        self.assertAlmostEqual(e["total"] - start, given, delta=1e-9)  # of the solves' tolerance
        own = s["sheet"].energy
        for key in ("kinetic", "potential", "gravity"):
            self.assertAlmostEqual(own[key], e[key], delta=1e-12)

    def test_are_those_of_the_program(self):
        scene = {"step": 0.01, "duration": 0.5, "gravity": [0, 0, -G],
                 "cloths": [sheet(corner=[-0.25, -0.2, 0.35])],
                 "balls": [{"name": "ball", "radius": 0.1, "position": [0, 0, 0.2], "mass": 1.0}],
                 "colliders": [{"name": "floor", "shape": "plane"}]}
        s = tremolo.load_scene(scene)
        s.step(50)
        known = report_of(scene)
        for key, name in (("kinetic", "kinetic_final"), ("potential", "elastic_final"), ("gravity", "gravity_final")):
            self.assertEqual(s.energy[key], known[name])
        for key, name in (("contact_given", "contact"), ("damping", "damping"), ("pins", "support")):
            self.assertEqual(s.energy[key], known["energy_by_cause"][name])
        ball, = s.balls
        self.assertEqual((ball["name"], ball["radius"]), ("ball", 0.1))
        for key in ("position", "velocity", "spin"):
            np.testing.assert_array_equal(ball[key], known["balls"][0][key])

    def test_hold_a_grabbed_particle(self):
        s = tremolo.load_scene({"step": 0.01, "gravity": [0, 0, -G], "cloths": [sheet()]})
        b = s["sheet"]
        number = b.grab(7)
        self.assertTrue(b.held[7])
        s.step(10)
        np.testing.assert_allclose(b.positions()[7], b.points[7])
        self.assertEqual(b.points[7, 2], 0.0)
        b.move_grab(number, (0.1, 0.1, 0.3))
        s.step()
        np.testing.assert_allclose(b.points[7], (0.1, 0.1, 0.3), atol=1e-12)
        with self.assertRaises(tremolo.UsageError):
            b.grab(7)
        with self.assertRaises(tremolo.UsageError):
            b.grab(8, stiffness=1.0)
        b.release(number)
        self.assertFalse(b.held[7])
        with self.assertRaises(tremolo.UsageError):
            b.release(number)


class Arrays(unittest.TestCase):
    def setUp(self):
        self.scene = tremolo.load_scene({"step": 0.01, "cloths": [sheet()]})
        self.body = self.scene["sheet"]

    def test_of_positions_are_written_in_both_types(self):
        b = self.body
        out = np.empty((30, 3))
        self.assertIs(b.positions(out=out), out)
        small = b.positions(np.empty((30, 3), dtype=np.float32))
        np.testing.assert_array_equal(small, out.astype(np.float32))
        self.assertEqual(b.positions(dtype=np.float32).dtype, np.float32)
        for wrong in (np.zeros((29, 3)), np.zeros((30, 3), order="F"), np.zeros((30, 3), dtype=int), 3):
            with self.assertRaises((ValueError, TypeError)):
                b.positions(out=wrong)

    def test_of_states_are_checked(self):
        b = self.body
        x, bad = b.points, b.points
        bad[3, 1] = np.nan
        for wrong in (x[:-1], x[:, :2], bad, x.ravel(), "text", x.astype(complex), np.zeros((0, 3))):
            with self.assertRaises((ValueError, TypeError)):
                b.set_state(wrong)
            with self.assertRaises((ValueError, TypeError)):
                b.set_state(velocities=wrong)
        np.testing.assert_array_equal(b.points, x)
        b.set_state(x.astype(np.float32).astype(float)[:, ::1], np.asfortranarray(np.ones_like(x)))
        np.testing.assert_array_equal(b.point_velocities, np.ones_like(x))

    def test_are_copies(self):
        x = self.body.points
        x[:] = 7.0
        self.assertLess(self.body.points.max(), 1.0)

    def test_of_vertices_end(self):
        for vertex in (-1, 30, 2**40):
            with self.assertRaises(tremolo.UsageError):
                self.body.grab(vertex)
        for wrong in (1.5, "0", None):
            with self.assertRaises(TypeError):
                self.body.grab(wrong)
        for position in ((0, 0), (0, 0, np.nan), "up"):
            with self.assertRaises((ValueError, TypeError)):
                self.body.move_grab(0, position)


class Scenes(unittest.TestCase):
    def test_outlive_their_names_through_their_bodies(self):
        b = tremolo.load_scene({"step": 0.01, "cloths": [sheet()]})["sheet"]
        self.assertEqual(b.positions().shape, (30, 3))

    def test_that_are_wrong_are_refused_with_the_reason(self):
        good = {"step": 0.01, "cloths": [sheet()]}
        for scene, words in (({**good, "bodies": [tets()]}, "do not go together"), ({**good, "colour": 1}, "colour"),
                             ({"bar": {"model": "a.tremolo"}}, "a table for each body"), ({}, "a table for each body"),
                             ({**good, "cloths": [sheet(rows=1)]}, "row"), ({**good, "step": 0.0}, "step"),
                             ({"bodies": [tets(degree="cubic")]}, "cubic")):
            with self.assertRaisesRegex(tremolo.ContentError, words):
                tremolo.load_scene(scene)
        with self.assertRaisesRegex(tremolo.ContentError, "cloths"):
            tremolo.world(good)
        with self.assertRaises(tremolo.FileError):
            tremolo.load_scene("/nowhere/scene.toml")
        for thing in (None, 3, [("step", 1)]):
            with self.assertRaises(TypeError):
                tremolo.load_scene(thing)

    def test_are_neither_made_nor_copied(self):
        s = tremolo.load_scene({"step": 0.01, "cloths": [sheet()]})
        for thing in (s, s["sheet"]):
            for call in (pickle.dumps, copy.copy, copy.deepcopy):
                with self.assertRaisesRegex(TypeError, "neither copied nor pickled"):
                    call(thing)
            with self.assertRaisesRegex(TypeError, "has no constructor"):
                type(thing)()
        for name in ("bear", 1, -1):
            with self.assertRaises(tremolo.UsageError):
                s.body(name)
        for name in (None, 1.0):
            with self.assertRaises(TypeError):
                s.body(name)
        for n in (-1, 1.5, None):
            with self.assertRaises((ValueError, TypeError)):
                s.step(n)

    def test_are_used_by_one_thread_at_a_time(self):
        s = tremolo.load_scene({"step": 0.001, "gravity": [0, 0, -G], "cloths": [sheet(pins=["top"])]})
        b = s["sheet"]
        worker = threading.Thread(target=s.step, args=(1000,))
        refused = 0
        worker.start()
        while worker.is_alive():
            for call in (s.step, b.positions, lambda: s.energy, lambda: b.points):
                try:
                    call()
                except tremolo.UsageError as error:
                    self.assertIn("used by another call", str(error))
                    refused += 1
        worker.join()
        self.assertGreater(refused, 0)


if __name__ == "__main__":
    unittest.main()
