"""Mass and stiffness of a whole mesh."""

from typing import Any, Tuple

import numpy as np

from . import _tremolo, errors
from .meshes import mesh_of


def matrices(mesh: Any, cells: Any = None, *, young: float, poisson: float, density: float, order: int = 1,
             mass: str = "consistent") -> Tuple[Any, Any]:
    """(M, K) of a mesh at rest as scipy.sparse.csr_matrix, (3 n, 3 n), kg and N/m.

    mesh, cells: as for precompute, tetrahedra. Row 3 i + axis is that of vertex i; no vertex is fixed. order 2 adds
    the edges' midpoints as vertices n, n + 1, ... in the order of a model's: rows and columns are displacements of
    points, as the rows of model.U. mass: "consistent" or "lumped".

    The basis of a model of this mesh and material is orthonormal in M: with U from model.whole_mesh(), U.T @ M @ U is
    the identity.
    """
    from scipy import sparse  # type: ignore

    given = mesh_of(mesh, cells)
    if given.is_surface:
        raise errors.UsageError("a surface has no matrices: they need tetrahedra")
    if mass not in ("consistent", "lumped"):
        raise errors.UsageError(f"mass: {mass!r}, must be consistent or lumped")
    m, k, edges, count = _tremolo.matrix_entries(given.vertices, given.cells, young, poisson, density, order,
                                                 mass == "lumped")
    size = 3 * count
    both = [sparse.coo_matrix((values, (rows, columns)), shape=(size, size)).tocsr() for values, rows, columns in (m, k)]
    if len(edges):
        # Control values c of an edge from displacements u: c = 2 u_mid - (u_a + u_b) / 2.
        point, a, b = edges.T
        ends = np.concatenate
        corners = np.setdiff1d(np.arange(count), point)
        rows = ends([corners, point, point, point])
        columns = ends([corners, point, a, b])
        values = ends([np.ones(len(corners)), np.full(len(point), 2.0), np.full(2 * len(point), -0.5)])
        controls = sparse.kron(sparse.coo_matrix((values, (rows, columns)), shape=(count, count)), sparse.identity(3),
                               format="csr")
        both = [(controls.T @ each @ controls).tocsr() for each in both]
    return both[0], both[1]
