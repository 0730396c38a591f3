"""Worlds whose bodies, colliders and joints come and go while they run."""

import copy
import gc
import pickle
import unittest

import numpy as np

import support
import tremolo
from nodal_test import G, marble, sheet, tets

STEP = 0.004


def shelf(**more):
    """A rigid plate whose top is at z = 0.02."""
    return {"name": "shelf", "kind": "rigid", "shape": "box", "half-extents": [0.3, 0.3, 0.01], "mass": 5.0,
            "position": [0.0, 0.0, 0.01], **more}


def bar(**more):
    return {"name": "bar", "model": support.file_of(support.free_bar(), "free.tremolo"), "kind": "free", "beta": 1e-3,
            **more}


def cloth(**more):
    return sheet(kind="cloth", thickness=0.002, **more)


def floor():
    return {"name": "floor", "shape": "plane", "friction": 0.5}


def scene(*bodies, **more):
    return {"step": STEP, "gravity": [0, 0, -G], "bodies": list(bodies), **more}


def snapshot(world):
    """All positions, velocities and energies, as bytes."""
    values = []
    for name in world.names:
        body = world[name]
        values += [body.positions(), body.velocities(), np.array(list(world.account(name).values()))]
    return [value.tobytes() for value in values]


def heights(world, name):
    """Height of the centre of mass and its velocity, from energy and momentum."""
    body = world[name]
    if isinstance(body, tremolo.NodalBody):
        return body.energy["gravity"] / (body.mass * G), body.linear_momentum[2] / body.mass
    return body.pose[0][2], body.velocity[2]


class BodiesThatGo(unittest.TestCase):
    def test_let_fall_what_stood_on_them(self):
        """A ball, a block of tetrahedra and a sheet lie on a plate, which is removed: they fall by g t^2 / 2."""
        for fallen in (marble(position=[0.0, 0.0, 0.0505]), tets(position=[-0.1, -0.05, 0.0205], integrator="midpoint"),
                       cloth(corner=[-0.25, -0.2, 0.0225], integrator="midpoint")):
            w = tremolo.world(scene(shelf(), fallen, colliders=[floor()]))
            w.step(100)
            plate = w["shelf"]
            before = w.contact_points(fallen["name"], "shelf")
            self.assertGreater(len(before), 0)
            w.remove(plate)
            w.remove_collider("floor")
            self.assertEqual((w.names, w.colliders, len(w)), ([fallen["name"]], [], 1))
            z, v = heights(w, fallen["name"])
            w.step(50)
            t = 50 * STEP
            now, speed = heights(w, fallen["name"])
            self.assertAlmostEqual(now - z, v * t - 0.5 * G * t * t, delta=1e-7)
            self.assertAlmostEqual(speed - v, -G * t, delta=1e-7)
            self.assertEqual(w.events, [])

    def test_leave_objects_that_refuse_every_call(self):
        w = tremolo.world(scene(marble(), tets(position=[0, 0, 1]), cloth(corner=[1, 1, 1]), bar(position=[2, 0, 0])))
        w.step(3)
        for name in ("marble", "block", "sheet", "bar"):
            body = w[name]
            kept = body.q if isinstance(body, tremolo.Body) else None
            w.remove(name)
            w.step()
            if kept is not None:
                kept[:] = 1.0  # an array of numpy, which is of no body
            self.assertIn("removed", repr(body))
            for key in dir(body):
                if key.startswith("_") or key in ("model", "report"):
                    continue
                with self.assertRaisesRegex(tremolo.UsageError, f"'{name}' has been removed from its world", msg=key):
                    value = getattr(body, key)
                    calls = {"position": (0,), "displacement": (0,), "pick": ((0, 0, 1), (0, 0, -1)), "step": (1,),
                             "apply_force": (0, (0, 0, 1)), "grab": (0, 1.0) if kept is not None else (0,), "pin": (0,), "move_grab": (0, (0, 0, 0)),
                             "grab_force": (0,), "release": (0,), "restore": (b"",), "set_pose": ((0, 0, 0),),
                             "move_to": ((0, 0, 0),), "set_motion": ((0, 0, 0),), "set_method": ("ep4", 0.01)}
                    value(*calls.get(key, ()))
            for call in (w.failed, w.remove, w.momenta, w.account, lambda b: w.move(b, (0, 0, 0))):
                with self.assertRaisesRegex(tremolo.UsageError, "has been removed"):
                    call(body)
            with self.assertRaisesRegex(tremolo.UsageError, f"no body '{name}'"):
                w.body(name)
        self.assertEqual(w.names, [])
        w.step(5)

    def test_do_not_come_back_as_others_in_their_place(self):
        """The engine uses the place of a body that was removed again: its object is of no body all the same."""
        w = tremolo.world(scene(bar(), tets(position=[0, 0, 1])))
        old, old_block = w["bar"], w["block"]
        w.step()
        w.remove(old)
        w.remove(old_block)
        w.step()
        new = w.add(marble(name="bar"))
        new_block = w.add(cloth(corner=[1, 1, 1], name="block"))
        self.assertEqual(w.names, ["bar", "block"])
        self.assertIs(w["bar"], new)
        self.assertIs(w["block"], new_block)
        self.assertEqual((new_block.kind, len(new.q)), ("cloth", 0))
        w.step(5)
        for body in (old, old_block):
            with self.assertRaisesRegex(tremolo.UsageError, "has been removed"):
                body.positions()
            with self.assertRaisesRegex(tremolo.UsageError, "has been removed"):
                w.account(body)
        self.assertAlmostEqual(w.account(new)["kinetic"], 0.5 * 0.5 * (5 * STEP * G) ** 2, delta=1e-9)

    def test_may_go_before_their_world_and_their_arrays(self):
        w = tremolo.world(scene(bar(), marble(position=[1, 0, 0])))
        body, q = w["bar"], w["bar"].q
        w.remove("bar")
        del w
        gc.collect()
        q[0] = 3.0
        self.assertIn("removed", repr(body))
        self.assertEqual(body.model.modes, len(q))
        del body
        gc.collect()
        self.assertEqual(q[0], 3.0)

    def test_take_their_events_and_joints_along(self):
        w = tremolo.world(scene(marble(position=[0, 0, 0.0305]), bar(position=[1, 0, 1]), colliders=[floor()]))
        w.add_joint({"body": "bar", "at": "vertex:0", "to": "world"})
        while not w.events:
            w.step()
        self.assertEqual(w.events[0]["body"], "marble")
        w.remove("marble")
        self.assertEqual(w.events, [])
        self.assertTrue(w.joints[0]["holds"])
        w.remove("bar")
        self.assertFalse(w.joints[0]["holds"])
        w.step(3)


