"""The body of an object: the vertices that the point cache moves, at rest, in metres.

An object at rest maps a vertex x to the world by A x + t. The polar decomposition A = R S splits that into
a rotation R and a stretch S. The engine gets y = unit S x, a body in its own frame, and moves the frame by
(R, unit t). So any scale is part of the body, a negative one too; a scale that is animated is refused."""
import contextlib

import bpy
import numpy

from .programs import Refused

kCacheName = 'Tremolo'  # of the modifier that plays the motion
kHold = 'Hold'  # usual name of the group of vertices that do not move

# Modifiers that only refine what the body's motion has moved: they stay below the cache.
kRefining = {'SUBSURF', 'MULTIRES', 'TRIANGULATE', 'EDGE_SPLIT', 'WEIGHTED_NORMAL', 'NORMAL_EDIT', 'BEVEL',
             'UV_PROJECT', 'UV_WARP', 'VERTEX_WEIGHT_EDIT', 'VERTEX_WEIGHT_MIX', 'VERTEX_WEIGHT_PROXIMITY',
             'PARTICLE_SYSTEM', 'COLLISION', 'SURFACE', 'DATA_TRANSFER'}
kRigid = 1e-4  # largest departure of RᵀR from 1 that counts as a rotation: Blender's matrices are floats


class Shape:
    """The body of an object at one frame, n vertices."""
    local: numpy.ndarray  # (n, 3): the vertices in the object's own space
    vertices: numpy.ndarray  # (n, 3), m, in the body's frame
    faces: list  # of lists of vertices, facing outwards
    held: numpy.ndarray  # (n,), bool
    stretch: numpy.ndarray  # S, (3, 3)
    weights: dict  # of the armature: a bone's name -> (n,)
    place: int  # of the cache in the stack of modifiers
    base: bool  # the vertices are those of the mesh itself


def cache_of(thing):
    """The modifier that plays the motion of an object, or None."""
    for modifier in thing.modifiers:
        if modifier.type == 'MESH_CACHE' and modifier.name.startswith(kCacheName):
            return modifier
    return None


def armature_of(thing):
    """The armature whose bones move an object through a modifier, or None."""
    for modifier in thing.modifiers:
        if modifier.type == 'ARMATURE' and modifier.object and modifier.object.type == 'ARMATURE':
            return modifier.object
    return None


def shown(modifier):
    return modifier.show_viewport or modifier.show_render


def split_stack(thing):
    """(above, place): modifiers that shape the body, and the index at which the cache belongs."""
    place, above = 0, []
    pending = []
    for index, modifier in enumerate(m for m in thing.modifiers if m != cache_of(thing)):
        pending.append(modifier)
        if modifier.type not in kRefining and (shown(modifier) or modifier.type == 'ARMATURE'):
            above += pending
            pending = []
            place = index + 1
    return above, place


def check_object(thing):
    """Raises Refused for an object that cannot be a body, with what to do."""
    if thing is None:
        raise Refused('no object is active: click a mesh object first')
    if thing.type == 'EMPTY' and thing.instance_collection:
        raise Refused(f'{thing.name} is an instance of a collection and has no vertices of its own: '
                      'Object > Apply > Make Instances Real')
    if thing.type != 'MESH':
        raise Refused(f'{thing.name} is no mesh (it is a {thing.type.lower()}): Object > Convert > Mesh')
    if thing.library or thing.data.library:
        raise Refused(f'{thing.name} is linked from another file: Object > Library Override > Make')


def check_same_in_render(above):
    """A cache fits one number of vertices: the window and the render must have the same."""
    for modifier in above:
        if modifier.type == 'ARMATURE' or not shown(modifier):
            continue
        if modifier.show_viewport != modifier.show_render:
            raise Refused(f'modifier {modifier.name} is on in the {"window" if modifier.show_viewport else "render"} '
                          'alone: the body must have the same vertices in both')
        if modifier.type in ('SUBSURF', 'MULTIRES') and modifier.levels != modifier.render_levels:
            raise Refused(f'modifier {modifier.name} has {modifier.levels} levels in the window and '
                          f'{modifier.render_levels} in the render: make them equal, or move it to the end')


