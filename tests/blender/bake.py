"""The add-on in Blender without a window: vertex positions against the engine's own and against known motions,
and what it refuses.

    blender -b --python tests/blender/bake.py [-- NAME...]

TREMOLO_PROGRAMS: the folder of the programs; build/bin by default. NAME: of a case, e.g. Baking."""
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bpy  # noqa: E402
import numpy  # noqa: E402
import support  # noqa: E402
from mathutils import Matrix  # noqa: E402
from support import animate, ball, fresh, hold, own_positions, positions, prepare, refusal, select, size  # noqa: E402
from tremolo_blender import make, programs, simulate  # noqa: E402

ops = bpy.ops.tremolo

# Of the size: the engine's files and Blender's meshes are floats, whose last bit is 6e-8 of a coordinate.
kFloats = 1e-6
# Of the size: a body of 1e12 Pa is rigid but for what the animation's accelerations bend it by.
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


class Baking(Case):
    def test_an_animated_body_is_where_the_engine_has_it(self):
        thing = ball()
        shaken(thing)
        self.make_and_bake(thing)
        self.assert_engines_own(thing)

    def test_it_is_so_in_centimetres_with_a_negative_scale_at_thirty_frames_and_off_the_origin(self):
        self.scene.unit_settings.scale_length = 0.01
        self.scene.render.fps = 30
        thing = ball(radius=50, held=lambda v: v.co.z < -30)
        thing.scale = (-1.2, 0.8, 1.5)
        shaken(thing, (120, -80, 60))
        thing.location[0] += 30
        self.make_and_bake(thing)
        self.assert_engines_own(thing)

    def test_a_stiff_body_follows_its_animation_at_any_scale(self):
        for scale in ((1, 1, 1), (-1, 1, 1), (0.5, -2, 1.3), (-1, -1, -1)):
            with self.subTest(scale=scale):
                self.scene = fresh(self.folder.name)
                thing = ball(soft=False)
                thing.scale = scale
                shaken(thing, (3, 2, 1))
                wanted = {f: positions(thing, f) for f in range(1, support.kFrames + 1)}
                self.make_and_bake(thing)
                self.assert_same_motion(thing, wanted)

    def test_a_sheared_child_of_a_scaled_parent_follows_too(self):
        bpy.ops.object.empty_add()
        parent = bpy.context.object
        parent.scale = (2, 1, 0.7)
        thing = ball(soft=False)
        thing.parent = parent
        thing.rotation_euler = (0.5, 0.4, 0.3)
        animate(parent, 'rotation_euler', {1: (0, 0, 0), 20: (0.2, 0.3, 0.8), 41: (0, 0, 0)})
        wanted = {f: positions(thing, f) for f in range(1, support.kFrames + 1)}
        self.make_and_bake(thing)
        self.assert_same_motion(thing, wanted)

    def test_a_free_body_falls_as_gravity_says_in_the_units_of_the_scene(self):
        self.scene.unit_settings.scale_length = 0.1
        thing = ball(held=lambda v: False)
        thing.location = (5, -3, 20)
        bpy.context.view_layer.update()
        start = positions(thing, 1).mean(axis=0)
        self.make_and_bake(thing)
        for frame in (11, 41):
            t = (frame - 1) / 24
            fallen = numpy.array(self.scene.gravity) * t * t / 2
            moved = positions(thing, frame).mean(axis=0) - start
            # Blender's units, as its own bodies fall; floats after 14 of them.
            numpy.testing.assert_allclose(moved, fallen, atol=5e-6)

    def test_pc2_mdd_and_shape_keys_show_the_same(self):
        thing = ball()
        shaken(thing)
        self.make_and_bake(thing)
        cache = {f: positions(thing, f, world=False) for f in (1, 7, 20, 41, 60)}
        for output in ('MDD', 'KEYS'):
            self.make_and_bake(thing, output)
            for frame, wanted in cache.items():
                # A key's weight of 1 is exact; its sum with the rest shape is a sum of floats.
                numpy.testing.assert_allclose(positions(thing, frame, world=False), wanted, atol=5e-7)
        self.assertEqual(len(thing.modifiers), 0)
        self.assertEqual(ops.clear(), {'FINISHED'})
        self.assertIsNone(thing.data.shape_keys)

    def test_a_second_bake_replaces_the_first(self):
        thing = ball()
        shaken(thing)
        self.make_and_bake(thing)
        first = positions(thing, 20)
        self.assertEqual(ops.jiggle(), {'FINISHED'})
        self.assertEqual(ops.bake(), {'FINISHED'})
        self.assertEqual([m.type for m in thing.modifiers], ['MESH_CACHE'])
        numpy.testing.assert_array_equal(positions(thing, 20), first)

    def test_the_frequency_that_is_asked_for_is_that_of_the_motion(self):
        thing = ball()
        thing.tremolo.gravity = False
        thing.tremolo.damping = 0
        thing.tremolo.wobble = 3
        animate(thing, 'location', {1: (0, 0, 0), 3: (0.05, 0, 0)})
        self.scene.frame_end = 121
        self.make_and_bake(thing)
        top = max(thing.data.vertices, key=lambda v: v.co.z).index
        x = numpy.array([positions(thing, f)[top, 0] for f in range(5, 122)])
        crossings = numpy.flatnonzero(numpy.diff(numpy.sign(x - x.mean())) > 0)
        # Three a second; a crossing is known to a frame, of 24, and the motion is a little nonlinear.
        seconds = (crossings[-1] - crossings[0]) / 24
        self.assertAlmostEqual((len(crossings) - 1) / seconds, 3, delta=0.15)


