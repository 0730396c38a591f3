"""tremolo.own_body: a potential in Python under the engine's methods."""

import unittest

import numpy as np

import support
import tremolo


def pendulum(**options):
    """V = 1 - cos q."""
    return tremolo.own_body(lambda q: 1.0 - np.cos(q[0]), lambda q: np.sin(q), lambda q: np.array([[np.cos(q[0])]]),
                            q=[1.0], **options)


class Steps(unittest.TestCase):
    def test_converge_with_the_order_of_the_method(self):
        truth = pendulum(integrator="rk4", step=1 / 4096)
        truth.step(4096)
        for name, order in (("explicit-euler", 1), ("symplectic-euler", 1), ("explicit-midpoint", 2), ("rk4", 4),
                            ("implicit-euler", 1), ("midpoint", 2), ("newmark", 2), ("bdf2", 2), ("energy", 2),
                            ("avf", 2), ("ep4", 4)):
            errors = []
            for count in (32, 64):
                b = pendulum(integrator=name, step=1 / count)
                b.step(count)
                errors.append(abs(b.q[0] - truth.q[0]))
            self.assertAlmostEqual(np.log2(errors[0] / errors[1]), order, delta=0.25, msg=name)

    def test_of_energy_keep_it_in_long_steps(self):
        for name in ("energy", "avf", "ep4"):
            b = pendulum(step=0.9, integrator=name)
            b.step(300)
            self.assertAlmostEqual(b.energy["total"], 1.0 - np.cos(1.0), delta=1e-6, msg=name)  # of the solves
            self.assertEqual(b.steps, 300)

    def test_of_fourth_order_keep_it_in_a_potential_that_is_no_polynomial(self):
        # Two charges of one sign in a bowl, which come near each other.
        def energy(q):
            return 0.5 * q @ q + 1.0 / np.linalg.norm(q[:2] - q[2:])

        def gradient(q):
            d = q[:2] - q[2:]
            pull = d / np.linalg.norm(d)**3
            return q - np.concatenate((pull, -pull))

        start = {"q": [1.0, 0.2, -0.9, 0.0], "v": [-0.4, 0.1, 0.3, -0.2], "mass": [1.0, 1.0, 2.0, 2.0]}
        ends = []
        for step in (0.1, 0.05, 0.025, 0.003125):
            b = tremolo.own_body(energy, gradient, integrator="ep4", step=step, tolerance=1e-12, **start)
            begin = b.energy["total"]
            b.step(round(4.0 / step))
            self.assertAlmostEqual(b.energy["total"], begin, delta=1e-9)  # of 1280 solves
            ends.append(b.q)
        errors = [np.abs(q - ends[-1]).max() for q in ends[:-1]]
        self.assertAlmostEqual(np.log2(errors[1] / errors[2]), 4.0, delta=0.3)

    def test_of_avf_are_those_of_the_engine_where_the_potential_is_a_models(self):
        m = support.clamped_bar()
        q = support.some_states(m, 1)[0]
        b = m.body(integrator="avf", step=1e-3, tolerance=1e-12)
        own = tremolo.own_body(m.energy, m.force, m.tangent, q=q, integrator="avf", step=1e-3, tolerance=1e-13)
        b.q = q
        b.step(100)
        own.step(100)
        np.testing.assert_allclose(own.q, b.q, rtol=0, atol=1e-8 * np.abs(q).max())  # of 100 solves

    def test_of_the_symmetric_methods_return_when_time_does(self):
        for name in ("avf", "ep4"):
            b = pendulum(step=0.7, integrator=name, tolerance=1e-13)
            b.step(20)
            b.v = -b.v
            b.step(20)
            self.assertAlmostEqual(b.q[0], 1.0, delta=1e-9, msg=name)  # of 40 solves

    def test_without_a_tangent_are_nearly_the_same(self):
        one = pendulum(step=0.1)
        other = tremolo.own_body(lambda q: 1.0 - np.cos(q[0]), np.sin, q=[1.0], step=0.1)
        for b in (one, other):
            b.step(50)
        self.assertAlmostEqual(one.q[0], other.q[0], delta=1e-6)  # of the solves' tolerance

    def test_of_a_models_own_energy_are_those_of_its_bodies(self):
        m = support.clamped_bar()
        q = support.some_states(m, 1)[0]
        b = m.body(integrator="rk4", step=2e-4)
        own = tremolo.own_body(m.energy, m.force, m.tangent, q=q, integrator="rk4", step=2e-4)
        b.q = q
        b.step(100)
        own.step(100)
        np.testing.assert_allclose(own.q, b.q, rtol=1e-10, atol=1e-14)  # rounding of 100 steps

    def test_of_masses_are_slower(self):
        heavy = tremolo.own_body(lambda q: 2.0 * q @ q, lambda q: 4.0 * q, q=[1.0, 0.0], mass=[4.0, 1.0], step=0.01,
                                 v=[0.0, 2.0], integrator="rk4")
        heavy.step(100)
        np.testing.assert_allclose(heavy.q, [np.cos(1.0), np.sin(2.0)], atol=1e-8)


