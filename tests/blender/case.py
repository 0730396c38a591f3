"""The base of the cases in Blender: bakes an object and compares its positions; bodies that several cases have."""
import unittest

import bpy
import numpy
import support
from mathutils import Matrix
from support import animate, fresh, own_positions, positions, prepare, select, size

ops = bpy.ops.tremolo

# Of the size: the engine's files and Blender's meshes are floats, whose last bit is 6e-8 of a coordinate.
kFloats = 1e-6
# Of the size: a body of 1e12 Pa is rigid except for the bending by the animation's accelerations.
kStiff = 2e-5


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = support.work_folder()
        self.scene = fresh(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def make_and_bake(self, thing, output='PC2'):
        select(thing)
        if thing.tremolo.kind == 'SOLID':
            self.assertEqual(ops.make(), {'FINISHED'})
        self.scene.tremolo.output = output
        self.assertEqual(ops.bake(), {'FINISHED'})

    def assert_engines_own(self, thing, body='body'):
        worst, moved = 0.0, 0.0
        rest = numpy.array([thing.matrix_world @ v.co for v in thing.data.vertices])
        for frame, wanted in own_positions(self.scene, thing, body).items():
            found = positions(thing, frame)
            self.assertEqual(found.shape, wanted.shape)
            worst = max(worst, numpy.abs(found - wanted).max() / size(wanted))
            moved = max(moved, numpy.abs(found - rest).max() / size(wanted))
        print(f'{self.id()}: {worst:.1e} of the size from the engine, moved by {moved:.2g}')
        self.assertLess(worst, kFloats)
        self.assertGreater(moved, 0.01)  # else nothing was compared

    def assert_same_motion(self, thing, wanted, tolerance=kStiff, frames=(1, 7, 20, 33, 41)):
        """wanted: frame -> positions in the world."""
        worst = 0.0
        for frame in frames:
            found = positions(thing, frame)
            self.assertEqual(found.shape, wanted[frame].shape)
            worst = max(worst, numpy.abs(found - wanted[frame]).max() / size(wanted[frame]))
        print(f'{self.id()}: {worst:.1e} of the size from the known motion')
        self.assertLess(worst, tolerance)


def shaken(thing, where=(0, 0, 0)):
    x, y, z = where
    animate(thing, 'location', {1: (x, y, z), 12: (x + 0.8, y, z + 0.1), 20: (x, y + 0.3, z), 41: (x + 0.2, y, z)})
    animate(thing, 'rotation_euler', {1: (0, 0, 0.3), 15: (0.4, 0, 0.1), 41: (0, 0.5, 0.8)})


def limb(scene, young):
    """A long ball on two bones of a rotated, scaled armature that bends and moves."""
    bpy.ops.object.armature_add(enter_editmode=True)
    rig = bpy.context.object
    rig.name = 'Rig'
    bones = rig.data.edit_bones
    upper = bones[0]
    upper.name, upper.head, upper.tail = 'upper', (0, 0, -0.9), (0, 0, 0)
    lower = bones.new('lower')
    lower.head, lower.tail, lower.parent = (0, 0, 0), (0, 0, 0.9), upper
    bpy.ops.object.mode_set(mode='OBJECT')
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    thing = bpy.context.object
    thing.name = 'Limb'
    thing.data.transform(Matrix.Diagonal((0.4, 0.4, 1, 1)))
    for name, sign in (('upper', -1), ('lower', 1)):
        group = thing.vertex_groups.new(name=name)
        for v in thing.data.vertices:
            group.add([v.index], min(1, max(0, 0.5 + sign * v.co.z / 0.6)), 'REPLACE')
    thing.parent = rig
    modifier = thing.modifiers.new('Armature', 'ARMATURE')
    modifier.object = rig
    rig.scale = (1.5, 1.5, 1.5)
    rig.location = (2, 1, 0)
    rig.rotation_euler = (0.2, 0.3, 0)
    animate(rig, 'location', {1: (2, 1, 0), 25: (2.5, 1, 0.2), 41: (2, 1, 0)})
    bend = rig.pose.bones['lower']
    bend.rotation_mode = 'XYZ'
    animate(bend, 'rotation_euler', {1: (0.1, 0, 0), 18: (0.7, 0.2, 0), 30: (0.2, 0, 0.1), 41: (0.4, 0, 0)})
    prepare(thing, young)
    return thing, rig
