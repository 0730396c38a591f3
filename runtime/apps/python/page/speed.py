"""Compares positions(out=) with the engine's own call, by turns, on a surface of 10 082 vertices.

usage: cmake --build build --target tremolo_python_speed tremolo_python
       PYTHONPATH=build/python TREMOLO_BIN=build/bin /usr/bin/python3 runtime/apps/python/page/speed.py [ROUNDS]

Prints the median of the rounds of each, and of the ratios of neighbours.
"""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import tremolo

PROGRAM = pathlib.Path(__file__).resolve().parents[4] / "build" / "bin" / "tremolo_python_speed"
CALLS = {np.float32: 4000, np.float64: 1000}


def microseconds(body, out):
    """Of one call into the array."""
    calls = CALLS[out.dtype.type]
    begin = time.perf_counter()
    for _ in range(calls):
        body.positions(out=out)
    return 1e6 * (time.perf_counter() - begin) / calls


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 12
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "block.tremolo")
        tremolo.precompute(*tremolo.box((1.0, 1.0, 0.05), (70, 70, 1)), young=1e6, poisson=0.4, density=1000.0,
                           fixed="x<0.001", r=20, linear_modes=5, order=1, linear=True, output=path)
        body = tremolo.load(path).body(integrator="verlet", step=1e-4)
        vertices = len(body.model.drawn_vertices)
        outs = [np.empty((vertices, 3), dtype=kind) for kind in CALLS]
        native, python = [], []
        for _ in range(rounds):
            words = [PROGRAM, path, str(CALLS[np.float64])]
            native.append([float(x) for x in subprocess.run(words, capture_output=True, check=True).stdout.split()])
            python.append([microseconds(body, out) for out in outs])
        for k, name in enumerate(("float32", "float64")):
            ratios = [p[k] / n[k] for n, p in zip(native, python)]
            print(f"{name}, {vertices} vertices: C++ {statistics.median(n[k] for n in native):.2f} us, Python "
                  f"{statistics.median(p[k] for p in python):.2f} us, ratio {statistics.median(ratios):.3f}")


if __name__ == "__main__":
    main()
