"""Worlds of dicts and of scene files."""

import json
import os
import re
from typing import Any, Callable, Mapping, Match, Tuple, TypeVar, Union

import numpy as np

from . import errors
from ._tremolo import NodalScene, World, kind_of_text, nodal_scene_of_text, world_of_text


def _value(value: Any, key: str) -> str:
    """A value as TOML."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (str, os.PathLike)):
        text = value if isinstance(value, str) else os.fspath(value)
        return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, np.ndarray):
        return _value(value.tolist(), key)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(v, k)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(each, key) for each in value) + "]"
    raise TypeError(f"{key}: a scene has numbers, texts, lists and dicts, found {type(value).__name__}")


def _key(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"the key {key!r} of a scene is no text")
    return json.dumps(key.replace("_", "-"), ensure_ascii=False)


def scene_text(scene: Mapping[str, Any]) -> str:
    """The text of the scene file that a dict stands for. Keys are those of scene files, with _ or -."""
    return "".join(f"{_key(key)} = {_value(value, key)}\n" for key, value in scene.items())


def path_in(folder: Any) -> str:
    """Where a scene that is a dict would be, for the paths in it."""
    return os.path.join(os.path.abspath(os.fsdecode(folder)), "scene")


def _text_and_path(scene: Any, folder: Any) -> Tuple[str, str]:
    """The text of a scene, and the path that the paths in it are relative to."""
    if isinstance(scene, Mapping):
        return scene_text(scene), path_in(folder)
    if not isinstance(scene, (str, bytes, os.PathLike)):
        raise TypeError(f"expected a dict or a path, found {type(scene).__name__}")
    path = os.path.abspath(os.fsdecode(scene))
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except OSError as error:
        raise errors.FileError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise errors.ContentError(f"{path}: the file is not UTF-8") from error
    return text, path


_Made = TypeVar("_Made")


def _made_of(scene: Any, path: str, make: Callable[[], _Made]) -> _Made:
    """make(). Errors of a scene that is a dict name its key, as there is no file with lines."""
    try:
        return make()
    except errors.Error as error:
        if not isinstance(scene, Mapping):
            raise
        keys = list(scene)

        def key_of(found: Match[str]) -> str:
            line = int(found.group(1))
            return f"the scene's {keys[line - 1]!r}" if 1 <= line <= len(keys) else "the scene"

        text = re.sub(re.escape(path) + r"[:,]? line (\d+)(?:,? column \d+)?", key_of, str(error))
        raise type(error)(text.replace(path, "the scene")) from None


def world(scene: Any, *, folder: Any = ".") -> World:
    """A world of a scene: a path of a scene file with [[bodies]], or a dict with the same keys.

    {"step": 0.003, "gravity": [0, 0, -9.81], "bodies": [{"name": "a", "model": "a.tremolo", ...}], "colliders": [...],
    "hands": [...], "joints": [...]}; docs/reference.md, "Scenes", lists the keys. Units are SI. The `model` of a body
    is a path, relative to the scene file or, for a dict, to `folder`. Bodies of kind "tets" may be among the others.
    """
    text, path = _text_and_path(scene, folder)
    return _made_of(scene, path, lambda: world_of_text(text, path))


def load_scene(scene: Any, *, folder: Any = ".") -> Union[World, NodalScene]:
    """A scene of any kind that moves, of a path or a dict as for world().

    [[bodies]] of which one is not of kind "tets" make a World; [[bodies]] of kind "tets" alone, or [[cloths]], make a
    NodalScene, which has the same step(n), names, body(name), time, steps, step_size and colliders.
    """
    text, path = _text_and_path(scene, folder)
    return _made_of(scene, path, lambda: _scene_of_text(text, path))


def _scene_of_text(text: str, path: str) -> Union[World, NodalScene]:
    kind = kind_of_text(text, path)
    if kind == "body":
        raise errors.ContentError(
            f"{path}: a scene is a list of [[bodies]] or [[cloths]]; a file with a table for each body has none")
    return world_of_text(text, path) if kind == "world" else nodal_scene_of_text(text, path)
