"""tremolo.precompute and tremolo.reference: the programs, with arrays instead of files."""

import csv
import json
import os
import re
import sys
import tempfile
import warnings
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import errors
from ._tremolo import Model, load, load_bytes
from .meshes import Mesh, mesh_of, write_msh, write_ply
from .programs import run_program

Progress = Union[None, bool, Callable[[str, float, str], object]]

_warning = "  warning: "
_stage_line = re.compile(r"^  (\S+) +([0-9.]+) s .*? MB  ?(.*)$")


def _reporter(progress: Progress) -> Callable[[str], None]:
    """What to do with each line of the program's log: its warnings are warnings here too."""
    told = _told(progress)

    def report(line: str) -> None:
        if line.startswith(_warning):
            # The caller of precompute() or reference(): past this, run_program() and either.
            warnings.warn(line[len(_warning):], stacklevel=4)
        if told is not None:
            told(line)

    return report


def _told(progress: Progress) -> Optional[Callable[[str], None]]:
    """What the caller wants to be done with each line."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return lambda line: print(line, file=sys.stderr, flush=True)
    if not callable(progress):
        raise TypeError(f"progress: expected a callable, True or None, found {type(progress).__name__}")
    call = progress

    def report(line: str) -> None:
        found = _stage_line.match(line)
        if found:
            call(found[1], float(found[2]), found[3])

    return report


class Handover:
    """A folder in memory where arrays become files; its program runs there and names them without a folder."""

    def __init__(self) -> None:
        memory = "/dev/shm"
        usable = os.path.isdir(memory) and os.access(memory, os.W_OK | os.X_OK)
        self._folder = tempfile.TemporaryDirectory(prefix="tremolo-", dir=memory if usable else None)
        self.path = self._folder.name

    def __enter__(self) -> "Handover":
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()

    def file(self, name: str) -> str:
        return os.path.join(self.path, name)

    def put_mesh(self, mesh: Mesh, name: Optional[str]) -> str:
        """Writes the mesh and returns its file name."""
        ending = ".ply" if mesh.is_surface else ".msh"
        name = name or "mesh" + ending
        if os.path.basename(name) != name or not name.endswith(ending) or name.startswith("-"):
            raise errors.UsageError(f"name: {name!r}, must be a file name that ends in {ending}")
        (write_ply if mesh.is_surface else write_msh)(self.file(name), mesh)
        return name

    def selectors(self, given: Any, what: str, count: int) -> List[str]:
        """Selectors of: None, a selector, several, a mask (n,), or indices of vertices."""
        if isinstance(given, str):
            return [given]
        if isinstance(given, (list, tuple)) and given and all(isinstance(each, str) for each in given):
            return list(given)
        chosen = np.asarray(given)
        if chosen.ndim != 1:
            raise errors.UsageError(
                f"{what}: expected a selector, a mask or indices, found an array of the shape {chosen.shape}")
        if chosen.dtype.kind == "b":
            if len(chosen) != count:
                raise errors.UsageError(f"{what}: the mask has {len(chosen)} entries for {count} vertices")
            ids = np.flatnonzero(chosen)
        elif chosen.dtype.kind in "iu" or chosen.size == 0:
            ids = np.unique(chosen.astype(np.int64))
            if ids.size and (ids[0] < 0 or ids[-1] >= count):
                wrong = ids[0] if ids[0] < 0 else ids[-1]
                raise errors.ContentError(f"{what}: there is no vertex {wrong}: there are {count}")
        else:
            raise TypeError(f"{what}: expected a selector, a mask or indices, found an array of type {chosen.dtype}")
        if ids.size == 0:
            raise errors.ContentError(f"{what}: no vertex is chosen")
        name = f"{what}.txt"
        with open(self.file(name), "w", encoding="ascii") as file:
            file.write("\n".join(map(str, ids)) + "\n")
        return [f"file:{name}"]


def _number(value: Any, name: str) -> str:
    if isinstance(value, (str, bytes)) or value is None:
        raise TypeError(f"{name}: expected a number, found {type(value).__name__}")
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool):
        return str(int(value))
    return repr(float(value))


def _vector(value: Any, name: str) -> str:
    numbers = np.asarray(value, dtype=float)
    if numbers.shape != (3,):
        raise errors.UsageError(f"{name}: expected three numbers, found the shape {numbers.shape}")
    return ",".join(repr(float(each)) for each in numbers)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _further_words(options: Dict[str, Any]) -> List[str]:
    """Flags of the program by their names, with _ for -: True is a bare flag, a list of texts repeats it, numbers are
    one value with commas between."""
    words: List[str] = []
    for key, value in options.items():
        flag = "--" + key.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(flag)
            continue
        if isinstance(value, np.ndarray):
            value = value.tolist()
        several = isinstance(value, (list, tuple))
        if several and len(value) > 1 and all(map(_is_number, value)):
            value = ",".join(_number(each, key) for each in value)
            several = False
        for each in value if several else [value]:
            words += [flag, each if isinstance(each, str) else _number(each, key)]
    return words


def _solid_words(handover: Handover, mesh: Mesh, *, young: Any, poisson: Any, density: Any, fixed: Any, order: Any,
                 load_at: Any, load_force: Any) -> List[str]:
    words: List[str] = []
    for flag, value in (("young", young), ("poisson", poisson), ("density", density)):
        if value is not None:
            words += ["--" + flag, _number(value, flag)]
    count = len(mesh.vertices)
    for selector in ["none"] if fixed is None else handover.selectors(fixed, "fixed", count):
        words += ["--fix", selector]
    if order is not None:
        words += ["--order", str(order)]
    if load_force is not None and load_at is None:
        raise errors.UsageError("load_force needs load_at, the vertices that it acts on")
    if load_at is not None:
        if load_force is None:
            raise errors.UsageError("load_at needs load_force, three numbers in N")
        selectors = handover.selectors(load_at, "load", count)
        words += ["--load-at", selectors[0], "--load-force", _vector(load_force, "load_force")]
    return words


def _probes(handover: Handover, given: Any, count: int) -> List[str]:
    """Selectors of: None, a selector, a number, several of both, a mask (n,), or indices."""
    if given is None:
        return []
    if isinstance(given, (str, int, np.integer)) and not isinstance(given, bool):
        return [str(given)]
    several: Any = given
    if not isinstance(several, np.ndarray) and any(isinstance(each, str) for each in several):
        return [str(each) for each in several]
    chosen = np.asarray(several)
    if chosen.dtype.kind in "iu" and chosen.ndim == 1:
        return [str(each) for each in chosen]
    return handover.selectors(chosen, "probe", count)


def _compared(handover: Handover, given: Any) -> List[str]:
    """Paths of the files of: a model, a path, or several of both."""
    if isinstance(given, (str, bytes, os.PathLike, Model)):
        given = [given]
    paths = []
    for i, each in enumerate(given):
        if isinstance(each, (str, bytes, os.PathLike)):
            paths.append(os.path.abspath(os.fsdecode(each)))
            continue
        if not isinstance(each, Model):
            raise TypeError(f"compare: expected models or paths, found {type(each).__name__}")
        paths.append(handover.file(f"compared{i}.tremolo"))
        with open(paths[-1], "wb") as file:
            file.write(each.file_bytes())
    return paths


def precompute(
    mesh: Any,
    cells: Any = None,
    *,
    young: Any = None,
    poisson: Any = None,
    density: Any = None,
    fixed: Any = None,
    load_at: Any = None,
    load_force: Any = None,
    order: Any = None,
    r: Optional[int] = None,
    linear_modes: Optional[int] = None,
    output: Any = None,
    name: Optional[str] = None,
    progress: Progress = None,
    **options: Any,
) -> Model:
    """Makes the model of a solid by `tremolo-precompute`.

    mesh, cells: vertices (n, 3), m, and tetrahedra (m, 4) or the triangles (t, 3) of a surface, which tremolo-mesh
    fills; or one object of meshio with either. young: Pa. poisson: dimensionless. density: kg/m^3.
    fixed: vertices that do not move: a selector ("x<0.01"), a list of selectors, a mask (n,) or indices; None: a free
    body. Those of a surface mean places of the tetrahedra that fill it: the vertices of a face mean the whole face, one
    alone the nearest vertex of the boundary (docs/meshes.md, Selectors). load_at, load_force: the default load, vertices as for fixed and (3,), N. order: 1 or 2, of the elements.
    r: number of coordinates. linear_modes: number of modes they come from.
    output: path of the basis file to write; without it the model is in memory. name: name of the mesh in the file's
    provenance, which ends in .msh or .ply. progress: called as progress(stage, seconds, detail) after each stage; True
    prints the log on stderr. What the program warns of is a UserWarning. Further keywords are flags of the program: derivatives=3, keep_elements=True, ...

    The file has the bytes that the program writes of the same mesh as a file of that name and the same flags.
    An error of the program raises the exception of its exit code; Ctrl-C ends the program.
    """
    if options.get("select") is not None:
        raise errors.UsageError("select prints vertices and makes no model: Model.select() returns those of a model")
    given = mesh_of(mesh, cells)
    report = _reporter(progress)
    target = None if output is None else os.path.abspath(os.fsdecode(output))
    with Handover() as handover:
        words = [handover.put_mesh(given, name)]
        words += _solid_words(handover, given, young=young, poisson=poisson, density=density, fixed=fixed, order=order,
                              load_at=load_at, load_force=load_force)
        if linear_modes is not None:
            words += ["--linear-modes", _number(linear_modes, "linear_modes")]
        if r is not None:
            words += ["--modes", _number(r, "r")]
        words += _further_words(options)
        path = target or handover.file("model.tremolo")
        run_program("tremolo-precompute", [*words, "-o", path], folder=handover.path, on_line=report)
        if target is not None:
            return load(target)
        with open(path, "rb") as file:
            return load_bytes(file.read())


class Reference(NamedTuple):
    """A motion of the whole mesh."""

    report: Dict[str, Any]
    """The program's JSON report (docs/reference.md)."""
    columns: Dict[str, npt.NDArray[np.float64]]
    """Columns of run.csv by name, (steps,) each: t (s), energies (J), displacements of probes (m)."""