class BodiesThatCome(unittest.TestCase):
    def test_have_the_bits_of_those_of_the_scene(self):
        """A world that begins with a ball gets a bar, a block, a sheet, a collider and a joint; and one that has all."""
        bodies = [marble(name="a-ball", position=[0, 0, 0.04]), bar(position=[0, 0.3, 0.1]),
                  tets(position=[0.1, -0.3, 0.02]), cloth(corner=[-0.25, -0.2, 0.4], drag=0.1)]
        joint = {"body": "bar", "at": "vertex:0", "to": "sheet", "to_at": 0, "stiffness": 20.0, "damping": 0.1}
        whole = tremolo.world(scene(*bodies, colliders=[floor()], joints=[joint]))
        grown = tremolo.world(scene(bodies[0]))
        for body in bodies[1:]:
            grown.add(body)
        grown.add_collider(floor())
        self.assertEqual(grown.add_joint(joint), 0)
        self.assertEqual(grown.names, whole.names)
        for w in (whole, grown):
            w.step(80)
        self.assertGreater(whole.contacts("a-ball"), 0)
        self.assertGreater(whole.contacts("block"), 0)
        self.assertEqual(snapshot(whole), snapshot(grown))
        self.assertEqual(whole.save(), grown.save())

    def test_fall_from_where_they_are_added(self):
        w = tremolo.world(scene(marble()))
        w.step(10)
        ball = w.add(marble(name="late", position=[1, 0, 0]))
        w.step(25)
        t = 25 * STEP
        self.assertAlmostEqual(ball.pose[0][2], -0.5 * G * t * t, delta=1e-12)
        self.assertIs(w["late"], ball)
        self.assertIs(w[1], ball)

    def test_may_have_loads(self):
        """A constant force F on a body of mass m moves it by F t^2 / (2 m) from then on."""
        w = tremolo.world({**scene(marble()), "gravity": [0, 0, 0]})
        w.step(10)
        w.add_load("marble", {"load": "constant", "at": "x>-9", "force": [1.0, 0, 0], "scale": 0.5})
        w.step(50)
        t = 50 * STEP
        self.assertAlmostEqual(w["marble"].pose[0][0], 0.5 / 0.5 * t * t / 2, delta=1e-12)
        self.assertAlmostEqual(w.account("marble")["load"], 0.5 * 0.5 * t * t, delta=1e-12)
        sheet = w.add(cloth(corner=[1, 1, 1]))
        w.add_load("sheet", {"load": "constant", "at": "x>-9", "force": [0.2, 0, 0], "scale": 0.5})
        w.step(20)
        np.testing.assert_allclose(sheet.linear_momentum, [0.1 * 20 * STEP, 0, 0], atol=1e-9)
        w["sheet"].apply_force(3, [0, 0.4, 0], steps=5)
        w.step(10)
        np.testing.assert_allclose(sheet.linear_momentum, [0.1 * 30 * STEP, 0.4 * 5 * STEP, 0], atol=1e-9)
        self.assertGreater(w.account("sheet")["load"], 0.0)
        with self.assertRaisesRegex(tremolo.ContentError, "no particle 99"):
            w.add_load("sheet", {"load": "constant", "at": 99, "force": [1.0, 0, 0]})
        with self.assertRaisesRegex(tremolo.UsageError, "does not exist"):
            sheet.apply_force(99, [0, 0, 1])
        for load in ({"load": "magic"}, {"load": "none"}, {"load": "sine", "colour": 1},
                     {"load": "sine", "at": "x>9", "force": [0, 0, 1]}):
            with self.assertRaises(tremolo.ContentError):
                w.add_load("marble", load)

    def test_are_refused_with_the_reason_and_leave_the_world_as_it_was(self):
        w = tremolo.world(scene(marble(position=[0, 0, 0.1]), cloth(corner=[1, 1, 1]), colliders=[floor()]))
        w.step(2)
        before = snapshot(w)
        for body, words in ((marble(position=[1, 0, 0.1]), "two bodies are called 'marble'"),
                            (marble(name="b", position=[0, 0, 0.01]), "floor"),
                            (marble(name="b", position=[0, 0, 0.1]), "inside"),
                            (marble(name="b", position=[3, 0, 0.1], copies=[2, 1, 1]), "one by one"),
                            (marble(name="b", position=[3, 0, 0.1], colour=1), "colour"),
                            (tets(position=[0, 0, -0.05]), "floor"),
                            (bar(name="sheet", position=[3, 0, 1]), "two bodies are called 'sheet'"),
                            ({"name": "b"}, "model")):
            with self.assertRaisesRegex(tremolo.ContentError, words):
                w.add(body)
        with self.assertRaises(tremolo.FileError):
            w.add({**tets(), "model": "/nowhere.tets"})
        driven = {**bar(name="b", position=[3, 0, 1]), "kind": "driven",
                  "motion": [{"kind": "glide", "velocity": [1, 0, 0]}]}
        with self.assertRaisesRegex(tremolo.UsageError, "move it by calls"):
            w.add(driven)
        for collider, words in ((floor(), "two colliders"), ({**floor(), "name": "b", "position": [0, 0, 1]}, "inside"),
                                ({"name": "b", "shape": "cone"}, "cone")):
            with self.assertRaisesRegex(tremolo.ContentError, words):
                w.add_collider(collider)
        for joint in ({"body": "bear", "at": 0, "to": "world"}, {"body": "marble", "at": 0, "to": "bear"},
                      {"body": "marble", "at": 10 ** 6, "to": "world"}):
            with self.assertRaises(tremolo.ContentError):
                w.add_joint(joint)
        for call in (w.add, w.add_collider, w.add_joint, lambda load: w.add_load("marble", load)):
            for thing in (None, 3, "marble", [1]):
                with self.assertRaises(TypeError):
                    call(thing)
        for call in (lambda: w.remove("bear"), lambda: w.remove(7), lambda: w.remove_collider("ceiling"),
                     lambda: w.remove_joint(0), lambda: w.remove_joint(-1),
                     lambda: w.remove(tremolo.world(scene(marble()))["marble"])):
            with self.assertRaises(tremolo.UsageError):
                call()
        self.assertEqual(snapshot(w), before)
        self.assertEqual(w.joints, [])


