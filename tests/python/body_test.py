"""tremolo.Body: its state, steps, loads, copies, surfaces."""

import copy
import pickle
import unittest

import numpy as np

import support
import tremolo


class Steps(unittest.TestCase):
    def test_of_a_linear_model_are_those_of_oscillators(self):
        m = tremolo.load_bytes(support.clamped_bar().file_bytes(), linear=True)
        b = m.body(step=1e-3)
        b.q = np.linspace(0.01, 0.02, m.modes)
        q0 = b.q.copy()
        b.step(500)
        w = np.sqrt(m.Lambda)
        # The method is exact; 500 steps add their rounding.
        np.testing.assert_allclose(b.q, q0 * np.cos(w * 0.5), atol=1e-12)
        np.testing.assert_allclose(b.p, -q0 * w * np.sin(w * 0.5), atol=1e-9)

    def test_of_the_default_method_keep_the_energy(self):
        b = support.clamped_bar().body(step=3e-3)
        b.q[0] = 0.05
        before = b.energy["total"]
        b.step(1000)
        self.assertAlmostEqual(b.energy["total"] / before, 1.0, delta=1e-11)  # rounding of 1000 steps

    def test_one_by_one_have_the_bits_of_many(self):
        m = support.clamped_bar()
        one, many = m.body(), m.body()
        for b in (one, many):
            b.add_load(signal="sine", frequency=2.0)
        for _ in range(100):
            one.step()
        many.step(100)
        np.testing.assert_array_equal(one.q, many.q)
        np.testing.assert_array_equal(one.p, many.p)
        self.assertEqual(one.time, 100 * 3e-3)

    def test_of_every_method_converge_to_each_other(self):
        m = support.clamped_bar()
        ends = {}
        for name in tremolo.integrators():
            if name in ("explicit-euler", "implicit-euler", "imexv-thesis", "imexv-linear"):
                continue  # of first order, or unstable
            b = m.body(integrator=name, step=5e-5)
            b.q[0] = 0.02
            b.step(400)
            ends[name] = b.q.copy()
        for name, q in ends.items():
            # Second order: (h omega_1)^2 of the way, at h omega = 7e-4.
            self.assertLess(np.linalg.norm(q - ends["rk4"]), 1e-4 * np.linalg.norm(ends["rk4"]), name)

    def test_that_fail_raise_and_leave_a_valid_state(self):
        b = support.clamped_bar().body(integrator="verlet", step=0.05)
        b.q[0] = 0.1
        with self.assertRaises(tremolo.BoundError) as caught:
            b.step(1000)
        self.assertEqual(caught.exception.code, 5)
        self.assertIsInstance(caught.exception, tremolo.Error)
        self.assertTrue(np.isfinite(b.q).all())
        self.assertFalse(b.report["converged"])


class State(unittest.TestCase):
    def test_is_a_live_array(self):
        b = support.clamped_bar().body()
        q = b.q
        q[2] = 0.01
        self.assertEqual(b.q[2], 0.01)
        b.step(5)
        self.assertNotEqual(q[2], 0.01)
        np.testing.assert_array_equal(q, b.q)

    def test_written_by_element_is_that_written_whole(self):
        m = support.clamped_bar()
        one, other = m.body(), m.body()
        one.q[0], one.p[1] = 0.02, -0.3
        other.set_state(q=[0.02] + [0.0] * (m.modes - 1), p=[0.0, -0.3] + [0.0] * (m.modes - 2))
        one.step(20)
        other.step(20)
        np.testing.assert_array_equal(one.q, other.q)

    def test_outlives_the_body(self):
        b = support.clamped_bar().body()
        b.q[0] = 1.0
        q = b.q
        del b
        self.assertEqual(q[0], 1.0)
        q[0] = 2.0

    def test_that_is_not_finite_is_refused_and_taken_back(self):
        b = support.clamped_bar().body()
        b.q[0] = 0.5
        b.step(0)
        b.q[0] = np.nan
        with self.assertRaisesRegex(tremolo.UsageError, "not finite"):
            b.step()
        self.assertEqual(b.q[0], 0.5)
        with self.assertRaises(tremolo.ContentError):
            b.q = np.full(b.model.modes, np.inf)
        with self.assertRaises(tremolo.UsageError):
            b.q = [1.0, 2.0]
        with self.assertRaises(TypeError):
            b.p = "text"


