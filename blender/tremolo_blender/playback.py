"""The motion at the object: a Mesh Cache modifier that plays a file, or shape keys.

Both are Blender's own, so a saved .blend shows the motion without this add-on."""
import os

import bpy
import numpy

from .point_cache import write_cache
from .programs import Refused
from .rest_shape import cache_of, kCacheName

kKeyName = 'tremolo '  # of the shape keys, before the frame's number


def blend_path(path):
    """A path as the .blend keeps it: relative to it where possible."""
    return bpy.path.relpath(path) if bpy.data.filepath else path


def own_keys(thing):
    keys = thing.data.shape_keys
    return [block for block in keys.key_blocks if block.name.startswith(kKeyName)] if keys else []


def clear(thing):
    """Removes the motion from an object: modifier and shape keys."""
    modifier = cache_of(thing)
    if modifier:
        thing.modifiers.remove(modifier)
    ours = own_keys(thing)
    if not ours:
        return
    animation = thing.data.shape_keys.animation_data
    if animation and animation.action:
        for curve in list(animation.action.fcurves):
            if f'["{kKeyName}' in curve.data_path:
                animation.action.fcurves.remove(curve)
    for block in ours:
        thing.shape_key_remove(block)
    if len(thing.data.shape_keys.key_blocks) == 1:
        thing.shape_key_remove(thing.data.shape_keys.reference_key)


def play_cache(plan, path):
    """Writes the positions to path, .pc2 or .mdd, and plays them by a modifier."""
    write_cache(path, plan.positions, plan.rate)
    clear(plan.thing)
    modifier = plan.thing.modifiers.new(kCacheName, 'MESH_CACHE')
    if modifier is None:
        raise Refused(f'{plan.thing.name} takes no Mesh Cache modifier')
    with bpy.context.temp_override(object=plan.thing):
        bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=plan.shape.place)
    modifier = cache_of(plan.thing)
    modifier.cache_format = os.path.splitext(path)[1][1:].upper()
    modifier.filepath = blend_path(path)
    modifier.frame_start = plan.first
    modifier.forward_axis, modifier.up_axis = 'POS_Y', 'POS_Z'
    modifier.interpolation = 'LINEAR'
    modifier.deform_mode = 'OVERWRITE'


def check_keys(plan):
    """Raises Refused for an object that cannot have the motion as shape keys."""
    thing = plan.thing
    if not plan.shape.base:
        raise Refused(f'modifiers of {thing.name} make the vertices that move: shape keys have those of the mesh '
                      'alone. Bake to PC2 or MDD')
    if thing.data.users > 1:
        raise Refused(f'{thing.data.users} objects have the mesh of {thing.name}, and shape keys would move them all: '
                      'Object > Relations > Make Single User, or bake to PC2 or MDD')
    if thing.data.shape_keys and len(own_keys(thing)) + 1 < len(thing.data.shape_keys.key_blocks):
        raise Refused(f'{thing.name} has shape keys of its own: bake to PC2 or MDD')
    if any(m.type == 'ARMATURE' for m in thing.modifiers):
        raise Refused(f'the armature of {thing.name} would move the shape keys once more: bake to PC2 or MDD')


def play_keys(plan):
    """Makes a shape key for each frame, with weights 1 at its frame and 0 at its neighbours'."""
    check_keys(plan)
    thing = plan.thing
    clear(thing)
    thing.shape_key_add(name='Basis', from_mix=False)
    keys = thing.data.shape_keys
    keys.use_relative = True
    action = bpy.data.actions.new(f'{thing.name} {kKeyName}')
    keys.animation_data_create().action = action
    for k, points in enumerate(plan.positions):
        frame = plan.first + k
        block = thing.shape_key_add(name=f'{kKeyName}{frame}', from_mix=False)
        block.data.foreach_set('co', numpy.ascontiguousarray(points, numpy.float32).ravel())
        curve = action.fcurves.new(f'key_blocks["{block.name}"].value')
        # The first and the last shape stay before and after the range.
        times = [(frame + d, float(d == 0)) for d in (-1, 0, 1)]
        times = times[1:] if k == 0 else times[:2] if k == len(plan.positions) - 1 else times
        curve.keyframe_points.add(len(times))
        for point, time in zip(curve.keyframe_points, times):
            point.co, point.interpolation = time, 'LINEAR'
        curve.update()
    thing.data.update()
