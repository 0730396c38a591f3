"""Compares positions(out=) with the engine's own call, by turns, on a surface of 10 082 vertices.

usage: cmake --build build --target tremolo_python_speed tremolo_python
       PYTHONPATH=build/python TREMOLO_BIN=build/bin /usr/bin/python3 runtime/apps/python/page/speed.py [ROUNDS]

Prints the least processor time of the rounds of each, and the ratio of both: other programs only add to it.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

import tremolo

PROGRAM = pathlib.Path(__file__).resolve().parents[4] / "build" / "bin" / "tremolo_python_speed"
CALLS = {np.float32: 4000, np.float64: 1000}


def microseconds(body, out):
    """Processor time of one call into the array."""
    calls = CALLS[out.dtype.type]
    begin = time.process_time()
    for _ in range(calls):
        body.positions(out=out)
    return 1e6 * (time.process_time() - begin) / calls


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 12
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "block.tremolo")
        tremolo.precompute(*tremolo.box((1.0, 1.0, 0.05), (70, 70, 1)), young=1e6, poisson=0.4, density=1000.0,
                           fixed="x<0.001", r=20, linear_modes=20, order=1, linear=True, output=path)
        body = tremolo.load(path).body(integrator="verlet", step=1e-4)
        vertices = len(body.model.drawn_vertices)
        outs = [np.empty((vertices, 3), dtype=kind) for kind in CALLS]
        native, python = [], []
        for _ in range(rounds):
            words = [PROGRAM, path, str(CALLS[np.float64])]
            native.append([float(x) for x in subprocess.run(words, capture_output=True, check=True).stdout.split()])
            python.append([microseconds(body, out) for out in outs])
        for k, name in enumerate(("float32", "float64")):
            of_engine, of_module = min(n[k] for n in native), min(p[k] for p in python)
            print(f"{name}, {vertices} vertices: C++ {of_engine:.2f} us, Python {of_module:.2f} us, "
                  f"ratio {of_module / of_engine:.3f}")


if __name__ == "__main__":
    main()
