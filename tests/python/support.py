"""Small models for the tests, each made once a process by tremolo-precompute."""

import functools
import os
import tempfile

import numpy as np

import tremolo

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
MATERIAL = {"young": 5e5, "poisson": 0.4, "density": 1100.0}


def bar_mesh():
    """A bar of 0.4 m x 0.08 m x 0.06 m."""
    return tremolo.box((0.4, 0.08, 0.06), (8, 2, 2))


@functools.lru_cache(maxsize=None)
def clamped_bar(**options):
    """Held at x = 0, with a load at the other end: 10 coordinates."""
    return tremolo.precompute(*bar_mesh(), **MATERIAL, fixed="x<0.001", load_at="x>0.399", load_force=(0.0, 0.0, -1.0),
                              order=1, r=10, linear_modes=4, **options)


@functools.lru_cache(maxsize=None)
def free_bar():
    """Without support."""
    return tremolo.precompute(*bar_mesh(), **MATERIAL, order=1, r=6, linear_modes=3)


@functools.lru_cache(maxsize=None)
def folder():
    """A folder of this process, removed at its end."""
    kept = tempfile.TemporaryDirectory(prefix="tremolo-test-")
    _kept.append(kept)
    return kept.name


_kept = []


def file_of(model, name):
    """The path of a file with the model."""
    path = os.path.join(folder(), name)
    if not os.path.exists(path):
        with open(path, "wb") as file:
            file.write(model.file_bytes())
    return path


def some_states(model, count, size=0.02, seed=1):
    """Random q, (count, r), whose coordinates move vertices by about `size`, m."""
    q = np.random.default_rng(seed).normal(size=(count, model.modes))
    return q * size * np.sqrt(0.02)