class Loads(unittest.TestCase):
    def test_do_the_work_that_becomes_energy(self):
        b = support.clamped_bar().body()
        b.add_load("x>0.399", (0.0, 0.0, -2.0), signal="square", duration=0.1)
        b.step(200)
        e = b.energy
        self.assertGreater(e["total"], 0.0)
        self.assertAlmostEqual(e["work"] / e["total"], 1.0, delta=1e-10)  # of the energy-preserving method

    def test_as_a_table_are_the_function_it_samples(self):
        m = support.clamped_bar()
        square, table = m.body(), m.body()
        square.add_load(signal="square", duration=0.06)
        table.add_load(signal=([0.0, 0.06], [1.0, 1.0]))
        for b in (square, table):
            b.step(40)
        np.testing.assert_allclose(square.q, table.q, rtol=1e-12, atol=1e-15)

    def test_in_coordinates_are_those_at_vertices(self):
        m = support.clamped_bar()
        ids = m.select("x>0.399")
        each = np.tile([0.1, 0.0, -0.2], (len(ids), 1))
        one, other = m.body(), m.body()
        one.add_load(ids, each)
        other.add_load(reduced=m.reduced_force(ids, each))
        for b in (one, other):
            b.step(10)
        np.testing.assert_allclose(one.q, other.q, rtol=1e-12, atol=1e-15)

    def test_hold_a_body_in_its_equilibrium(self):
        m = support.clamped_bar()
        b = m.body(damping_ratio="1:0.5,10:0.5", step=0.01)
        b.add_load()
        b.step(2000)
        ids, forces = m.default_load
        f = m.reduced_force(ids, forces)
        # What motion is left after 20 s falls with the damping: far below the solve's tolerance.
        np.testing.assert_allclose(m.force(b.q), f, atol=1e-5 * np.linalg.norm(f))

    def test_of_grabs_pull_a_vertex_along(self):
        m = support.clamped_bar()
        b = m.body()
        vertex = int(m.select("x>0.399")[0])
        start = b.position(vertex)
        grab = b.pin(vertex)
        for k in range(100):
            b.move_grab(grab, start + [0.0, 0.0, -0.0004 * k])
            b.step()
        self.assertAlmostEqual(b.position(vertex)[2], start[2] - 0.0396, delta=1e-3)
        self.assertLess(b.grab_force(grab)[2], 0.0)
        b.release(grab)
        with self.assertRaises(tremolo.UsageError):
            b.move_grab(grab, start)


class Surfaces(unittest.TestCase):
    def test_are_rest_plus_u_q(self):
        m = support.clamped_bar()
        b = m.body()
        b.q = support.some_states(m, 1)[0]
        expected = m.vertices + (m.U @ b.q).reshape(-1, 3)
        np.testing.assert_allclose(b.positions(), expected, atol=1e-15)
        np.testing.assert_allclose(b.boundary_positions(), expected, atol=1e-15)
        out = np.empty(expected.shape, dtype=np.float32)
        self.assertIs(b.positions(out=out), out)
        np.testing.assert_allclose(out, expected, atol=1e-6)  # of float sums
        places, normals = b.positions_and_normals()
        np.testing.assert_array_equal(places, out)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
        i = 7
        np.testing.assert_allclose(b.position(int(m.vertex_ids[i])), expected[i], atol=1e-15)

    def test_move_with_their_velocities(self):
        for m in (support.clamped_bar(), support.free_bar()):
            b = m.body(step=1e-5)
            if b.frame == "free":
                b.set_motion((0.1, 0.2, -0.3), (0.0, 2.0, 1.0))
            b.p[1] = 0.05
            b.step()
            before = b.positions()
            b.step()
            v = b.velocities()
            b.step()
            # A central difference: h^2/6 of the third derivative.
            np.testing.assert_allclose((b.positions() - before) / 2e-5, v, atol=1e-4)

    def test_are_hit_by_rays(self):
        b = support.clamped_bar().body()
        hit = b.pick((0.31, 0.041, 1.0), (0.0, 0.0, -1.0))
        np.testing.assert_allclose(hit["point"], (0.31, 0.041, 0.06), atol=1e-12)
        self.assertAlmostEqual(hit["distance"], 0.94)
        self.assertIsNone(b.pick((0.31, 0.041, 1.0), (0.0, 0.0, 1.0)))