class Stack(Case):
    def test_the_body_has_the_vertices_of_a_mirror_and_a_subdivision_follows_it(self):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
        thing = bpy.context.object
        thing.name = 'Half'
        keep = [v.co.x for v in thing.data.vertices]
        bpy.ops.object.mode_set(mode='EDIT')
        bpy.ops.mesh.bisect(plane_co=(0, 0, 0), plane_no=(1, 0, 0), clear_inner=True)
        bpy.ops.object.mode_set(mode='OBJECT')
        self.assertLess(len(thing.data.vertices), len(keep))
        prepare(thing, 3e4)
        hold(thing, lambda v: v.co.z < -0.7)
        thing.modifiers.new('Mirror', 'MIRROR')
        thing.modifiers.new('Subdivision', 'SUBSURF')
        shaken(thing)
        self.make_and_bake(thing)
        self.assertEqual([m.type for m in thing.modifiers], ['MIRROR', 'MESH_CACHE', 'SUBSURF'])
        thing.modifiers['Subdivision'].show_viewport = False
        found = own_positions(self.scene, thing)
        for frame, wanted in found.items():
            self.assertLess(numpy.abs(positions(thing, frame) - wanted).max() / size(wanted), kFloats)
        thing.modifiers['Subdivision'].show_viewport = True
        self.assertGreater(len(positions(thing, 20)), 3 * len(wanted))

    def test_one_of_two_objects_with_the_same_mesh_moves_alone(self):
        first = ball()
        second = first.copy()
        bpy.context.collection.objects.link(second)
        second.location = (4, 0, 0)
        shaken(first)
        before = positions(second, 20)
        self.make_and_bake(first)
        numpy.testing.assert_array_equal(positions(second, 20), before)
        self.assert_engines_own(first)
        self.scene.tremolo.output = 'KEYS'
        self.assertIn('2 objects have the mesh of Ball', refusal(ops.bake, first))

    def test_a_stiff_body_on_bones_is_where_the_armature_modifier_has_it(self):
        thing, rig = limb(self.scene, 1e12)
        rig.hide_set(True)
        wanted = {f: positions(thing, f) for f in range(1, support.kFrames + 1)}
        self.make_and_bake(thing)
        self.assert_same_motion(thing, wanted)
        self.assertEqual([m.type for m in thing.modifiers], ['ARMATURE', 'MESH_CACHE'])

    def test_a_soft_body_on_bones_is_where_the_engine_has_it(self):
        thing, rig = limb(self.scene, 2e4)
        self.make_and_bake(thing)
        self.assert_engines_own(thing)


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


