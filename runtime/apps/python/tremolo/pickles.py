"""What pickles call: functions of Python, since those of a compiled module cannot be pickled."""

from typing import Any, Tuple

from . import _tremolo
from ._tremolo import Body, Model, World


def model_of(state: Tuple[Any, ...]) -> Model:
    """The model of a pickle."""
    return _tremolo._model_of(state)


def body_of(state: Tuple[Any, ...]) -> Body:
    """The body of a pickle."""
    return _tremolo._body_of(state)


def world_of(state: Tuple[Any, ...]) -> World:
    """The world of a pickle."""
    return _tremolo._world_of(state)