class Frames(unittest.TestCase):
    def test_of_a_free_body_keep_its_momenta(self):
        b = support.free_bar().body()
        self.assertEqual(b.frame, "free")
        b.set_motion((0.5, 0.0, 0.0), (1.0, 3.0, 0.0))
        b.p[0] = 0.1
        linear, angular = b.linear_momentum, b.angular_momentum
        b.step(500)
        np.testing.assert_allclose(b.linear_momentum, linear, atol=1e-12)
        np.testing.assert_allclose(b.angular_momentum, angular, atol=1e-10)  # rounding of 500 steps

    def test_of_a_free_body_fall(self):
        b = support.free_bar().body(step=0.01)
        b.gravity = (0.0, 0.0, -9.81)
        b.step(100)
        self.assertAlmostEqual(b.velocity[2], -9.81, delta=1e-9)

    def test_of_a_driven_body_follow_the_poses(self):
        b = support.clamped_bar().body(frame="driven", step=1e-3)
        for k in range(1, 101):
            b.move_to((0.0, 0.0, 0.01 * np.sin(0.05 * k) ** 2))
            b.step()
        position, rotation = b.pose
        self.assertAlmostEqual(position[2], 0.01 * np.sin(5.0) ** 2)
        np.testing.assert_array_equal(rotation, (1.0, 0.0, 0.0, 0.0))
        self.assertGreater(np.abs(b.q).max(), 0.0)
        e = b.energy
        self.assertAlmostEqual(e["support"], e["work"])


class Copies(unittest.TestCase):
    def bodies(self):
        m = support.clamped_bar()
        first = m.body(alpha=0.3, beta=1e-3)
        first.add_load("x>0.399", (0.0, 1.0, 0.0), signal=([0.0, 1.0], [0.0, 2.0]))
        first.add_load(reduced=np.arange(m.modes) * 0.01, signal="sine", frequency=3.0, start=0.01)
        first.add_load(signal="impulse", scale=0.5)
        first.gravity = (0.0, 0.0, -9.81)
        yield first
        second = support.free_bar().body(integrator="ep2", step=2e-3)
        second.set_motion((0.0, 1.0, 0.0), (1.0, 0.0, 2.0))
        yield second
        third = m.body(integrator="imexv", split=3)
        third.q[0] = 0.03
        yield third
        fourth = m.body(frame="driven")
        fourth.pin(int(m.select("x>0.399")[0]))
        fourth.move_to((0.0, 0.0, 0.001))
        yield fourth

    def test_continue_with_the_same_bits(self):
        for b in self.bodies():
            b.step(20)
            others = [copy.copy(b), copy.deepcopy(b), pickle.loads(pickle.dumps(b))]
            b.step(30)
            for other in others:
                other.step(30)
                np.testing.assert_array_equal(other.q, b.q)
                np.testing.assert_array_equal(other.p, b.p)
                self.assertEqual(other.time, b.time)
                self.assertEqual(other.energy, b.energy)

    def test_do_not_share_their_state(self):
        b = support.clamped_bar().body()
        other = copy.copy(b)
        other.q[0] = 1.0
        self.assertEqual(b.q[0], 0.0)

    def test_have_what_was_written_last(self):
        b = support.clamped_bar().body()
        b.q[3] = 0.25
        self.assertEqual(copy.copy(b).q[3], 0.25)

    def test_are_saved_as_bytes(self):
        m = support.clamped_bar()
        b = m.body()
        b.p[0] = 1.0
        b.step(10)
        saved = b.save()
        other = m.body()
        other.restore(saved)
        for each in (b, other):
            each.step(10)
        np.testing.assert_array_equal(b.q, other.q)
        with self.assertRaises(tremolo.ContentError):
            m.body(integrator="verlet").restore(saved)
        with self.assertRaises(tremolo.ContentError):
            other.restore(saved[:-3])

    def test_of_another_version_are_refused(self):
        for thing in (support.clamped_bar().body(), support.clamped_bar()):
            make, (state,) = thing.__reduce__()
            with self.assertRaisesRegex(tremolo.ContentError, "of version 7, not 1"):
                make((state[0], 7, *state[2:]))
            for other in (("something", 1), (), state[:4]):
                with self.assertRaises(tremolo.ContentError):
                    make(other)


if __name__ == "__main__":
    unittest.main()
