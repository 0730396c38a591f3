"""tremolo.World: scenes of dicts and files, contact, events, saving."""

import copy
import os
import pickle
import tempfile
import unittest

import numpy as np

import support
import tremolo


def dropped(**more):
    """A free bar that falls on a floor from 2 cm."""
    return {
        "step": 0.003,
        "gravity": [0.0, 0.0, -9.81],
        "bodies": [{"name": "bar", "model": support.file_of(support.free_bar(), "free.tremolo"), "kind": "free",
                    "beta": 1e-3, "position": [0.0, 0.0, 0.02], **more}],
        "colliders": [{"name": "floor", "shape": "plane", "friction": 0.4, "restitution": 0.3}],
    }


class Worlds(unittest.TestCase):
    def test_of_a_dict_and_of_its_file_are_the_same(self):
        scene = dropped()
        one = tremolo.world(scene)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(tremolo.scene_text(scene))
            other = tremolo.world(path)
        for w in (one, other):
            w.step(50)
        np.testing.assert_array_equal(one["bar"].q, other["bar"].q)
        self.assertEqual(one.names, ["bar"])
        self.assertEqual(len(one), 1)
        self.assertEqual(one.time, 50 * 0.003)

    def test_report_contact_and_balance_the_energy(self):
        w = tremolo.world(dropped())
        events = []
        for _ in range(100):
            w.step()
            events += w.events
            for event in w.events:
                if event["kind"] == "begin":
                    points = w.contact_points("bar", "floor")
                    self.assertGreater(len(points), 0)
                    for point in points:
                        np.testing.assert_allclose(point["normal"], (0, 0, 1), atol=1e-12)
        first = events[0]
        self.assertEqual((first["kind"], first["body"], first["other"]), ("begin", "bar", "floor"))
        # It falls 2 cm less the margin, half a per cent of its size.
        self.assertAlmostEqual(first["time"], np.sqrt(2 * 0.02 / 9.81), delta=0.01)
        np.testing.assert_allclose(first["normal"], (0, 0, 1), atol=1e-12)
        account = w.account("bar")
        self.assertLess(account["friction"] + account["restitution"] + account["damping"], 0.0)
        exchanged = abs(account["gravity"]) + account["total"]
        self.assertLess(abs(account["remainder"]), 1e-8 * exchanged)  # of the solves' tolerance
        self.assertGreater(w.contacts("bar"), 0)

    def test_in_parts_have_the_events_of_the_whole(self):
        one, other = tremolo.world(dropped()), tremolo.world(dropped())
        one.step(60)
        parts = []
        for _ in range(6):
            other.step(10)
            parts += other.events
        self.assertEqual([e["time"] for e in one.events], [e["time"] for e in parts])

    def test_continue_with_the_same_bits_after_copies_and_pickles(self):
        w = tremolo.world(dropped())
        w.step(30)
        saved = w.save()
        others = [copy.copy(w), copy.deepcopy(w), pickle.loads(pickle.dumps(w)), tremolo.world(dropped())]
        others[-1].restore(saved)
        w.step(30)
        for other in others:
            other.step(30)
            np.testing.assert_array_equal(other["bar"].q, w["bar"].q)
            np.testing.assert_array_equal(other["bar"].pose[0], w["bar"].pose[0])
        with self.assertRaises(tremolo.ContentError):
            w.restore(saved[:50])
        with self.assertRaises(tremolo.ContentError):
            tremolo.world(dropped(beta=0.5)).restore(saved)
        make, (state,) = w.__reduce__()
        with self.assertRaisesRegex(tremolo.ContentError, "of version 9, not 2"):
            make((state[0], 9, *state[2:]))

    def test_do_not_depend_on_threads(self):
        one, other = tremolo.world(dropped()), tremolo.world(dropped())
        other.set_threads(2)
        one.step(40)
        other.step(40)
        np.testing.assert_array_equal(one["bar"].q, other["bar"].q)

    def test_hold_bodies_together_by_joints_and_by_hands(self):
        scene = dropped()
        scene["bodies"].append({**scene["bodies"][0], "name": "other", "position": [0.0, 0.2, 0.02]})
        scene["joints"] = [{"body": "bar", "at": "vertex:0", "to": "other", "to-at": "vertex:0", "length": 0.2,
                            "stiffness": 500.0, "damping": 1.0}]
        scene["hands"] = [{"body": "bar", "at": "vertex:80", "pin": True}]
        w = tremolo.world(scene)
        w.step(50)
        joint, = w.joints
        self.assertTrue(joint["holds"])
        self.assertTrue(np.isfinite(joint["force"]).all())
        hand, = w.hands
        self.assertGreater(hand["force"][2], 0.0)
        self.assertEqual(hand["vertex"], 80)

    def test_name_their_colliders_and_hits(self):
        w = tremolo.world(dropped())
        w.step()
        floor, = w.colliders
        self.assertEqual((floor["name"], floor["shape"]), ("floor", "plane"))
        hit = w.pick((0.2, 0.04, 1.0), (0.0, 0.0, -1.0))
        self.assertEqual(hit["body"], "bar")
        self.assertIsNone(w.pick((5.0, 5.0, 5.0), (0.0, 0.0, 1.0)))

    def test_tell_of_contacts_of_every_kind(self):
        """A sheet that falls on a slab: one event of both, whose points have the force of the contact."""
        w = tremolo.world({**dropped(), "bodies": [
            {"name": "slab", "kind": "rigid", "shape": "box", "half_extents": [0.1, 0.1, 0.02], "mass": 1.0,
             "position": [0.0, 0.0, 0.02]},
            {"name": "sheet", "kind": "cloth", "columns": 7, "rows": 7, "width": 0.06, "height": 0.06,
             "corner": [-0.03, -0.03, 0.08], "thickness": 0.002, "density": 1.0}]})
        begun = []
        for _ in range(200):
            w.step()
            begun += [e for e in w.events if e["kind"] == "begin" and e["with_body"]]
            if begun:
                break
        self.assertEqual({begun[0]["body"], begun[0]["other"]}, {"slab", "sheet"})
        there, back = w.contact_points("sheet", "slab"), w.contact_points("slab", "sheet")
        self.assertGreater(len(there), 0)
        np.testing.assert_array_equal(sum(p["impulse"] for p in there), -sum(p["impulse"] for p in back))
        account = w.account("sheet")
        self.assertLess(abs(account["remainder"]), 1e-12)
        self.assertLess(account["damping"] + account["method"], 0.0)
        hit = w.pick((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))  # through a vertex
        self.assertEqual(hit["body"], "sheet")
        self.assertAlmostEqual(sum(hit["weights"]), 1.0, delta=1e-12)

    def test_move_colliders_by_calls(self):
        """A floor that rises by 5 mm lifts what lies on it."""
        w = tremolo.world(dropped())
        w.step(500)
        before = w["bar"].positions().mean(axis=0)[2]
        for k in range(100):
            w.move_collider("floor", (0.0, 0.0, 5e-5 * (k + 1)))
            w.step()
        w.step(300)
        self.assertAlmostEqual(w["bar"].positions().mean(axis=0)[2] - before, 5e-3, delta=2e-4)
        with self.assertRaises(tremolo.UsageError):
            w.move_collider("ceiling", (0.0, 0.0, 0.0))
        with self.assertRaises(tremolo.UsageError):
            w.move("bar", (0.0, 0.0, 0.0))  # it is free


