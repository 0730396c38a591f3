"""Deformable solids that vibrate in real time without losing their energy.

A solid is precomputed once (tremolo.precompute, or the program tremolo-precompute) and becomes a Model: a basis U, the
squares Lambda of its frequencies and a quartic energy. A Body is a model in motion, a World many of them in contact.

Arrays are numpy's, float64 in C order. Views of a model are read-only and keep it alive. Units are SI. Errors are
subclasses of tremolo.Error with the engine's own words.
"""

from ._tremolo import (Body, Model, NodalBody, NodalScene, OwnBody, Recorder, World, __version__, integrators, load,
                       load_bytes, own_body, own_integrators, recorder)
from .errors import BoundError, ContentError, CriterionError, Error, FileError, SolverError, UsageError
from .meshes import Mesh, box, write_msh, write_ply
from .make import Reference, precompute, reference
from .programs import find_program, run_program
from .scenes import load_scene, scene_text, world
from .sparse import matrices

__all__ = [
    "Body", "BoundError", "ContentError", "CriterionError", "Error", "FileError", "Mesh", "Model", "NodalBody",
    "NodalScene", "OwnBody", "Recorder", "Reference", "SolverError", "UsageError", "World", "__version__", "box",
    "find_program", "integrators", "load", "load_bytes", "load_scene", "matrices", "own_body", "own_integrators",
    "precompute", "recorder", "reference", "run_program", "scene_text", "world", "write_msh", "write_ply",
]
