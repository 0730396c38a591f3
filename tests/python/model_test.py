"""tremolo.Model: its arrays, its energy and derivatives."""

import copy
import gc
import pickle
import unittest

import numpy as np

import support
import tremolo


def polynomial(model, q):
    """V of many q by the dense tensors, term by term."""
    c, t = model.cubic_dense(), model.quartic_dense()
    return (0.5 * (q * q) @ model.Lambda + np.einsum("ijk,ni,nj,nk->n", c, q, q, q, optimize=True) +
            np.einsum("ijkl,ni,nj,nk,nl->n", t, q, q, q, q, optimize=True))


class Arrays(unittest.TestCase):
    def test_have_the_shapes_of_the_docstrings(self):
        m = support.clamped_bar()
        r, s = m.modes, len(m.vertices)
        self.assertEqual(m.Lambda.shape, (r,))
        self.assertEqual(m.U.shape, (3 * s, r))
        self.assertEqual(m.vertex_ids.shape, (s,))
        self.assertEqual(m.triangles.shape[1], 3)
        self.assertEqual(m.cubic.shape, (r * (r + 1) * (r + 2) // 6,))
        self.assertEqual(m.quartic.shape, (r * (r + 1) * (r + 2) * (r + 3) // 24,))
        np.testing.assert_array_equal(m.frequencies, np.sqrt(m.Lambda) / (2 * np.pi))

    def test_are_views_that_cannot_be_written(self):
        m = support.clamped_bar()
        for name in ("Lambda", "cubic", "quartic", "U", "vertices", "vertex_ids", "triangles", "drawn_U",
                     "drawn_vertices", "drawn_triangles"):
            view = getattr(m, name)
            self.assertFalse(view.flags.writeable, name)
            self.assertEqual(view.ctypes.data, getattr(m, name).ctypes.data, name)
            with self.assertRaises(ValueError):
                view.flags.writeable = True
            with self.assertRaises(ValueError):
                view[...] = 0

    def test_keep_their_owner_alive(self):
        m = tremolo.load_bytes(support.clamped_bar().file_bytes())
        u, kept = m.U, m.U.copy()
        del m
        gc.collect()
        junk = [np.full(u.shape, 7.0) for _ in range(20)]
        np.testing.assert_array_equal(u, kept)
        del junk

    def test_packed_entries_are_those_of_the_dense_tensors(self):
        m = support.clamped_bar()
        c, q = m.cubic_dense(), m.quartic_dense()
        for i, j, k, l in [(0, 0, 0, 0), (0, 1, 2, 3), (2, 2, 5, 9), (9, 9, 9, 9)]:
            at = k * (k + 1) * (k + 2) // 6 + j * (j + 1) // 2 + i
            self.assertEqual(c[i, j, k], m.cubic[at])
            self.assertEqual(c[k, i, j], m.cubic[at])
            at += l * (l + 1) * (l + 2) * (l + 3) // 24
            self.assertEqual(q[i, j, k, l], m.quartic[at])
            self.assertEqual(q[l, k, j, i], m.quartic[at])

    def test_fewer_coordinates_are_the_leading_ones(self):
        m = support.clamped_bar()
        few = tremolo.load_bytes(m.file_bytes(), modes=4)
        np.testing.assert_array_equal(few.Lambda, m.Lambda[:4])
        np.testing.assert_array_equal(few.U, m.U[:, :4])
        np.testing.assert_array_equal(few.cubic, m.cubic[:20])

    def test_a_linear_model_has_no_higher_terms(self):
        m = tremolo.load_bytes(support.clamped_bar().file_bytes(), linear=True)
        self.assertTrue(m.linear)
        self.assertEqual(m.cubic.size, 0)
        q = support.some_states(m, 3)
        np.testing.assert_allclose(m.energy(q), 0.5 * (q * q) @ m.Lambda, rtol=1e-14)  # rounding


class Energy(unittest.TestCase):
    def test_is_the_quartic_polynomial(self):
        m = support.clamped_bar()
        q = support.some_states(m, 20)
        np.testing.assert_allclose(m.energy(q), polynomial(m, q), rtol=1e-12)  # rounding of some 1e4 terms

    def test_has_the_force_as_gradient_and_the_tangent_as_its_derivative(self):
        # Central differences of second order: halving the distance divides the error by four.
        m = support.clamped_bar()
        q = support.some_states(m, 1)[0]
        d = support.some_states(m, 1, seed=2)[0]
        errors = []
        for e in (0.2, 0.1):
            slope = (m.energy(q + e * d) - m.energy(q - e * d)) / (2 * e)
            bend = (m.force(q + e * d) - m.force(q - e * d)) / (2 * e)
            errors.append((abs(slope - m.force(q) @ d), np.linalg.norm(bend - m.tangent(q) @ d)))
        for coarse, fine in zip(*errors):
            self.assertAlmostEqual(np.log2(coarse / fine), 2.0, delta=0.02)

    def test_of_many_states_is_that_of_each(self):
        m = support.clamped_bar()
        q = support.some_states(m, 7)
        for function, shape in ((m.energy, ()), (m.force, (m.modes,)), (m.tangent, (m.modes, m.modes))):
            many = function(q)
            self.assertEqual(many.shape, (7, *shape))
            for i in range(7):
                np.testing.assert_array_equal(many[i], function(q[i]))
            out = np.empty_like(many)
            self.assertIs(function(q, out=out), out)
            np.testing.assert_array_equal(out, many)
        self.assertIsInstance(m.energy(q[0]), float)

    def test_takes_lists_integers_and_strided_arrays(self):
        m = support.clamped_bar()
        q = np.zeros((4, 2 * m.modes))
        q[:, ::2] = support.some_states(m, 4)
        np.testing.assert_array_equal(m.force(q[:, ::2]), m.force(np.ascontiguousarray(q[:, ::2])))
        self.assertEqual(m.energy([0] * m.modes), 0.0)
        np.testing.assert_array_equal(m.force(np.asfortranarray(q[:, ::2])), m.force(q[:, ::2]))

    def test_of_no_states_is_an_empty_array(self):
        m = support.clamped_bar()
        self.assertEqual(m.force(np.zeros((0, m.modes))).shape, (0, m.modes))


class WholeMesh(unittest.TestCase):
    def test_basis_is_orthonormal_in_the_mass_and_diagonalises_the_stiffness(self):
        # An independent assembly; for both orders of elements.
        mesh = support.bar_mesh()
        for order in (1, 2):
            m = tremolo.precompute(*mesh, **support.MATERIAL, fixed="x<0.001", order=order, r=6, linear_modes=3)
            mass, stiffness = tremolo.matrices(*mesh, **support.MATERIAL, order=order)
            rest, u = m.whole_mesh()
            self.assertEqual(u.shape, (3 * m.vertex_count, 6))
            np.testing.assert_array_equal(rest[:len(mesh.vertices)], mesh.vertices)
            np.testing.assert_allclose(u.T @ mass @ u, np.eye(6), atol=1e-12)  # rounding
            np.testing.assert_allclose(u.T @ stiffness @ u, np.diag(m.Lambda), atol=1e-11 * m.Lambda.max())
            np.testing.assert_array_equal(u.reshape(-1, 3, 6)[m.vertex_ids].reshape(-1, 6), m.U)

    def test_mass_adds_up_to_density_times_volume(self):
        mesh = support.bar_mesh()
        for order in (1, 2):
            for kind in ("consistent", "lumped"):
                mass, _ = tremolo.matrices(*mesh, **support.MATERIAL, order=order, mass=kind)
                along_x = np.tile([1.0, 0.0, 0.0], mass.shape[0] // 3)
                self.assertAlmostEqual(along_x @ mass @ along_x, 1100.0 * 0.4 * 0.08 * 0.06, delta=1e-12)

    def test_stiffness_resists_no_rigid_motion(self):
        mesh = support.bar_mesh()
        _, stiffness = tremolo.matrices(*mesh, **support.MATERIAL)
        x = mesh.vertices
        turn = np.stack([-x[:, 1], x[:, 0], 0 * x[:, 0]], axis=1).ravel()
        self.assertLess(np.abs(stiffness @ turn).max(), 1e-12 * abs(stiffness).max())  # rounding


class Identity(unittest.TestCase):
    def test_a_pickle_of_a_model_in_memory_has_the_file(self):
        m = support.clamped_bar()
        again = pickle.loads(pickle.dumps(m))
        self.assertEqual(again.content_hash, m.content_hash)
        self.assertEqual(again.file_bytes(), m.file_bytes())

    def test_a_pickle_of_a_loaded_model_has_its_path(self):
        path = support.file_of(support.clamped_bar(), "bar.tremolo")
        m = tremolo.load(path, modes=5)
        data = pickle.dumps(m)
        self.assertLess(len(data), 1000)
        again = pickle.loads(data)
        self.assertEqual((again.path, again.modes), (path, 5))

    def test_a_copy_is_the_model_itself(self):
        m = support.clamped_bar()
        self.assertIs(copy.copy(m), m)
        self.assertIs(copy.deepcopy(m), m)

    def test_selectors_choose_vertices(self):
        m = support.clamped_bar()
        ids = m.select("x>0.399")
        np.testing.assert_array_equal(ids, np.flatnonzero(support.bar_mesh().vertices[:, 0] > 0.399))
        f = m.reduced_force(ids, np.tile([0.0, 0.0, 1.0], (len(ids), 1)))
        _, u = m.whole_mesh()
        np.testing.assert_allclose(f, u[3 * ids + 2].sum(axis=0), rtol=1e-12)


if __name__ == "__main__":
    unittest.main()
