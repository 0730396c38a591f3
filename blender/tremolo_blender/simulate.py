"""Jiggle and Bake: a scene of the object, its animation and its obstacles, run by `tremolo export`."""
import os

import bpy
import numpy

from . import motion, scene_text
from .make import bone_ends, file_stem, is_of_this_shape, metres, work_folder
from .obstacles import obstacle_job, obstacles_of
from .point_cache import read_pc2, write_ply
from .programs import Refused, find_program, run
from .rest_shape import Shape, armature_of, only, rest_shape, split_stack
from .settings import programs_folder

kStepsOfPeriod = 20  # of the slowest shape; fewer do not follow its vibration
kSamples = 4  # poses of each frame, at most; between them the engine's splines


class Plan:
    """One run of an object through the frames of a scene."""
    scene: bpy.types.Scene
    thing: bpy.types.Object
    unit: float  # metres of a Blender unit
    first: int  # frame
    last: int  # frame
    rate: float  # frames a second
    folder: str  # of the files
    stem: str  # of their names
    shape: Shape  # at the first frame
    origin: numpy.ndarray  # of the engine's world, in Blender's: floats are finest there
    track: motion.Track  # of the object
    ends: dict  # of the bones: name -> head and tail, m, in the body's frame
    positions: numpy.ndarray  # float32 (frames, n, 3), in the object's own space at each frame
    warnings: list  # texts


def frame_rate(scene):
    return scene.render.fps / scene.render.fps_base


def begin(scene, thing):
    """A Plan; the scene is at its first frame."""
    plan = Plan()
    plan.scene, plan.thing, plan.unit = scene, thing, metres(scene)
    plan.first, plan.last, plan.rate = scene.frame_start, scene.frame_end, frame_rate(scene)
    if plan.last <= plan.first:
        raise Refused(f'the range of frames, {plan.first} to {plan.last}, is empty')
    plan.folder, plan.stem = work_folder(scene), file_stem(thing)
    plan.shape = rest_shape(thing, plan.unit, thing.tremolo.hold, posed=thing.tremolo.kind == 'CLOTH')
    plan.warnings = []
    plan.origin = numpy.array(thing.matrix_world.translation, float)
    return plan


def check_model(plan):
    """The path of the object's model. Raises Refused where it is missing or of another shape."""
    own = plan.thing.tremolo
    path = bpy.path.abspath(own.model)
    if not own.model or not os.path.exists(path):
        raise Refused(f'{plan.thing.name} has no model yet: press Make' if not own.model else
                      f'the model of {plan.thing.name} is gone ({path}): press Make')
    if not is_of_this_shape(plan.shape, plan.thing, plan.unit):
        raise Refused(f'{plan.thing.name} has changed since its model was made: press Make again')
    return path


def rescaled_job(plan, model):
    """Job: the model with the frequency that the user asks for; its value is (path, frequency)."""
    own = plan.thing.tremolo
    if not own.wobble or not own.frequency:
        return model, own.frequency
    program = find_program('tremolo', programs_folder())
    path = os.path.join(plan.folder, plan.stem + '-tuned.tremolo')
    young = own.young * (own.wobble / own.frequency) ** 2
    yield from run([program, 'export', model, '--rescale', f'young={young!r}', '--rescaled', path], plan.folder)
    return path, own.wobble


def write_motion(plan, name, poses, frames, label):
    """Writes poses as a CSV file; returns the keys of a motion that follows it."""
    path = os.path.join(plan.folder, f'{plan.stem}-{name}.csv')
    rows = motion.rigid_rows(poses, frames, label, plan.first, plan.rate)
    with open(path, 'w', encoding='utf-8') as file:
        file.write(scene_text.poses_csv(rows))
    return {'kind': 'csv', 'file': path}


def pose_keys(pose):
    """position and quaternion of a pose."""
    turn = motion.quaternion(motion.rotation_of(pose[:3, :3], 'the body', 0))
    return {'position': [float(x) for x in pose[:3, 3]], 'quaternion': [float(x) for x in turn]}


