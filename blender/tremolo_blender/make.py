"""Make: the model of an object, by tremolo-precompute in the background."""
import hashlib
import json
import os

import bpy
import numpy
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from . import scene_text
from .point_cache import write_ply
from .programs import Refused, find_program, kStages, run
from .rest_shape import armature_of, rest_shape
from .settings import programs_folder

kNamedVertices = 64  # so few held vertices are also named by their nearest neighbours
kCore = 8  # vertices of the mesh that each point of a bone holds
kBonePoints = 12  # points along a bone
kSameStretch = 1e-5  # relative


def metres(scene):
    """Metres of a Blender unit."""
    return scene.unit_settings.scale_length


def work_folder(scene):
    """The folder of models and caches, made if need be: beside the .blend, else one that ends with Blender."""
    folder = scene.tremolo.folder or '//tremolo'
    if folder.startswith('//') and not bpy.data.filepath:
        folder = os.path.join(bpy.app.tempdir, 'tremolo')
    folder = bpy.path.abspath(folder)
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise Refused(f'{folder} cannot be made: {error.strerror}') from error
    return folder


def file_stem(thing):
    """A file's name of an object's. Different names give different ones."""
    plain = ''.join(c if c.isalnum() and c.isascii() or c in '-_' else '_' for c in thing.name)
    return plain if plain == thing.name else f'{plain}-{hashlib.sha1(thing.name.encode()).hexdigest()[:6]}'


def start_shape(scene, thing):
    """The Shape of an object at the first frame of the scene."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    scene.frame_set(scene.frame_start)
    try:
        return rest_shape(thing, metres(scene), thing.tremolo.hold)
    finally:
        scene.frame_set(frame, subframe=subframe)


def bone_ends(scene, thing, shape):
    """Of each bone with weights its head and tail at rest, in the body's frame, m."""
    armature = armature_of(thing)
    to_body = metres(scene) * shape.stretch @ numpy.linalg.inv(numpy.array(thing.matrix_world, float))[:3, :3]
    origin = numpy.array(thing.matrix_world.translation)
    ends = {}
    for name in shape.weights:
        bone = armature.data.bones[name]
        ends[name] = [to_body @ (numpy.array(armature.matrix_world @ end) - origin)
                      for end in (bone.head_local, bone.tail_local)]
    return ends


def core_of_bones(ends, shape):
    """Points on the bones that lie inside the body: what is near them follows the bones."""
    tree = BVHTree.FromPolygons([tuple(v) for v in shape.vertices], shape.faces)
    points = []
    for head, tail in ends.values():
        for share in (numpy.arange(kBonePoints) + 0.5) / kBonePoints:
            point = head + share * (tail - head)
            place, normal, _, _ = tree.find_nearest(Vector(point))
            if place is not None and normal.dot(Vector(point) - place) < 0:
                points.append(point)
    return points


def fixings(scene, thing, shape):
    """Selectors of the vertices that the frame or the bones move."""
    chosen = []
    if shape.held.any():
        chosen.append('colour:red,4')
        if shape.held.sum() <= kNamedVertices:
            chosen += ['near:' + ','.join(map(repr, map(float, v))) for v in shape.vertices[shape.held]]
    if shape.weights:
        points = core_of_bones(bone_ends(scene, thing, shape), shape)
        chosen += ['near:' + ','.join(map(repr, map(float, p))) + f',{kCore}' for p in points]
        if not chosen:
            raise Refused(f'no bone of {thing.name} lies inside it, and no vertex is held: press Hold')
    return chosen or ['none']


def configuration(scene, thing, shape):
    """Keys of tremolo-precompute --config."""
    own = thing.tremolo
    keys = {'young': own.young, 'poisson': own.poisson, 'density': own.density, 'modes': own.modes,
            'linear-modes': max(1, min(20, own.modes)), 'fix': fixings(scene, thing, shape), 'unit': 'm'}
    if shape.weights:
        keys['keep-elements'] = True
    if own.volume:
        size = numpy.trace(shape.stretch) / 3
        if numpy.abs(shape.stretch - size * numpy.eye(3)).max() > 1e-5 * abs(size) or size < 0:
            raise Refused(f'{thing.name} has a mesh file of its own and must be scaled evenly: apply its scale')
        keys['mesh-unit'] = repr(float(size * metres(scene)))
        return keys
    if own.tets:
        keys['tets'] = own.tets
    if own.thicken:
        keys['thicken'] = own.thicken * metres(scene)
    if own.fill_holes:
        keys['fill-holes'] = True
    return keys


def digest(shape, thing):
    """Changes with everything that the model is made of except the stretch."""
    own = thing.tremolo
    whole = hashlib.sha1(repr([own.young, own.poisson, own.density, own.modes, own.tets, own.thicken, own.fill_holes,
                               own.volume, shape.faces, sorted(shape.weights)]).encode())
    whole.update(shape.local.tobytes())
    whole.update(shape.held.tobytes())
    return whole.hexdigest()


def is_of_this_shape(shape, thing, unit):
    """Whether the model of an object is that of its present shape. Blender's scales are floats, which
    change in their last bits where an object is rotated."""
    stretch = unit * shape.stretch
    kept = numpy.array(thing.tremolo.made_stretch).reshape(3, 3)
    return (digest(shape, thing) == thing.tremolo.made_of and
            numpy.abs(stretch - kept).max() <= kSameStretch * numpy.abs(stretch).max())


def make_job(scene, thing):
    """Job: writes the model of an object; its value is a dict of what to keep at the object, with a text."""
    program = find_program('tremolo-precompute', programs_folder())
    folder, stem = work_folder(scene), file_stem(thing)
    shape = start_shape(scene, thing)
    keys = configuration(scene, thing, shape)
    surface, config = os.path.join(folder, stem + '.ply'), os.path.join(folder, stem + '-model.toml')
    out = os.path.join(folder, stem + '.tremolo')
    write_ply(surface, shape.vertices, shape.faces, shape.held)
    with open(config, 'w', encoding='utf-8') as file:
        file.write(scene_text.table('', keys))
    command = [program, surface, '--config', config, '-o', out, '--json']
    if thing.tremolo.volume:
        command[1:2] = [bpy.path.abspath(thing.tremolo.volume), '--render', surface]
    done = yield from run(command, folder, kStages)
    report = json.loads(''.join(done.output))
    first = next((f for f in report['frequencies_hz'] if f and f > 0), 0.0)
    held = 'held' if keys['fix'] != ['none'] else 'free'
    summary = f"{report['elements']} tetrahedra, {held}"
    return {'model': bpy.path.relpath(out) if bpy.data.filepath else out, 'made_of': digest(shape, thing),
            'made_stretch': (metres(scene) * shape.stretch).ravel(), 'frequency': first,
            'summary': summary, 'warnings': done.warnings()}
