"""Vertex positions of baked bodies and cloth against the engine's own and against known motions."""
import os

import bpy
import numpy
import support
from case import Case, kFloats, limb, ops, shaken
from support import animate, ball, fresh, hold, own_positions, positions, prepare, refusal, size
from tremolo_blender import point_cache, simulate


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

    def test_a_sheet_with_a_thickness_is_a_solid(self):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=12, y_subdivisions=12)
        thing = bpy.context.object
        prepare(thing, 3e5)
        thing.tremolo.thicken = 0.1
        hold(thing, lambda v: v.co.x < -0.9)
        shaken(thing)
        self.make_and_bake(thing)
        self.assert_engines_own(thing)

    def test_tetrahedra_of_ones_own_are_in_the_coordinates_of_the_object(self):
        self.scene.unit_settings.scale_length = 0.1
        thing = ball(soft=False)
        thing.scale = (2, 2, 2)
        shaken(thing)
        surface = os.path.join(self.folder.name, 'own.ply')
        vertices = [v.co for v in thing.data.vertices]
        point_cache.write_ply(surface, vertices, [list(p.vertices) for p in thing.data.polygons])
        support.program('tremolo-mesh', surface, '-o', 'own.msh', '--tets', '500', folder=self.folder.name)
        thing.tremolo.volume = os.path.join(self.folder.name, 'own.msh')
        wanted = {f: positions(thing, f) for f in range(1, support.kFrames + 1)}
        self.make_and_bake(thing)
        self.assert_same_motion(thing, wanted)
        thing.scale = (2, 2, 1)
        self.assertIn('must be scaled evenly', refusal(ops.make, thing))

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

    def test_a_step_too_long_for_the_slowest_shape_is_warned_of_with_the_number_that_suffices(self):
        self.assertEqual(simulate.too_few_steps(3.0, 24, 3), [])  # 24 steps in a period
        self.assertIn('set Sub-steps to 3 or more', simulate.too_few_steps(3.0, 24, 2)[0])


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