def bones_of(plan, body, rest, rig):
    """Adds bones and their weights to the keys of a body."""
    thing, shape = plan.thing, plan.shape
    names, columns = list(shape.weights), list(shape.weights.values())
    total = numpy.sum(columns, axis=0)
    if (total <= 0).any():  # such vertices stay with the object
        names.append(None)
        columns.append((total <= 0).astype(float))
    weights = numpy.array(columns).T
    weights /= weights.sum(axis=1, keepdims=True)
    path = os.path.join(plan.folder, plan.stem + '-weights.csv')
    numpy.savetxt(path, weights, '%.9g', ',')
    maps = motion.bone_maps(plan.track, armature_of(thing), rig, names, plan.first, rest, plan.origin, plan.unit)
    body.update({'bone-weights': path, 'contact': False, 'bones': []})
    for k, name in enumerate(names):
        head, tail = plan.ends[name] if name is not None else (numpy.zeros(3), numpy.zeros(3))
        moved = motion.about(maps[name], head)
        label = f'bone {name}' if name is not None else thing.name
        body['bones'].append({'name': f'bone-{k}', 'head': head.tolist(), 'tail': tail.tolist(),
                              'motion': [write_motion(plan, f'bone-{k}', moved, plan.track.frames, label)]})


def body_keys(plan, model, frequency, rig):
    """Keys of [[bodies]]."""
    own = plan.thing.tremolo
    poses = motion.object_poses(plan.track, plan.shape.stretch, plan.origin, plan.unit)
    rest = poses[plan.track.index(plan.first)]
    body = {'name': 'body', 'model': model, **pose_keys(rest)}
    if frequency > 0 and own.damping > 0:
        body['beta'] = own.damping / (numpy.pi * frequency)
    if not plan.shape.held.any() and not plan.shape.weights:
        return {**body, 'kind': 'free'}
    body['kind'] = 'driven'
    if own.gravity:
        body['start'] = 'static'
    if plan.shape.weights:
        bones_of(plan, body, rest, rig)
    else:
        moved = write_motion(plan, 'motion', poses, plan.track.frames, plan.thing.name)
        body['motion'] = [{**moved, 'frame': 'world'}]
    return body


def cloth_keys(plan):
    """Keys of [[cloths]]. Held vertices follow the places that the animation gives them."""
    own, shape = plan.thing.tremolo, plan.shape
    pose = motion.object_poses(plan.track, shape.stretch, plan.origin, plan.unit)[plan.track.index(plan.first)]
    path = os.path.join(plan.folder, plan.stem + '-cloth.ply')
    write_ply(path, shape.vertices @ pose[:3, :3].T + pose[:3, 3], shape.faces)
    keys = {'name': 'body', 'file': path, 'density': own.area_density, 'structural': own.stretch,
            'shear': own.shear, 'bend': own.bend, 'thickness': own.thickness * plan.unit, 'pins': []}
    times = [(frame - plan.first) / plan.rate for frame in plan.track.frames]
    places = plan.unit * numpy.array(plan.track.pins)
    start = plan.track.index(plan.first)
    for k, vertex in enumerate(numpy.flatnonzero(shape.held)):
        pin = {'at': int(vertex)}
        moved = places[:, k] - places[start, k]
        if numpy.abs(moved).max() > 1e-6 * numpy.ptp(shape.vertices, axis=0).max():
            rows = [[t, *map(float, d)] for t, d in zip(times, moved)]
            pin['motion'] = [{'kind': 'keyframes', 'keys': rows}]
        keys['pins'].append(pin)
    if not keys['pins']:
        del keys['pins']
    return keys


def collider_keys(plan, things, made, tracks):
    """Keys of [[colliders]], one for each obstacle."""
    all_keys = []
    for k, (thing, (keys, shift, stretch), track) in enumerate(zip(things, made, tracks)):
        poses = motion.object_poses(track, stretch, plan.origin, plan.unit)
        for pose in poses:
            pose[:3, 3] += pose[:3, :3] @ shift
        rest = poses[track.index(plan.first)]
        keys = {'name': f'obstacle-{k}', **keys, **pose_keys(rest)}
        if max(numpy.abs(pose - rest).max() for pose in poses) > 1e-7:
            moved = write_motion(plan, f'obstacle-{k}', poses, track.frames, thing.name)
            keys['motion'] = [{**moved, 'frame': 'world'}]
        all_keys.append(keys)
    return all_keys