class Obstacles(Case):
    def test_a_free_body_comes_to_rest_on_a_plane_that_rises(self):
        thing = ball(held=lambda v: False)
        thing.location = (0, 0, 1.3)
        bpy.ops.mesh.primitive_plane_add(size=10)
        floor = bpy.context.object
        floor.tremolo.collider = True
        animate(floor, 'location', {1: (0, 0, 0), 30: (0, 0, 0.5)})
        self.scene.frame_end = 81
        self.make_and_bake(thing)
        low = positions(thing, 81)[:, 2].min()
        self.assertGreater(low, 0.5 - 0.03)  # the margin of contact is 0.5 % of 2 m, deeper where it presses
        self.assertLess(low, 0.6)

    def test_a_body_with_obstacles_of_every_shape_is_where_the_engine_has_it(self):
        thing = ball(held=lambda v: False)
        thing.location = (0, 0, 2.4)
        for k, shape in enumerate(('BOX', 'SPHERE', 'MESH')):
            bpy.ops.mesh.primitive_cube_add(size=1.2, location=(1.2 * k - 1.2, 0.3 * k, 0.3))
            obstacle = bpy.context.object
            obstacle.scale = (1, -1, 1) if shape != 'SPHERE' else (0.9, 0.9, 0.9)
            obstacle.tremolo.collider, obstacle.tremolo.shape = True, shape
        self.make_and_bake(thing)
        self.assert_engines_own(thing)

    def test_cloth_hangs_by_what_is_held_and_lies_over_an_obstacle(self):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=20, y_subdivisions=20, size=2, location=(0, 0, 1.2))
        sheet = bpy.context.object
        sheet.name = 'Sheet'
        sheet.tremolo.kind = 'CLOTH'
        hold(sheet, lambda v: v.co.x < -0.99 and abs(v.co.y) > 0.9)
        animate(sheet, 'location', {1: (0, 0, 1.2), 41: (0.5, 0, 1.4)})
        pinned = [v.index for v in sheet.data.vertices if v.co.x < -0.99 and abs(v.co.y) > 0.9]
        wanted = {f: positions(sheet, f)[pinned] for f in (1, 20, 41)}
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0.3, 0, 0.5))
        ball_ = bpy.context.object
        ball_.tremolo.collider, ball_.tremolo.shape = True, 'SPHERE'
        self.make_and_bake(sheet)
        self.assert_engines_own(sheet)
        for frame, where in wanted.items():
            numpy.testing.assert_allclose(positions(sheet, frame)[pinned], where, atol=2e-6)
        nearest = min(numpy.linalg.norm(positions(sheet, f) - (0.3, 0, 0.5), axis=1).min() for f in range(1, 42))
        # It keeps its `thickness`, 5 mm, from the obstacle, and lies on it at some time.
        self.assertAlmostEqual(nearest, 0.505, delta=1e-3)


class Refusals(Case):
    def refused(self, thing, words, operator=None):
        text = refusal(operator or ops.make, thing)
        print(f'{self.id()}: {text.strip()}')
        self.assertIn(words, text)

    def test_objects_that_are_no_bodies_are_refused_with_the_remedy(self):
        bpy.ops.mesh.primitive_plane_add()
        self.refused(bpy.context.object, '--thicken')  # the engine's own word
        empty = bpy.data.objects.new('Points', bpy.data.meshes.new('points'))
        bpy.context.collection.objects.link(empty)
        self.refused(empty, 'it holds no triangles')
        empty.data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1), (1, 2)], [])
        self.refused(empty, 'it holds no triangles')
        bpy.ops.curve.primitive_bezier_circle_add()
        self.refused(bpy.context.object, 'Object > Convert > Mesh')
        group = bpy.data.collections.new('Group')
        bpy.ops.object.collection_instance_add(collection=group.name)
        self.refused(bpy.context.object, 'Make Instances Real')
        flat = ball('Flat')
        flat.scale = (1, 1, 0)
        self.refused(flat, 'is flattened')

    def test_a_vertex_that_is_no_number_is_refused_by_its_number(self):
        thing = ball()
        thing.data.vertices[3].co.x = float('nan')
        self.refused(thing, 'vertex 3 of Ball is not a number')

    def test_a_model_that_is_missing_or_old_is_refused(self):
        thing = ball()
        self.refused(thing, 'press Make', ops.jiggle)
        select(thing)
        ops.make()
        thing.data.vertices[0].co.z += 0.1
        self.refused(thing, 'press Make again', ops.jiggle)
        thing.data.vertices[0].co.z -= 0.1
        thing.scale = (1, 1, 1.001)
        self.refused(thing, 'press Make again', ops.jiggle)
        thing.scale = (1, 1, 1)
        thing.rotation_euler = (0.3, 0.2, 0.1)  # and this changes nothing
        self.assertEqual(ops.jiggle(), {'FINISHED'})
        os.remove(thing.tremolo.model)
        self.refused(thing, 'is gone', ops.bake)

    def test_a_scale_that_is_animated_is_refused_with_its_frame(self):
        thing = ball()
        animate(thing, 'scale', {1: (1, 1, 1), 20: (1.5, 1, 1)})
        select(thing)
        ops.make()
        self.refused(thing, 'the scale of Ball changes, at frame', ops.jiggle)

    def test_a_jump_and_a_body_inside_an_obstacle_are_refused_in_the_engines_words(self):
        thing = ball()
        select(thing)
        ops.make()
        animate(thing, 'location', {1: (0, 0, 0), 10: (900, 0, 0)})
        for curve in thing.animation_data.action.fcurves:
            for point in curve.keyframe_points:
                point.interpolation = 'CONSTANT'
        self.refused(thing, 'm/s', ops.jiggle)
        thing.animation_data_clear()
        thing.location = (0, 0, 0)
        bpy.ops.mesh.primitive_plane_add()
        bpy.context.object.tremolo.collider = True
        self.refused(thing, 'obstacle-0', ops.jiggle)

    def test_a_hidden_obstacle_is_refused(self):
        thing = ball()
        select(thing)
        ops.make()
        bpy.ops.mesh.primitive_plane_add(location=(0, 0, -3))
        bpy.context.object.tremolo.collider = True
        bpy.context.object.hide_set(True)
        self.refused(thing, 'Plane is hidden', ops.jiggle)

    def test_modifiers_that_differ_in_the_render_are_refused(self):
        thing = ball()
        thing.modifiers.new('Mirror', 'MIRROR').show_render = False
        self.refused(thing, 'modifier Mirror is on in the window alone')

    def test_missing_programs_are_named_with_the_place_to_set_them(self):
        thing = ball()
        kept, path = os.environ.pop('TREMOLO_PROGRAMS'), os.environ['PATH']
        os.environ['PATH'] = '/nowhere'
        try:
            self.refused(thing, 'Preferences > Add-ons > Tremolo')
        finally:
            os.environ['TREMOLO_PROGRAMS'], os.environ['PATH'] = kept, path


