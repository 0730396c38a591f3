"""Model.response and Model.backbone against closed forms and time stepping."""

import unittest

import numpy as np

import support
import tremolo


def at(motion, theta):
    """A Fourier series (r, 2 H + 1) at the angles theta: (len(theta), r)."""
    rows = [np.ones_like(theta)]
    for k in range(1, motion.shape[1] // 2 + 1):
        rows += [np.cos(k * theta), np.sin(k * theta)]
    return np.array(rows).T @ motion.T


def slope_at_zero(motion, omega):
    """dq/dt at t = 0, (r,)."""
    return omega * sum(k * motion[:, 2 * k] for k in range(1, motion.shape[1] // 2 + 1))


def period(potential, high):
    """Of the free motion of one coordinate from its largest value: 2 int dq / sqrt(2 (E - V(q))), with
    E - V = (high - q) (q - low) g(q) and q = middle + half sin phi, so that nothing is singular."""
    excess = potential(high) - potential
    low = max(x.real for x in excess.roots() if abs(x.imag) < 1e-9 and x.real < 0)
    g = excess // (np.polynomial.Polynomial([high, -1]) * np.polynomial.Polynomial([-low, 1]))
    nodes, weights = np.polynomial.legendre.leggauss(80)
    q = 0.5 * (high + low) + 0.5 * (high - low) * np.sin(0.5 * np.pi * nodes)
    return np.pi * np.sum(weights / np.sqrt(2 * g(q)))


class Backbones(unittest.TestCase):
    def test_one_coordinate_has_the_period_of_its_energy(self):
        model = tremolo.load_bytes(support.clamped_bar().file_bytes(), modes=1)
        potential = np.polynomial.Polynomial([0, 0, 0.5 * model.Lambda[0], model.cubic[0], model.quartic[0]])
        curve = model.backbone(1, 0.1, harmonics=21)
        self.assertEqual(curve["end"], "done")
        theta = np.linspace(0, 2 * np.pi, 20001)
        for f, motion in zip(curve["frequency_hz"], curve["motion"]):
            high = at(motion, theta).max()
            # With 9 harmonics 1e-7 is left at the end, with 15 7e-12.
            self.assertLess(abs(f * period(potential, high) - 1), 1e-13)
        self.assertGreater(curve["frequency_hz"][-1], 1.01 * curve["frequency_hz"][0])

    def test_its_motions_return_after_their_period_when_they_are_stepped(self):
        model = support.clamped_bar()
        curve = model.backbone(1, 0.02, harmonics=9)
        f, motion = curve["frequency_hz"][-1], curve["motion"][-1]
        steps = 4000
        body = model.body(integrator="ep4", step=1 / (f * steps))
        body.q, body.p = at(motion, np.zeros(1))[0], slope_at_zero(motion, 2 * np.pi * f)
        first = body.q.copy()
        body.step(steps)
        # The series is cut off after nine harmonics.
        self.assertLess(np.linalg.norm(body.q - first), 1e-5 * np.linalg.norm(motion))


class Responses(unittest.TestCase):
    def test_a_small_load_has_the_transfer_function_of_the_linear_body(self):
        model = support.clamped_bar()
        ids, forces = model.default_load
        force = sum(model.reduced_force(int(i), f) for i, f in zip(ids, forces))
        low, high = 0.8 * model.frequencies[0], 1.2 * model.frequencies[0]
        curve = model.response((low, high), damping_ratio="2%", load_scale=1e-7, harmonics=1)
        self.assertTrue(curve["stable"].all())
        self.assertEqual(curve["bifurcations"], [])
        rates = 2 * 0.02 * np.sqrt(model.Lambda)
        for f, motion in zip(curve["frequency_hz"], curve["motion"]):
            w = 2 * np.pi * f
            complex_q = 1e-7 * force / (model.Lambda - w**2 + 1j * w * rates)
            exact = np.array([complex_q.imag, complex_q.real]).T  # of sin(w t): Im(z e^{iwt})
            self.assertLess(np.linalg.norm(motion[:, 1:3] - exact), 1e-6 * np.linalg.norm(exact))

    def test_a_given_load_is_the_default_load(self):
        model = support.clamped_bar()
        ids, forces = model.default_load
        force = sum(model.reduced_force(int(i), f) for i, f in zip(ids, forces))
        span = (0.9 * model.frequencies[0], model.frequencies[0])
        one = model.response(span, damping_ratio="1%", load_scale=0.01)
        other = model.response(span, damping_ratio="1%", load=0.01 * force)
        np.testing.assert_allclose(one["amplitude"], other["amplitude"], rtol=1e-9)


    def test_harmonics_of_a_load_have_the_transfer_function_each(self):
        model = support.clamped_bar()
        ids, forces = model.default_load
        force = sum(model.reduced_force(int(i), f) for i, f in zip(ids, forces))
        span = (0.3 * model.frequencies[0], 0.6 * model.frequencies[0])
        course = [(1, 1.0), (2, 0.5, 40.0)]
        curve = model.response(span, damping_ratio="2%", load_scale=1e-7, load_harmonics=course, harmonics=2)
        rates = 2 * 0.02 * np.sqrt(model.Lambda)
        for f, motion in zip(curve["frequency_hz"], curve["motion"]):
            for k, factor in [(1, 1.0), (2, 0.5 * np.exp(1j * np.radians(40.0)))]:
                w = 2 * np.pi * f * k
                z = 1e-7 * factor * force / (model.Lambda - w**2 + 1j * w * rates)
                exact = np.array([z.imag, z.real]).T
                found = motion[:, 2 * k - 1 : 2 * k + 1]
                self.assertLess(np.linalg.norm(found - exact), 1e-5 * np.linalg.norm(exact))
        self.assertEqual(set(curve["load_scale"]), {1e-7})

    def test_in_phase_resonance_the_load_balances_the_damping(self):
        model = tremolo.load_bytes(support.clamped_bar().file_bytes(), modes=1)
        ids, forces = model.default_load
        force = sum(model.reduced_force(int(i), f) for i, f in zip(ids, forces))[0]
        curve = model.damped_backbone(1, 0.05, damping_ratio="2%", harmonics=9)
        self.assertEqual(curve["end"], "done")
        rate = 2 * 0.02 * np.sqrt(model.Lambda[0])
        for f, scale, motion in zip(curve["frequency_hz"], curve["load_scale"], curve["motion"]):
            # Work of F cos over a period, and that of damping.
            squares = sum(k * k * np.sum(motion[0, 2 * k - 1 : 2 * k + 1] ** 2) for k in range(1, 10))
            taken = rate * 2 * np.pi * f * squares
            self.assertLess(abs(scale * force * motion[0, 2] - taken), 1e-8 * taken)

    def test_folds_are_followed_over_the_load(self):
        model = tremolo.load_bytes(support.clamped_bar().file_bytes(), modes=1)
        ridge = model.damped_backbone(1, 0.08, damping_ratio="0.5%")
        scale = ridge["load_scale"][-1]
        span = (0.9 * model.frequencies[0], 1.1 * ridge["frequency_hz"][-1])
        curve = model.response(span, damping_ratio="0.5%", load_scale=scale, folds_to=0.01 * scale)
        folds = [found for found in curve["bifurcations"] if found["kind"] == "fold"]
        self.assertEqual([len(folds), len(curve["fold_curves"])], [2, 2])
        for one, fold in zip(curve["fold_curves"], folds):
            self.assertNotIn("stable", one)
            self.assertAlmostEqual(one["frequency_hz"][0], fold["frequency_hz"], delta=1e-8)
            # Through the cusp it returns to the first load on the other fold.
            self.assertEqual([found["kind"] for found in one["bifurcations"]], ["fold"])
            self.assertGreaterEqual(one["load_scale"][-1] / scale, 1.0)
        # Both meet in one cusp, of 5 or 7 harmonics.
        cusps = [one["bifurcations"][0] for one in curve["fold_curves"]]
        for key in ("frequency_hz", "load_scale"):
            self.assertLess(abs(cusps[0][key] / cusps[1][key] - 1), 1e-8)
        self.assertLess(cusps[0]["load_scale"] / scale, 0.05)


class BadInput(unittest.TestCase):
    def test_is_an_exception_with_the_engines_words(self):
        model = support.clamped_bar()
        span = (1.0, 2.0)
        for call, error, words in [
            (lambda: model.response((0.0, 2.0), damping_ratio="1%"), tremolo.ContentError, "frequenc"),
            (lambda: model.response(span, damping_ratio="1%", harmonics=0), tremolo.ContentError, "harmonics"),
            (lambda: model.response(span, damping_ratio="1%", alpha=1.0), tremolo.UsageError, "damping_ratio"),
            (lambda: model.response(span, damping_ratio="none"), tremolo.UsageError, "none"),
            (lambda: model.response(span, damping_ratio="1%", load=np.zeros(3)), ValueError, "load"),
            (lambda: model.response(span, damping_ratio="1%", load_scale=np.nan), tremolo.ContentError, "load"),
            (lambda: model.response(span, damping_ratio="1%", probe="x<0.001"), tremolo.ContentError, "fixed"),
            (lambda: model.response(span, damping_ratio="1%", load_harmonics=[(0, 1)]), tremolo.ContentError, "1 to 99"),
            (lambda: model.response(span, damping_ratio="1%", load_harmonics=[(1,)]), tremolo.UsageError, "degrees"),
            (lambda: model.response(span, damping_ratio="1%", folds_to=-2), tremolo.ContentError, "folds_to"),
            (lambda: model.damped_backbone(1, 0.01), tremolo.ContentError, "damping_ratio"),
            (lambda: model.backbone(99, 0.01), tremolo.ContentError, "mode 99"),
            (lambda: model.backbone(1, -1.0), tremolo.ContentError, "amplitude"),
        ]:
            with self.assertRaisesRegex(error, words):
                call()


if __name__ == "__main__":
    unittest.main()