class BodiesOfWorlds(unittest.TestCase):
    def test_are_stepped_and_written_through_their_handles(self):
        w = tremolo.world(dropped())
        b = w.body("bar")
        self.assertIs(w.body("bar"), b)
        self.assertIs(w[0], b)
        p = b.p
        b.p[0] = 0.05
        w.step()
        self.assertNotEqual(p[0], 0.05)
        self.assertNotEqual(b.q[0], 0.0)
        b.apply_force("x>0.399", (0.0, 0.0, 1.0), steps=5)
        w.step(5)
        self.assertNotEqual(w.account("bar")["load"], 0.0)

    def test_take_what_is_written_without_being_kept(self):
        ends = []
        for write in (lambda w: w["bar"], lambda w: w["bar"].q, lambda w: None):
            w = tremolo.world(dropped())
            kept = write(w)
            (w["bar"].q if kept is None else kept if isinstance(kept, np.ndarray) else kept.q)[0] = 1e-3
            w.step()
            ends.append(w["bar"].q.copy())
        self.assertGreater(abs(ends[0][0]), 1e-4)
        for end in ends[1:]:
            np.testing.assert_array_equal(end, ends[0])

    def test_wake_where_they_are_moved(self):
        scene = {"step": 0.002, "gravity": [0, 0, -9.81],
                 "bodies": [{"name": "box", "kind": "rigid", "shape": "box", "half-extents": [0.1, 0.1, 0.1],
                             "position": [0, 0, 0.1]}],
                 "colliders": [{"name": "floor", "shape": "plane"}]}
        w = tremolo.world(scene)
        w.step(1000)
        self.assertTrue(w.asleep("box"))
        w["box"].set_motion((1.0, 0.0, 3.0))
        w.step(100)
        self.assertFalse(w.asleep("box"))
        np.testing.assert_allclose(w["box"].pose[0], (0.2, 0.0, 0.1 + 0.6 - 0.5 * 9.81 * 0.04), atol=1e-3)

    def test_keep_the_world_alive(self):
        b = tremolo.world(dropped()).body("bar")
        positions = b.positions()
        self.assertAlmostEqual(positions[:, 2].min(), 0.02)

    def test_belong_to_it(self):
        w = tremolo.world(dropped())
        b = w["bar"]
        for call in (b.step, b.clear_loads, lambda: b.add_load(reduced=np.zeros(6)), lambda: copy.copy(b),
                     lambda: setattr(b, "gravity", (0, 0, 1)), lambda: b.set_method("ep2", 0.01)):
            with self.assertRaisesRegex(tremolo.UsageError, "belongs to a world"):
                call()

    def test_that_are_driven_follow_python(self):
        scene = {"step": 0.002, "bodies": [{
            "name": "held", "model": support.file_of(support.clamped_bar(), "bar.tremolo"), "kind": "driven"}]}
        w = tremolo.world(scene)
        b = w["held"]
        for k in range(1, 51):
            b.move_to((0.0, 0.0, 0.001 * k))
            w.step()
        self.assertAlmostEqual(b.pose[0][2], 0.05)
        self.assertGreater(np.abs(b.q).max(), 0.0)