class Work(Case):
    def test_a_job_that_is_closed_ends_its_program_and_leaves_no_file(self):
        thing = ball(subdivisions=5)
        thing.tremolo.tets = 20000
        job = make.make_job(self.scene, thing)
        children = []
        start = programs.Program.__init__

        def remember(program, *arguments):
            start(program, *arguments)
            children.append(program.process)

        programs.Program.__init__ = remember
        try:
            for _ in range(20):
                next(job)
            job.close()
        finally:
            programs.Program.__init__ = start
        self.assertEqual(len(children), 1)
        self.assertNotEqual(children[0].poll(), None)
        left = [name for name in os.listdir(self.folder.name) if 'tremolo' in name]
        self.assertEqual(left, [])

    def test_the_frame_and_the_modifiers_are_as_they_were_after_a_cancelled_job(self):
        thing = ball()
        thing.modifiers.new('Subdivision', 'SUBSURF')
        select(thing)
        ops.make()
        self.scene.frame_set(17)
        job = simulate.simulate_job(self.scene, thing)
        for _ in range(3):
            next(job)
        job.close()
        self.assertEqual(self.scene.frame_current, 17)
        self.assertTrue(thing.modifiers[0].show_viewport)

    def test_a_saved_file_shows_the_motion_without_the_add_on(self):
        self.scene.tremolo.folder = '//tremolo'
        thing = ball()
        shaken(thing)
        self.assertIn('save the .blend first', refusal(ops.bake, thing))
        path = os.path.join(self.folder.name, 'shot.blend')
        bpy.ops.wm.save_as_mainfile(filepath=path)
        self.make_and_bake(thing)
        wanted = positions(thing, 20)
        self.scene.frame_set(1)
        bpy.ops.wm.save_mainfile()
        moved = os.path.join(self.folder.name, 'moved')
        os.mkdir(moved)
        for name in ('shot.blend', 'tremolo'):
            os.rename(os.path.join(self.folder.name, name), os.path.join(moved, name))
        found = support.blender(os.path.join(moved, 'shot.blend'), '''
import bpy, json
bpy.context.scene.frame_set(20)
thing = bpy.data.objects['Ball']
assert not hasattr(thing, 'tremolo')
evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
print(json.dumps({'points': [list(evaluated.matrix_world @ v.co) for v in evaluated.to_mesh().vertices]}))
''')
        numpy.testing.assert_allclose(numpy.array(found['points']), wanted, atol=1e-6)
        bpy.ops.wm.open_mainfile(filepath=os.path.join(moved, 'shot.blend'))
        again = bpy.data.objects['Ball']
        self.assertTrue(again.tremolo.summary)
        select(again)
        self.assertEqual(ops.jiggle(), {'FINISHED'})
        numpy.testing.assert_allclose(positions(again, 20), wanted, atol=1e-6)


if __name__ == '__main__':
    support.run_tests()