def _columns(path: str) -> Dict[str, npt.NDArray[np.float64]]:
    with open(path, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    header, body = rows[0], rows[1:]
    table = np.array([[float(cell) if cell else np.nan for cell in row] for row in body])
    table = table.reshape(len(body), len(header))
    return {key: np.ascontiguousarray(table[:, i]) for i, key in enumerate(header)}


def reference(
    mesh: Any,
    cells: Any = None,
    *,
    young: Any = None,
    poisson: Any = None,
    density: Any = None,
    fixed: Any = None,
    load_at: Any = None,
    load_force: Any = None,
    order: Any = None,
    step: Optional[float] = None,
    duration: Optional[float] = None,
    probe: Any = None,
    compare: Union[Model, str, "os.PathLike[str]", Sequence[Union[Model, str, "os.PathLike[str]"]]] = (),
    progress: Progress = None,
    **options: Any,
) -> Reference:
    """Moves the whole mesh, without a basis, by `tremolo-precompute reference`: the truth for a reduced model.

    Arguments as for precompute. step, duration: s. probe: vertices whose displacements are recorded: indices, selectors
    or a mask. compare: models of this mesh, or paths of their files, that move alongside. Further keywords are the
    program's flags: static=True, gravity=(0, 0, -9.81), load="square", alpha=, beta=, integrator="midpoint", ...
    """
    given = mesh_of(mesh, cells)
    report = _reporter(progress)
    with Handover() as handover:
        words = ["reference", handover.put_mesh(given, None)]
        words += _solid_words(handover, given, young=young, poisson=poisson, density=density, fixed=fixed, order=order,
                              load_at=load_at, load_force=load_force)
        for flag, value in (("--step", step), ("--duration", duration)):
            if value is not None:
                words += [flag, _number(value, flag[2:])]
        for each in _probes(handover, probe, len(given.vertices)):
            words += ["--probe", each]
        for path in _compared(handover, compare):
            words += ["--compare", path]
        words += _further_words(options)
        words += ["--out", "out", "--json"]
        printed = run_program("tremolo-precompute", words, folder=handover.path, on_line=report)
        table = handover.file("out/run.csv")
        columns = _columns(table) if os.path.exists(table) else {}
        return Reference(json.loads(printed), columns)
