"""Meshes as arrays: reading them from their many forms, and writing files that the programs read."""

import os
from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np
import numpy.typing as npt

from . import errors


class Mesh(NamedTuple):
    """vertices: (n, 3), float64. cells: tetrahedra (m, 4) or triangles (t, 3), int64."""

    vertices: npt.NDArray[np.float64]
    cells: npt.NDArray[np.int64]

    @property
    def is_surface(self) -> bool:
        """True if the cells are triangles."""
        return bool(self.cells.shape[1] == 3)


def checked_mesh(vertices: Any, cells: Any) -> Mesh:
    """Arrays of vertices and of tetrahedra or triangles, checked; errors name the array and what is wrong."""
    v = np.asarray(vertices)
    c = np.asarray(cells)
    if v.dtype.kind not in "fiu":
        raise TypeError(f"vertices: expected numbers, found an array of type {v.dtype}")
    if v.ndim != 2 or v.shape[1] != 3:
        raise errors.UsageError(f"vertices: expected the shape (n, 3), found {v.shape}")
    if len(v) == 0:
        raise errors.ContentError("vertices: the array is empty")
    v = np.ascontiguousarray(v, dtype=np.float64)
    bad = ~np.isfinite(v).all(axis=1)
    if bad.any():
        raise errors.ContentError(f"vertices: vertex {int(np.argmax(bad))} is not finite")
    if c.size == 0:
        raise errors.ContentError("cells: the array is empty")
    if c.dtype.kind not in "iu":
        raise TypeError(f"cells: expected integers, found an array of type {c.dtype}")
    if c.ndim != 2 or c.shape[1] not in (3, 4):
        raise errors.UsageError(
            f"cells: expected tetrahedra (m, 4) or triangles (t, 3), found the shape {c.shape}")
    outside = (c < 0) | (c >= len(v))
    if outside.any():
        cell = int(np.argmax(outside.any(axis=1)))
        raise errors.ContentError(
            f"cells: cell {cell} has the vertex {int(c[cell][outside[cell]][0])}, but there are {len(v)}")
    return Mesh(v, np.ascontiguousarray(c, dtype=np.int64))


def mesh_of(first: Any, cells: Optional[Any] = None) -> Mesh:
    """A mesh of (vertices, cells), or of an object of meshio with tetrahedra or else triangles."""
    if cells is not None:
        return checked_mesh(first, cells)
    if hasattr(first, "points") and hasattr(first, "cells_dict"):
        blocks = first.cells_dict
        for kind in ("tetra", "triangle"):
            if kind in blocks:
                return checked_mesh(first.points, blocks[kind])
        raise errors.ContentError(
            f"the mesh has neither tetrahedra nor triangles, only: {', '.join(sorted(blocks)) or 'nothing'}")
    if isinstance(first, tuple) and len(first) == 2:
        return checked_mesh(first[0], first[1])
    raise TypeError(f"expected arrays of vertices and cells or an object of meshio, found {type(first).__name__}")


def _path(path: Any) -> str:
    """A path as text. open() takes a number too, for a file that is open already."""
    return os.fsdecode(os.fspath(path))


def _write(path: Any, data: bytes) -> None:
    """Writes a file, whole or not at all. FileError names it."""
    name = _path(path)
    special = os.path.exists(name) and not os.path.isfile(name)
    part = name if special else f"{os.path.realpath(name)}.part-{os.getpid()}"
    try:
        with open(part, "wb") as file:
            file.write(data)
        if not special:
            os.replace(part, os.path.realpath(name))
    except OSError as error:
        if not special and os.path.exists(part):
            os.remove(part)
        raise errors.FileError(f"{name}: cannot be written: {error.strerror}") from error


def write_msh(path: str, mesh: Mesh) -> None:
    """Writes tetrahedra as Gmsh's MSH 2.2, binary: coordinates and indices arrive with all their bits."""
    mesh = checked_mesh(mesh[0], mesh[1])
    if mesh.is_surface:
        raise errors.UsageError("write_msh writes tetrahedra (m, 4), found triangles: write_ply writes them")
    count = len(mesh.vertices)
    nodes = np.empty(count, dtype=[("number", "<i4"), ("place", "<f8", 3)])
    nodes["number"] = np.arange(1, count + 1)
    nodes["place"] = mesh.vertices
    cells = np.empty((len(mesh.cells), 5), dtype="<i4")
    cells[:, 0] = np.arange(1, len(mesh.cells) + 1)
    cells[:, 1:] = mesh.cells + 1
    header = np.array([4, len(cells), 0], dtype="<i4").tobytes()
    _write(path, b"$MeshFormat\n2.2 1 8\n" + np.int32(1).tobytes() + b"\n$EndMeshFormat\n" +
           b"$Nodes\n%d\n" % count + nodes.tobytes() + b"\n$EndNodes\n" +
           b"$Elements\n%d\n" % len(cells) + header + cells.tobytes() + b"\n$EndElements\n")


def write_ply(path: str, mesh: Mesh) -> None:
    """Writes triangles as binary PLY."""
    mesh = checked_mesh(mesh[0], mesh[1])
    if not mesh.is_surface:
        raise errors.UsageError("write_ply writes triangles (t, 3), found tetrahedra: write_msh writes them")
    faces = np.empty(len(mesh.cells), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = mesh.cells
    _write(path, b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(mesh.vertices) +
           b"property double x\nproperty double y\nproperty double z\n" +
           b"element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(faces) +
           np.ascontiguousarray(mesh.vertices, dtype="<f8").tobytes() + faces.tobytes())


def box(size: Tuple[float, float, float], cells: Tuple[int, int, int]) -> Mesh:
    """A block [0, size] cut into cells, each into six tetrahedra. size: m."""
    extents = [float(s) for s in size]
    if len(extents) != 3 or not all(np.isfinite(s) and s > 0 for s in extents):
        raise errors.UsageError(f"size: {size}, expected three lengths above 0, m")
    counts = list(cells)
    if len(counts) != 3 or not all(np.isfinite(n) and n == int(n) and n >= 1 for n in counts):
        raise errors.UsageError(f"cells: {cells}, expected three whole numbers of at least 1")
    nx, ny, nz = (int(n) for n in counts)
    axes = [np.linspace(0.0, s, n + 1) for s, n in zip(extents, (nx, ny, nz))]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    number = np.arange(len(vertices)).reshape(nx + 1, ny + 1, nz + 1)
    corner = {(i, j, k): number[i:nx + i, j:ny + j, k:nz + k].ravel()
              for i in (0, 1) for j in (0, 1) for k in (0, 1)}
    # Kuhn's cut: all six share the diagonal, and the cuts of neighbours agree.
    tets = []
    for first in range(3):
        for second in range(3):
            if second == first:
                continue
            a = [0, 0, 0]
            way: List[Tuple[int, int, int]] = [(0, 0, 0)]
            for axis in (first, second, 3 - first - second):
                a[axis] = 1
                way.append((a[0], a[1], a[2]))
            even = (second - first) % 3 == 1
            if not even:
                way[2], way[3] = way[3], way[2]
            tets.append(np.stack([corner[w] for w in way], axis=-1))
    return Mesh(vertices, np.concatenate(tets).astype(np.int64))
