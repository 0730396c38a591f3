"""The add-on in Blender without a window: vertex positions against the engine's own and against known motions,
and what it refuses.

    blender -b --python tests/blender/bake.py [-- NAME...]

TREMOLO_PROGRAMS: the folder of the programs; build/bin by default. NAME: of a case, e.g. Baking."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import support  # noqa: E402
from motions import Baking, Obstacles, Stack  # noqa: E402, F401
from refusals import Refusals, Work  # noqa: E402, F401

if __name__ == '__main__':
    support.run_tests()