@contextlib.contextmanager
def only(thing, modifiers):
    """Meanwhile the object has these modifiers alone."""
    before = [(modifier, modifier.show_viewport) for modifier in thing.modifiers]
    try:
        for modifier, _ in before:
            if modifier.show_viewport and modifier not in modifiers:
                modifier.show_viewport = False
        bpy.context.view_layer.update()
        yield
    finally:
        for modifier, visible in before:
            if modifier.show_viewport != visible:
                modifier.show_viewport = visible


def coordinates(vertices):
    flat = numpy.empty(3 * len(vertices), numpy.float32)
    vertices.foreach_get('co', flat)
    return flat.reshape(-1, 3).astype(float)


def group_weights(thing, mesh, names):
    """Of each group its weights on the vertices of an evaluated mesh."""
    index = {group.index: group.name for group in thing.vertex_groups if group.name in names}
    weights = {name: numpy.zeros(len(mesh.vertices)) for name in index.values()}
    if index:
        for vertex in mesh.vertices:
            for element in vertex.groups:
                if element.group in index:
                    weights[index[element.group]][vertex.index] = element.weight
    return weights


def linear_part(matrix):
    return numpy.array(matrix.to_3x3(), float)


def polar(linear, name):
    """R and S of A = R S, det R = 1. Raises Refused for an object that is flattened."""
    u, sizes, vt = numpy.linalg.svd(linear)
    if sizes[-1] < 1e-6 * max(sizes[0], 1e-30):
        raise Refused(f'{name} is flattened: a scale of it is 0')
    rotation = u @ vt
    sign = numpy.sign(numpy.linalg.det(rotation))
    return sign * rotation, sign * (vt.T @ numpy.diag(sizes) @ vt)


def rotation_of(linear, name, frame):
    """The rotation nearest to a matrix that must be one. Raises Refused if it stretches."""
    if numpy.abs(linear.T @ linear - numpy.eye(3)).max() > kRigid or numpy.linalg.det(linear) < 0:
        raise Refused(f'the scale of {name} changes, at frame {frame:g}: a body keeps its size. '
                      'Animate location and rotation alone')
    u, _, vt = numpy.linalg.svd(linear)
    return u @ vt


def rest_shape(thing, unit, hold='', posed=False, whole=False):
    """The Shape of an object at the present frame. unit: metres of a Blender unit; hold: a vertex group;
    posed: as its armature has it, without bones of its own; whole: with all modifiers, as an obstacle."""
    check_object(thing)
    above, place = split_stack(thing)
    if whole:
        above = [m for m in thing.modifiers if m != cache_of(thing)]
    else:
        check_same_in_render(above)
    armature = None if whole or posed else armature_of(thing)
    used = [m for m in above if whole or posed or m.type != 'ARMATURE']
    shape = Shape()
    shape.place = place
    shape.base = not any(shown(m) for m in used)
    with only(thing, used):
        evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = evaluated.to_mesh()
        try:
            local = coordinates(mesh.vertices)
            shape.faces = [list(polygon.vertices) for polygon in mesh.polygons]
            bones = {bone.name for bone in armature.data.bones if bone.use_deform} if armature else set()
            weights = group_weights(thing, mesh, bones | {hold})
        finally:
            evaluated.to_mesh_clear()
    wrong = numpy.flatnonzero(~numpy.isfinite(local).all(axis=1))
    if len(wrong):
        raise Refused(f'vertex {wrong[0]} of {thing.name} is not a number')
    shape.held = weights.pop(hold, numpy.zeros(len(local))) > 0.5
    shape.weights = {name: row for name, row in weights.items() if row.any()}
    if armature and not shape.weights:
        raise Refused(f'{armature.name} moves {thing.name} without vertex groups: '
                      'Parent > Armature Deform > With Automatic Weights')
    _, shape.stretch = polar(linear_part(thing.matrix_world), thing.name)
    shape.local, shape.vertices = local, unit * local @ shape.stretch.T
    if numpy.linalg.det(shape.stretch) < 0:
        shape.faces = [face[::-1] for face in shape.faces]
    return shape
