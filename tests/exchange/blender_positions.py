"""Blender imports what `tremolo export` writes: where it has the vertices at the moments of a run's
surfaces.

    blender -b --python-exit-code 1 --python blender_positions.py -- FILE BODY RUN RATE TOLERANCE

FILE: .glb, .pc2 or .mdd (with its .obj beside it) or .usda of RATE frames a second. RUN: a folder of
`tremolo run --surfaces N` whose moments are whole frames.
"""
import math
import os
import sys

import bpy
import numpy

# Debian's Blender 3.4 asks its glTF importer for a name that Debian's numpy 1.24 has dropped.
numpy.bool = bool

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from read_exports import read_run  # noqa: E402

path, body, run, rate, tolerance = sys.argv[sys.argv.index('--') + 1:]
rate, tolerance = int(rate), float(tolerance)
path = os.path.abspath(path)
stem, ending = os.path.splitext(path)

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = rate
if ending == '.glb':
    bpy.ops.import_scene.gltf(filepath=path)
elif ending == '.usda':
    if not hasattr(bpy.ops.wm, 'usd_import') or not bpy.app.build_options.usd:
        print('SKIPPED: this Blender was built without USD')
        sys.exit(0)
    bpy.ops.wm.usd_import(filepath=path)
else:
    bpy.ops.wm.obj_import(filepath=stem + '.obj', forward_axis='Y', up_axis='Z')
    thing = bpy.context.selected_objects[0]
    cache = thing.modifiers.new('cache', 'MESH_CACHE')
    cache.cache_format = ending[1:].upper()
    cache.filepath = path
    cache.frame_start = 0
    cache.forward_axis, cache.up_axis = 'POS_Y', 'POS_Z'
    body = thing.name

# Of a body on bones the armature may have taken the name.
shown = [o for o in bpy.data.objects if o.type == 'MESH' and o.name.split('.')[0] == body.split('.')[0]]
assert len(shown) == 1, [(o.name, o.type) for o in bpy.data.objects]
worst, seen = 0.0, 0
for time, wanted in read_run(run):
    frame = time * rate
    assert abs(frame - round(frame)) < 1e-3, time
    scene.frame_set(round(frame))
    seen_object = shown[0].evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = seen_object.to_mesh()
    places = [seen_object.matrix_world @ v.co for v in mesh.vertices]
    # A cache has the author's vertices alone; in a run's .ply copies of them come behind.
    if ending in ('.pc2', '.mdd'):
        assert set(wanted[len(places):]) <= set(wanted[:len(places)]), (len(places), len(wanted))
        wanted = wanted[:len(places)]
    assert len(places) == len(wanted), (len(places), len(wanted))
    # Blender's matrices are floats: they know seven digits of where a body is.
    size = max(max(x[k] for x in wanted) - min(x[k] for x in wanted) for k in range(3))
    size = max(size, max(abs(c) for x in wanted for c in x))
    worst = max(worst, max(math.dist(a, b) for a, b in zip(places, wanted)) / size)
    seen += 1
    seen_object.to_mesh_clear()
print(f'{os.path.basename(path)}: Blender has it at {seen} moments to {worst:.1e} of its size')
assert seen > 1 and worst <= tolerance