class CollidersThatComeAndGo(unittest.TestCase):
    def test_catch_a_ball_and_let_it_fall(self):
        w = tremolo.world(scene(marble(position=[0, 0, 0.05])))
        w.add_collider(floor())
        w.step(400)
        at = w["marble"].pose[0][2]
        self.assertAlmostEqual(at, 0.03, delta=4e-4)  # within the margin
        w.remove_collider("floor")
        with self.assertRaisesRegex(tremolo.UsageError, "no collider 'floor'"):
            w.move_collider("floor", (0, 0, 1))
        w.add_collider({**floor(), "position": [0, 0, -0.5]})  # the name is free
        self.assertEqual([c["position"][2] for c in w.colliders], [-0.5])
        w.step(25)
        t = 25 * STEP
        self.assertAlmostEqual(w["marble"].pose[0][2], at - 0.5 * G * t * t, delta=1e-9)
        w.step(600)
        self.assertAlmostEqual(w["marble"].pose[0][2], -0.47, delta=4e-4)


class Filters(unittest.TestCase):
    def falling(self):
        return tremolo.world(scene(shelf(), marble(position=[0, 0, 0.1]), cloth(corner=[-0.25, -0.2, 0.2]),
                                   colliders=[floor()]))

    def test_let_bodies_pass_through_each_other(self):
        w = self.falling()
        asked = set()

        def apart(a, b):
            asked.add(frozenset((a, b)))
            return {a, b} != {"marble", "shelf"}

        w.set_filter(apart)
        w.step(200)
        self.assertIn(frozenset(("marble", "shelf")), asked)
        self.assertIn(frozenset(("sheet", "shelf")), asked)
        self.assertAlmostEqual(w["marble"].pose[0][2], 0.03, delta=4e-4)  # it lies on the floor, inside the shelf
        self.assertEqual(w.contact_points("marble", "shelf"), [])
        w.set_filter(None)
        other = self.falling()
        other.step(200)
        self.assertGreater(other["marble"].pose[0][2], 0.045)

    def test_raise_what_was_raised_in_them(self):
        w = self.falling()
        w.step(5)
        w.set_filter(lambda a, b: {}[a])
        steps = w.steps
        with self.assertRaises(KeyError):
            w.step(200)
        self.assertLess(w.steps, 205)
        self.assertGreater(w.steps, steps)
        w.set_filter(lambda a, b: w.step())
        with self.assertRaises(tremolo.UsageError):
            w.step(200)
        w.set_filter(lambda a, b: True)
        w.step(10)
        with self.assertRaises(TypeError):
            w.set_filter(3)