class Faults(unittest.TestCase):
    def test_of_a_callable_are_raised_and_leave_the_state(self):
        calls = []

        def gradient(q):
            calls.append(1)
            if len(calls) > 40:
                raise RuntimeError("enough")
            return q

        b = tremolo.own_body(lambda q: 0.5 * q @ q, gradient, lambda q: np.eye(2), q=[1.0, 2.0], step=0.1)
        with self.assertRaisesRegex(RuntimeError, "enough"):
            b.step(1000)
        q, steps = b.q, b.steps
        calls.clear()
        b.step()
        self.assertEqual(b.steps, steps + 1)
        self.assertFalse((b.q == q).all())

    def test_of_results_are_refused(self):
        for result in (np.zeros(3), "text", None, np.zeros((2, 1)), 1.0):
            b = tremolo.own_body(lambda q: 0.0, lambda q, result=result: result, q=[1.0, 2.0])
            with self.assertRaises((ValueError, TypeError)):
                b.step()
        for result in ("text", None, [1.0]):
            b = tremolo.own_body(lambda q, result=result: result, lambda q: q, lambda q: np.eye(2), q=[1.0, 2.0])
            with self.assertRaises((ValueError, TypeError, RuntimeError)):
                b.step()
            with self.assertRaises((ValueError, TypeError, RuntimeError)):
                b.energy
        b = tremolo.own_body(lambda q: 0.0, lambda q: q * np.nan, lambda q: np.eye(2), q=[1.0, 2.0])
        with self.assertRaises(tremolo.SolverError):
            b.step()
        np.testing.assert_array_equal(b.q, [1.0, 2.0])

    def test_of_arguments_are_refused(self):
        good = dict(energy=lambda q: 0.0, gradient=lambda q: q, q=[1.0])
        for wrong in ({"energy": 3}, {"gradient": None}, {"tangent": 1}, {"q": []}, {"q": [np.nan]}, {"q": "text"},
                      {"v": [1.0, 2.0]}, {"mass": [0.0]}, {"mass": [-1.0]}, {"integrator": "magic"}, {"step": 0.0},
                      {"tolerance": -1.0}, {"q": [[1.0]]}):
            with self.assertRaises((ValueError, TypeError), msg=str(wrong)):
                tremolo.own_body(**{**good, **wrong})

    def test_of_calls_inside_a_call_are_refused(self):
        bodies = []

        def gradient(q):
            bodies[0].step()
            return q

        bodies.append(tremolo.own_body(lambda q: 0.0, gradient, q=[1.0]))
        with self.assertRaisesRegex(tremolo.UsageError, "used by another call"):
            bodies[0].step()


if __name__ == "__main__":
    unittest.main()