def sampled_job(plan, things):
    """Job: the tracks of the object, its armature (or None) and the obstacles."""
    thing, cloth = plan.thing, plan.thing.tremolo.kind == 'CLOTH'
    armature = armature_of(thing) if plan.shape.weights and not cloth else None
    pinned = (thing, numpy.flatnonzero(plan.shape.held)) if cloth and plan.shape.held.any() else None
    # Without its modifier a hidden armature would not move.
    shaping = [m for m in split_stack(thing)[0] if pinned or armature and m.type == 'ARMATURE']
    sampled = [thing] + ([armature] if armature else []) + things
    with only(thing, shaping):
        tracks = yield from motion.sample(plan.scene, sampled, plan.first, plan.last,
                                          min(kSamples, plan.scene.tremolo.substeps), pinned)
    rig = tracks.pop(1) if armature else None
    return tracks[0], rig, tracks[1:]


def too_few_steps(frequency, rate, substeps):
    """The warning, if any, that the steps do not follow the slowest shape."""
    if frequency <= 0 or rate * substeps >= kStepsOfPeriod * frequency:
        return []
    needed = int(numpy.ceil(kStepsOfPeriod * frequency / rate))
    return [f'the slowest shape, {frequency:.3g} Hz, has {rate * substeps / frequency:.2g} steps in a period: '
            f'set Sub-steps to {needed} or more']


def scene_job(plan):
    """Job: writes the scene; its value is the path."""
    thing, scene = plan.thing, plan.scene
    cloth = thing.tremolo.kind == 'CLOTH'
    model = None if cloth else check_model(plan)
    things = obstacles_of(scene, thing)
    for other in [thing] + things:
        if not other.visible_get():
            raise Refused(f'{other.name} is hidden, and Blender does not move what it does not show: show it' +
                          (', or untick Obstacle' if other != thing else ''))
    if plan.shape.weights and not cloth:
        plan.ends = bone_ends(scene, thing, plan.shape)
    made = []
    for other in things:
        made.append((yield from obstacle_job(other, plan.unit, plan.folder)))
    plan.track, rig, others = yield from sampled_job(plan, things)
    step = 1 / (plan.rate * scene.tremolo.substeps)
    keys = {'step': step, 'duration': (plan.last - plan.first) / plan.rate}
    if thing.tremolo.gravity and scene.use_gravity:
        keys['gravity'] = [plan.unit * float(x) for x in scene.gravity]
    if cloth:
        keys['cloths'] = [cloth_keys(plan)]
    else:
        model, frequency = yield from rescaled_job(plan, model)
        keys['bodies'] = [body_keys(plan, model, frequency, rig)]
        plan.warnings += too_few_steps(frequency, plan.rate, scene.tremolo.substeps)
    if things:
        keys['colliders'] = collider_keys(plan, things, made, others)
    path = os.path.join(plan.folder, plan.stem + '.toml')
    with open(path, 'w', encoding='utf-8') as file:
        file.write(scene_text.table('', keys))
    return path


def simulate_job(scene, thing):
    """Job: moves an object through the frames of the scene. Its value: the Plan, with `positions`,
    float32 (frames, n, 3), in the object's own space at each frame, and `warnings`."""
    program = find_program('tremolo', programs_folder())
    frame, subframe = scene.frame_current, scene.frame_subframe
    scene.frame_set(scene.frame_start)
    try:
        plan = begin(scene, thing)
        path = yield from scene_job(plan)
    finally:
        scene.frame_set(frame, subframe=subframe)
    out = os.path.join(plan.folder, plan.stem + '-world.pc2')
    done = yield from run([program, 'export', path, '--pc2', out, '--rate', repr(plan.rate), '--json'], plan.folder)
    world = read_pc2(out)
    os.remove(out)
    os.remove(os.path.splitext(out)[0] + '.obj')
    frames = plan.last - plan.first + 1
    if world.shape[:2] != (frames, len(plan.shape.vertices)):
        raise Refused(f'{program} wrote {world.shape[0]} frames of {world.shape[1]} vertices; '
                      f'{frames} of {len(plan.shape.vertices)} are needed')
    plan.positions = motion.to_local(world, plan.track, plan.first, plan.origin, plan.unit)
    plan.warnings += done.warnings()
    return plan