class CopiesOfChangedWorlds(unittest.TestCase):
    def changed(self):
        """A world in which each kind of change was made, some of them at places that others had left."""
        w = tremolo.world(scene(shelf(), marble(position=[0, 0, 0.0505]), colliders=[floor()]))
        w.step(30)
        w.add(bar(position=[0, 0.6, 0.05]))
        w.add(tets(position=[0.5, -0.3, 0.02]))
        w.step(40)
        w.add_joint({"body": "bar", "at": "vertex:0", "to": "world"})
        w.remove("marble")
        w.add(marble(name="late", position=[0, 0, 0.06]))  # before the next step: at a new place
        w.step(20)
        w.remove("block")
        w.add_collider({"name": "ball", "shape": "sphere", "radius": 0.1, "position": [2, 0, 0]})
        w.step(5)
        w.add(marble(position=[0.1, 0.1, 0.06]))
        w.add(tets(position=[0.5, -0.3, 0.02]))
        w.add(cloth(corner=[-0.25, -0.2, 0.5]))
        w.add_load("marble", {"load": "sine", "frequency": 3, "at": "x>-9", "force": [0.2, 0, 0]})
        w.step(5)
        w.add_joint({"body": "sheet", "at": 0, "to": "bar", "to_at": "vertex:80", "stiffness": 5.0, "length": 0.1})
        w.add_joint({"body": "marble", "at": 0, "to": "world"})
        w.remove_joint(2)
        w.move_collider("ball", (2, 0, 0.1))
        w.step(2)
        w.move_collider("ball", (2, 0, 0.2))
        w.set_method("bar", "ep2")
        return w

    def test_continue_with_the_same_bits(self):
        w = self.changed()
        for steps in (0, 7):
            w.step(steps)
            others = [copy.copy(w), copy.deepcopy(w), pickle.loads(pickle.dumps(w))]
            others.append(pickle.loads(pickle.dumps(others[2])))
            before = snapshot(w)
            for other in others:
                self.assertEqual((other.names, other.steps), (w.names, w.steps))
                self.assertEqual(snapshot(other), before)
                self.assertEqual(other.save(), w.save())
                self.assertEqual([j["holds"] for j in other.joints], [True, True, False])
            w.step(60)
            for other in others:
                other.step(60)
                self.assertEqual(snapshot(other), snapshot(w))

    def test_have_bodies_and_colliders_where_others_began(self):
        w = tremolo.world(scene(marble(name="drop", position=[3, 0, 0.5]),
                                marble(name="fast", position=[2, 0, 0.05], velocity=[0, 5, 0]),
                                tets(position=[1, 0, 0.3]), colliders=[floor()]))
        w.step(60)
        w.add(marble(position=[3, 0, 0.5]))
        w.add_collider({"name": "ball", "shape": "sphere", "radius": 0.1, "position": [2, 0, 0]})
        w.add_collider({"name": "box", "shape": "box", "half_extents": [0.1, 0.1, 0.02], "position": [1.1, 0, 0.38]})
        w.step(10)
        other = copy.deepcopy(w)
        for each in (w, other):
            each.step(50)
        self.assertEqual(snapshot(other), snapshot(w))

    def test_know_nothing_of_changes_that_were_refused(self):
        w = tremolo.world(scene(marble(position=[0, 0, 0.5]), tets(position=[1, 0, 0.3]), colliders=[floor()]))
        w.step(3)
        before = w.save()
        for body in (marble(name="deep", position=[0.5, 0, -0.05]), bar(name="deep", position=[0.5, 0, -0.05]),
                     tets(name="deep", position=[3, 0, -0.05]), cloth(name="deep", corner=[3, 0, -0.05])):
            with self.assertRaises(tremolo.ContentError):
                w.add(body)
        for joint in ({"body": "marble", "at": "999999", "to": "world"},
                      {"body": "marble", "at": 0, "to": "block", "to_at": "999999"}):
            with self.assertRaises(tremolo.ContentError):
                w.add_joint(joint)
        self.assertEqual(w.save(), before)
        w.restore(before)
        others = [copy.copy(w), pickle.loads(pickle.dumps(w))]
        for each in (w, *others):
            each.add(marble(name="late", position=[0.3, 0, 0.06]))
            each.add(tets(name="late-block", position=[2, 0, 0.3]))
            each.step(60)
        for other in others:
            self.assertEqual(other.save(), w.save())

    def test_have_the_grabs_of_bodies_that_nothing_touches(self):
        for alone in (marble(position=[0, 0, 1.0]), bar(position=[0, 0, 1.0])):
            w = tremolo.world(scene(alone))
            w.step(3)
            free = w.save()
            with self.assertRaises(tremolo.UsageError):
                w[alone["name"]].grab(0, stiffness=-1.0)
            self.assertEqual(w.save(), free)
            body = w[alone["name"]]
            number = body.grab(0, stiffness=100.0, damping=1.0)
            w.step(20)
            self.assertGreater(body.grab_force(number)[2], 0.0)
            others = [copy.copy(w), pickle.loads(pickle.dumps(w))]
            for each in (w, *others):
                each.step(30)
            for other in others:
                self.assertEqual(other.save(), w.save())
            w.restore(free)
            self.assertEqual(w.save(), free)

    def test_change_as_the_world_does(self):
        """Changes after the copy use the same places, also those of bodies that were just removed."""
        for steps in (0, 3):
            w = self.changed()
            w.remove("late")
            w.step(steps)
            worlds = [w, copy.deepcopy(w)]
            worlds.append(pickle.loads(pickle.dumps(worlds[1])))
            for each in worlds:
                each.add(marble(name="last", position=[0, 0, 0.08]))
                each.step(30)
            worlds.append(copy.copy(worlds[2]))
            for each in worlds[1:]:
                self.assertEqual(each.names, w.names)
                self.assertEqual(snapshot(each), snapshot(w))
                self.assertEqual(each.save(), w.save())

    def test_are_restored_between_the_same_changes(self):
        w = self.changed()
        saved = w.save()
        w.step(20)
        after = snapshot(w)
        w.restore(saved)
        w.step(20)
        self.assertEqual(snapshot(w), after)
        w.remove("late")
        with self.assertRaises(tremolo.ContentError):
            w.restore(saved)


if __name__ == "__main__":
    unittest.main()
