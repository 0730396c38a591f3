"""The motion of objects and bones, sampled from Blender's animation, as poses for the engine."""
import time

import bpy
import numpy

from .rest_shape import coordinates, rotation_of

kPause = 0.5  # s of reading between two times at which the window is drawn
kMargin = 2  # frames before and after the range: they give the speeds at its ends


class Track:
    """The motion of an object: k samples."""

    def __init__(self, name):
        self.name = name
        self.frames = []  # k
        self.matrices = []  # k of 4 x 4: to the world
        self.bones = {}  # of an armature: a bone's name -> k of 4 x 4, to the armature
        self.pins = []  # k of (n, 3): places of vertices in the world, if asked for

    def index(self, frame):
        """Of the sample at a whole frame."""
        return int(numpy.argmin(numpy.abs(numpy.array(self.frames) - frame)))

    def at(self, frame):
        """The matrix at a whole frame."""
        return self.matrices[self.index(frame)]


def sample(scene, things, first, last, per_frame, pinned=None):
    """Job: a Track of each object, per_frame samples in each frame from first to last and beyond them.

    pinned: (object, vertices) whose places are also kept, in the world: track.pins, (k, n, 3)."""
    tracks = [Track(thing.name) for thing in things]
    count = (last - first + 2 * kMargin) * per_frame + 1
    due = time.monotonic() + kPause
    before, subframe = scene.frame_current, scene.frame_subframe
    try:
        for k in range(count):
            frame = first - kMargin + k / per_frame
            scene.frame_set(int(numpy.floor(frame)), subframe=frame - numpy.floor(frame))
            graph = bpy.context.evaluated_depsgraph_get()
            for thing, track in zip(things, tracks):
                evaluated = thing.evaluated_get(graph)
                track.frames.append(frame)
                track.matrices.append(numpy.array(evaluated.matrix_world, float))
                if thing.type == 'ARMATURE':
                    for bone in evaluated.pose.bones:
                        track.bones.setdefault(bone.name, []).append(numpy.array(bone.matrix, float))
                if pinned and thing == pinned[0]:
                    track.pins.append(_world_places(evaluated, pinned[1]))
            if time.monotonic() >= due:
                yield k / count, 'reading the animation'
                due = time.monotonic() + kPause
    finally:
        scene.frame_set(before, subframe=subframe)
    return tracks


def _world_places(evaluated, vertices):
    local = coordinates(evaluated.to_mesh().vertices)[vertices]
    evaluated.to_mesh_clear()
    matrix = numpy.array(evaluated.matrix_world, float)
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def quaternion(rotation):
    """w, x, y, z of a rotation: the eigenvector of the largest eigenvalue (Bar-Itzhack 2000)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    k = numpy.array([[a + e + i, h - f, c - g, d - b], [h - f, a - e - i, b + d, c + g],
                     [c - g, b + d, e - a - i, f + h], [d - b, c + g, f + h, i - a - e]])
    return numpy.linalg.eigh(k)[1][:, -1]


def rigid_rows(matrices, frames, name, first, rate):
    """Rows t, x, y, z, qw, qx, qy, qz of matrices that must be rigid, without jumps of sign."""
    rows, last = [], numpy.array([1.0, 0, 0, 0])
    for matrix, frame in zip(matrices, frames):
        turn = quaternion(rotation_of(matrix[:3, :3], name, frame))
        if turn @ last < 0:
            turn = -turn
        last = turn
        rows.append([(frame - first) / rate, *matrix[:3, 3], *turn])
    return rows


def object_poses(track, stretch, origin, unit):
    """Poses (k, 4, 4) of the frame of a body, in metres about `origin` (Blender's units): A(t) = R(t) S."""
    inverse = numpy.linalg.inv(stretch)
    poses = []
    for matrix in track.matrices:
        pose = numpy.eye(4)
        pose[:3, :3] = matrix[:3, :3] @ inverse
        pose[:3, 3] = unit * (matrix[:3, 3] - origin)
        poses.append(pose)
    return poses


def scaled(matrix, unit, origin):
    """A map of the world in Blender's units as one in metres about `origin`."""
    result = matrix.copy()
    result[:3, 3] = unit * (matrix[:3, 3] + matrix[:3, :3] @ origin - origin)
    return result


def bone_maps(track, armature, rig, names, first, rest, origin, unit):
    """Of each bone (None: the object itself) its maps of the body's rest, (k, 4, 4), in the body's frame.

    track: of the object; rig: of the armature; first: the frame of rest; rest: the pose of the body's frame, in
    metres. Blender moves a vertex by A⁻¹ W P B⁻¹ W⁻¹ A: W the armature, P and B its bone posed and at rest, A the object."""
    start = numpy.linalg.inv(track.at(first))
    back = numpy.linalg.inv(rest)
    maps = {}
    for name in names:
        found = []
        bone_rest = None if name is None else numpy.linalg.inv(numpy.array(armature.data.bones[name].matrix_local))
        for k, matrix in enumerate(track.matrices):
            world = matrix @ start
            if name is not None:
                frame = rig.matrices[k]
                world = frame @ rig.bones[name][k] @ bone_rest @ numpy.linalg.inv(frame) @ world
            found.append(back @ scaled(world, unit, origin) @ rest)
        maps[name] = found
    return maps


def about(maps, head):
    """The same maps as motions about a point: y -> head + d + R (y - head)."""
    moved = []
    for matrix in maps:
        pose = matrix.copy()
        pose[:3, 3] = matrix[:3, 3] + matrix[:3, :3] @ head - head
        moved.append(pose)
    return moved


def to_local(world, track, first, origin, unit):
    """Positions of the world in metres, (frames, n, 3), as those of the object's own space at each frame."""
    local = numpy.empty(world.shape, numpy.float32)
    for k, points in enumerate(world):
        inverse = numpy.linalg.inv(track.at(first + k))
        local[k] = (points.astype(float) / unit + origin) @ inverse[:3, :3].T + inverse[:3, 3]
    return local