class WrongScenes(unittest.TestCase):
    def test_are_refused_with_the_key(self):
        base = dropped()
        body = base["bodies"][0]
        for scene, words in (
                ({**base, "colour": 1}, "colour"),
                ({**base, "step": 0.0}, "step"),
                ({**base, "step": float("nan")}, "step"),
                ({**base, "bodies": []}, "bod"),
                ({}, "bod"),
                ({**base, "bodies": [body, body]}, "bar"),
                ({**base, "bodies": [{**body, "integrator": "magic"}]}, "magic"),
                ({**base, "bodies": [{**body, "position": [0, 0]}]}, "position"),
                ({**base, "bodies": [{**body, "position": [0, 0, -1.0]}]}, "floor")):
            with self.assertRaisesRegex(tremolo.ContentError, words):
                tremolo.world(scene)
        with self.assertRaises(tremolo.FileError):
            tremolo.world({**base, "bodies": [{**body, "model": "/nowhere.tremolo"}]})
        for thing in (None, 3, [("step", 1)], {**base, 3: 4}, {**base, "step": None}, {**base, "step": object()}):
            with self.assertRaises(TypeError):
                tremolo.world(thing)
        with self.assertRaises(tremolo.FileError):
            tremolo.world("/nowhere/scene.toml")

    def test_have_no_other_bodies(self):
        w = tremolo.world(dropped())
        for name in ("bear", 1, -1):
            with self.assertRaises(tremolo.UsageError):
                w.body(name)
        for name in (None, 1.0, ["bar"]):
            with self.assertRaises(TypeError):
                w.body(name)
        with self.assertRaises(tremolo.UsageError):
            w.contact_points("bar", "ceiling")
        with self.assertRaises(tremolo.UsageError):
            w.step(-1)


class Recorders(unittest.TestCase):
    def test_write_what_other_programs_read(self):
        b = support.clamped_bar().body()
        b.q[0] = 0.03
        recorder = tremolo.recorder(rate=30.0)
        recorder.add(b, "bar")
        for _ in range(5):
            recorder.frame()
            b.step(10)
        self.assertEqual(recorder.frames, 5)
        with tempfile.TemporaryDirectory() as folder:
            for ending in ("glb", "usda", "pvd", "pc2", "mdd", "obj", "html"):
                for path in recorder.write(os.path.join(folder, "motion." + ending)):
                    self.assertGreater(os.path.getsize(path), 0, path)
            with open(os.path.join(folder, "motion.pc2"), "rb") as file:
                data = file.read()
            # The last frame of the cache is the surface then, in float.
            last = np.frombuffer(data[-12 * len(b.model.vertices):], dtype="<f4").reshape(-1, 3)
            again = b.model.body()
            again.q[0] = 0.03
            again.step(40)
            np.testing.assert_allclose(last, again.positions(), atol=1e-6)
            with self.assertRaises(tremolo.UsageError):
                recorder.write(os.path.join(folder, "motion.mov"))
            with self.assertRaises(TypeError):
                recorder.write(3)

    def test_refuse_wrong_orders(self):
        recorder = tremolo.recorder()
        with self.assertRaises(tremolo.UsageError):
            recorder.frame()
        b = support.clamped_bar().body()
        recorder.add(b, "bar")
        with self.assertRaises(tremolo.UsageError):
            recorder.add(b, "bar")
        recorder.frame(1.0)
        with self.assertRaises(tremolo.UsageError):
            recorder.frame(0.5)


if __name__ == "__main__":
    unittest.main()
