"""Objects that are refused, with the words; work that is cancelled; files that are opened again."""
import os

import bpy
import numpy
import support
from case import Case, ops, shaken
from support import animate, ball, positions, refusal, select
from tremolo_blender import make, motion, programs, simulate


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
        pause, motion.kPause = motion.kPause, 0  # It then hands back after each sample, however fast the machine is.
        try:
            for _ in range(3):
                next(job)
        finally:
            motion.kPause = pause
        self.assertNotEqual(self.scene.frame_current, 17)
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
