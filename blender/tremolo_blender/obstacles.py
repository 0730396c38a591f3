"""Obstacles: objects of the scene that bodies and cloth collide with, at rest or moved by their animation."""
import hashlib
import os

import numpy

from .point_cache import write_ply
from .programs import Refused, find_program, run
from .rest_shape import rest_shape
from .settings import programs_folder

kFlat = 1e-5  # of its extent: a thinner object is a plane


def obstacles_of(scene, thing):
    """The objects that a body collides with."""
    return [o for o in scene.objects if o.tremolo.collider and o != thing and o.type == 'MESH'
            and not o.hide_render]


def kind_of(thing, shape):
    """plane, box, sphere or mesh."""
    chosen = thing.tremolo.shape.lower()
    if chosen != 'auto':
        return chosen
    if not len(shape.vertices):
        raise Refused(f'obstacle {thing.name} has no vertices')
    extents = numpy.ptp(shape.vertices, axis=0)
    return 'plane' if extents[2] <= kFlat * extents.max() else 'mesh'


def _file_job(thing, shape, folder):
    """Job: the file of distances of a mesh; its value is the path. It is made once for each shape."""
    surface = os.path.join(folder, f'obstacle-{os.getpid()}.ply')
    data = write_ply(surface, shape.vertices, shape.faces)
    path = os.path.join(folder, f'obstacle-{hashlib.sha1(data).hexdigest()[:16]}.collider')
    try:
        if not os.path.exists(path):
            program = find_program('tremolo-precompute', programs_folder())
            yield from run([program, 'collider', surface, '-o', path, '--unit', 'm'], folder)
    except Refused as error:
        raise Refused(f'obstacle {thing.name}: {error}') from error
    finally:
        os.remove(surface)
    return path


def obstacle_job(thing, unit, folder):
    """Job: (keys, shift, stretch) of [[colliders]]; shift: of the shape's frame in the object's, m."""
    shape = rest_shape(thing, unit, whole=True)
    kind = kind_of(thing, shape)
    keys = {'shape': kind, 'friction': thing.tremolo.friction, 'restitution': thing.tremolo.restitution}
    shift = numpy.zeros(3)
    if kind == 'mesh':
        keys['file'] = yield from _file_job(thing, shape, folder)
    elif kind != 'plane':
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        shift, half = (low + high) / 2, (high - low) / 2
        if min(half) <= 0:
            raise Refused(f'obstacle {thing.name} is flat: choose the shape Plane')
        if kind == 'box':
            keys['half-extents'] = [float(x) for x in half]
        else:
            keys['radius'] = float(max(half))
    return keys, shift, shape.stretch
