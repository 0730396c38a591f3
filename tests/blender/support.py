"""Helpers of the tests in Blender: objects, positions, and runs of the engine to compare with."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

import bpy
import numpy

kHere = os.path.dirname(os.path.abspath(__file__))
kTop = os.path.dirname(os.path.dirname(kHere))
sys.path.insert(0, os.path.join(kTop, 'blender'))
sys.path.insert(0, os.path.join(kTop, 'tests', 'exchange'))
os.environ.setdefault('TREMOLO_PROGRAMS', os.path.join(kTop, 'build', 'bin'))

import read_exports  # noqa: E402
import tremolo_blender  # noqa: E402

kFrames = 41  # of a short motion: every tenth is the time of a surface of `tremolo run --surfaces 4`


def fresh(folder):
    """An empty scene of 1/24 s a frame, whose files go to `folder`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(bpy.types.Object, 'tremolo'):
        tremolo_blender.register()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, kFrames
    scene.tremolo.folder = folder
    return scene


def work_folder():
    return tempfile.TemporaryDirectory(prefix='tremolo-blender-')


def ball(name='Ball', subdivisions=3, radius=1.0, soft=True, held=lambda v: v.co.z < -0.7):
    """A ball with its low part held; soft: a body of few tetrahedra that vibrates visibly."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=radius)
    thing = bpy.context.object
    thing.name = name
    prepare(thing, 3e4 if soft else 1e12)
    hold(thing, held)
    return thing


def prepare(thing, young):
    own = thing.tremolo
    own.young, own.tets, own.modes, own.wobble = young, 500, 8, 0
    own.gravity = young < 1e9


def hold(thing, held):
    group = thing.vertex_groups.new(name='Hold')
    group.add([v.index for v in thing.data.vertices if held(v)], 1.0, 'REPLACE')


def animate(thing, path, keys):
    """keys: frame -> value of a property of an object or a bone."""
    for frame, value in keys.items():
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)


def select(thing):
    bpy.ops.object.select_all(action='DESELECT')
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing


def refusal(operator, thing):
    """The text with which an operator ends."""
    select(thing)
    try:
        operator()
    except RuntimeError as error:
        return str(error)
    raise AssertionError('it was not refused')


def positions(thing, frame, world=True):
    """Where Blender has the vertices of an object at a frame: (n, 3)."""
    bpy.context.scene.frame_set(frame)
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    flat = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get('co', flat)
    evaluated.to_mesh_clear()
    local = flat.reshape(-1, 3).astype(float)
    if not world:
        return local
    matrix = numpy.array(evaluated.matrix_world, float)
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def size(points):
    return numpy.ptp(points, axis=0).max()


def own_positions(scene, thing, body='body'):
    """Frame -> the engine's positions in Blender's world, by `tremolo run` of the scene that was baked.

    The world of that scene has its origin at the object's place at the first frame."""
    stem = os.path.join(bpy.path.abspath(scene.tremolo.folder), thing.name)
    rate = scene.render.fps / scene.render.fps_base
    out = stem + '-run'
    subprocess.run([os.path.join(os.environ['TREMOLO_PROGRAMS'], 'tremolo'), 'run', stem + '.toml', '--surfaces', '4',
                    '--out', out], check=True, capture_output=True)
    scene.frame_set(scene.frame_start)
    origin = numpy.array(thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world.translation)
    unit = scene.unit_settings.scale_length
    found = {}
    for time, points in read_exports.read_run(os.path.join(out, body)):
        frame = scene.frame_start + time * rate
        assert abs(frame - round(frame)) < 1e-3, time
        found[round(frame)] = numpy.array(points, float) / unit + origin
    assert len(found) >= 4, found.keys()
    return found


def program(name, *arguments, folder):
    path = os.path.join(os.environ['TREMOLO_PROGRAMS'], name)
    done = subprocess.run([path, *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f'{name} {" ".join(arguments)}: {done.returncode}\n{done.stderr}')
    return done.stderr + done.stdout


def blender(path, code):
    """Opens a .blend in a Blender without the add-on and runs code; returns the JSON that it prints last."""
    done = subprocess.run([bpy.app.binary_path, '-b', '--factory-startup', path, '--python-exit-code', '1',
                           '--python-expr', code], check=True, capture_output=True, text=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith('{')]
    return json.loads(lines[-1])


def coordinates_at_rest(thing):
    return numpy.array([vertex.co for vertex in thing.data.vertices])


def run_tests():
    """Runs the tests of the script, or those named after --, and ends Blender with their outcome."""
    names = sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else None
    script, loader = sys.modules['__main__'], unittest.defaultTestLoader
    suite = loader.loadTestsFromNames(names, script) if names else loader.loadTestsFromModule(script)
    outcome = unittest.TextTestRunner(verbosity=2).run(suite)
    sys.exit(0 if outcome.wasSuccessful() and outcome.testsRun else 1)
