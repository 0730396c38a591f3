"""The buttons. Make, Jiggle and Bake work in the background and end at Esc or Cancel; called by a script
(`bpy.ops.tremolo.make()`) they return when the work is done."""
import os

import bpy

from . import playback
from .make import make_job
from .programs import Refused, wait_for
from .rest_shape import check_object
from .simulate import simulate_job

kTick = 0.05  # s between two looks at the work


def note(operator, kind, text):
    """Shows a text, also where an operator has ended by a timer."""
    operator.report({kind}, text)


class TREMOLO_OT_hold(bpy.types.Operator):
    """The selected vertices follow the animation; the rest of the body follows them by its stiffness"""
    bl_idname = 'tremolo.hold'
    bl_label = 'Hold'
    bl_options = {'REGISTER', 'UNDO'}
    action: bpy.props.EnumProperty(name='Vertices', default='REPLACE', items=[
        ('REPLACE', 'These alone', 'Hold the selected vertices and no others'),
        ('ADD', 'These too', 'Hold the selected vertices besides the others'),
        ('REMOVE', 'Not these', 'Release the selected vertices')])

    def execute(self, context):
        thing = context.object
        try:
            check_object(thing)
        except Refused as error:
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}
        editing = thing.mode == 'EDIT'
        if editing:
            bpy.ops.object.mode_set(mode='OBJECT')
        chosen = [v.index for v in thing.data.vertices if v.select]
        if not chosen and self.action != 'REPLACE':
            self.report({'WARNING'}, 'no vertex is selected')
        name = thing.tremolo.hold
        group = thing.vertex_groups.get(name) or thing.vertex_groups.new(name=name)
        if self.action == 'REPLACE':
            group.remove(range(len(thing.data.vertices)))
        if self.action == 'REMOVE':
            group.remove(chosen)
        elif chosen:
            group.add(chosen, 1.0, 'REPLACE')
        thing.tremolo.hold = group.name
        if editing:
            bpy.ops.object.mode_set(mode='EDIT')
        done = {'REPLACE': 'are held', 'ADD': 'are held too', 'REMOVE': 'are released'}[self.action]
        self.report({'INFO'}, f'{len(chosen)} vertices {done}')
        return {'FINISHED'}


class Work:
    """Base of the operators with a job. job(scene, thing) is the work, keep(thing, value) its result."""
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return context.object is not None and not context.window_manager.tremolo.running

    def begin(self, context):
        thing = context.object
        check_object(thing)
        if thing.mode != 'OBJECT':
            bpy.ops.object.mode_set(mode='OBJECT')
        self.scene_name, self.thing_name = context.scene.name, thing.name
        self.check_scene(context.scene, thing)
        return self.job(context.scene, thing)

    def check_scene(self, scene, thing):
        pass

    def end(self, value):
        """The objects may be gone: undo and other files do not wait for the work."""
        thing = bpy.data.objects.get(self.thing_name)
        if thing is None:
            raise Refused(f'{self.thing_name} is gone')
        for warning in value['warnings'] if isinstance(value, dict) else value.warnings:
            note(self, 'WARNING', warning)
        note(self, 'INFO', self.keep(thing, value))

    def execute(self, context):
        try:
            def report(fraction, text):
                print(f'Tremolo: {100 * fraction:3.0f} % {text}', flush=True)
            self.end(wait_for(self.begin(context), report))
        except Refused as error:
            note(self, 'ERROR', str(error))
            return {'CANCELLED'}
        return {'FINISHED'}

    def invoke(self, context, _event):
        try:
            self.work = self.begin(context)
        except Refused as error:
            note(self, 'ERROR', str(error))
            return {'CANCELLED'}
        state = context.window_manager.tremolo
        state.running, state.cancel, state.fraction, state.text = True, False, 0, self.bl_label
        self.shown = None
        self.timer = context.window_manager.event_timer_add(kTick, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        state = context.window_manager.tremolo
        if state.cancel or event.type == 'ESC':
            self.leave(context)
            note(self, 'WARNING', f'{self.bl_label} was cancelled')
            return {'CANCELLED'}
        if event.type != 'TIMER':
            return {'PASS_THROUGH'}
        try:
            fraction, text = next(self.work)
        except StopIteration as finished:
            self.leave(context)
            return self.finish(finished.value)
        except (Refused, ReferenceError) as error:
            self.leave(context)
            note(self, 'ERROR', str(error))
            return {'CANCELLED'}
        except Exception:
            self.leave(context)
            raise
        if self.shown == (fraction, text):
            return {'RUNNING_MODAL'}
        self.shown = (fraction, text)
        state.fraction, state.text = 100 * fraction, text
        context.workspace.status_text_set(f'{self.bl_label}: {text}, {100 * fraction:.0f} % (Esc: cancel)')
        self.redraw(context)
        return {'RUNNING_MODAL'}

    def finish(self, value):
        try:
            self.end(value)
        except (Refused, ReferenceError) as error:
            note(self, 'ERROR', str(error))
            return {'CANCELLED'}
        return {'FINISHED'}

    def cancel(self, context):
        """Blender ends, or opens another file."""
        self.leave(context)

    def leave(self, context):
        self.work.close()  # ends the programs
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.tremolo.running = False
        if context.workspace:
            context.workspace.status_text_set(None)
        self.redraw(context)

    @staticmethod
    def redraw(context):
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                for region in area.regions:
                    if area.type == 'VIEW_3D' and region.type == 'UI':
                        region.tag_redraw()


class TREMOLO_OT_make(Work, bpy.types.Operator):
    """Compute how this body can deform. Seconds for most; once for a shape and its held vertices"""
    bl_idname = 'tremolo.make'
    bl_label = 'Make'

    def check_scene(self, scene, thing):
        if thing.tremolo.kind == 'CLOTH':
            raise Refused('cloth needs no model: press Jiggle')

    def job(self, scene, thing):
        return make_job(scene, thing)

    def keep(self, thing, value):
        for name in ('model', 'made_of', 'made_stretch', 'frequency', 'summary'):
            setattr(thing.tremolo, name, value[name])
        return value['summary']


class TREMOLO_OT_jiggle(Work, bpy.types.Operator):
    """Move the body by the animation of its object or armature, over the frames of the scene, and show it"""
    bl_idname = 'tremolo.jiggle'
    bl_label = 'Jiggle'

    def job(self, scene, thing):
        return simulate_job(scene, thing)

    def keep(self, thing, plan):
        plan.thing = thing
        playback.play_cache(plan, os.path.join(plan.folder, f'{plan.stem}-jiggle.pc2'))
        if not bpy.data.filepath:
            note(self, 'WARNING', 'the .blend is not saved: the motion is lost when Blender ends. Save, then Bake')
        return f'frames {plan.first} to {plan.last}: play the animation'


class TREMOLO_OT_bake(Work, bpy.types.Operator):
    """Keep the motion: in a point cache beside the .blend, or as shape keys in it"""
    bl_idname = 'tremolo.bake'
    bl_label = 'Bake'

    def check_scene(self, scene, thing):
        if scene.tremolo.output != 'KEYS' and not bpy.data.filepath and scene.tremolo.folder.startswith('//'):
            raise Refused('save the .blend first: its cache is written beside it')

    def job(self, scene, thing):
        return simulate_job(scene, thing)

    def keep(self, thing, plan):
        plan.thing = thing
        output = plan.scene.tremolo.output
        if output == 'KEYS':
            playback.play_keys(plan)
            return f'{len(plan.positions)} shape keys'
        path = os.path.join(plan.folder, f'{plan.stem}.{output.lower()}')
        playback.play_cache(plan, path)
        return f'{path}: {len(plan.positions)} frames of {plan.positions.shape[1]} vertices'


class TREMOLO_OT_clear(bpy.types.Operator):
    """Remove the motion from the object; its model stays"""
    bl_idname = 'tremolo.clear'
    bl_label = 'Clear'
    bl_options = {'REGISTER', 'UNDO'}

    def execute(self, context):
        try:
            check_object(context.object)
        except Refused as error:
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}
        playback.clear(context.object)
        return {'FINISHED'}


class TREMOLO_OT_cancel(bpy.types.Operator):
    """Stop the present work; nothing is changed"""
    bl_idname = 'tremolo.cancel'
    bl_label = 'Cancel'

    @classmethod
    def poll(cls, context):
        return context.window_manager.tremolo.running

    def execute(self, context):
        context.window_manager.tremolo.cancel = True
        return {'FINISHED'}


kClasses = (TREMOLO_OT_hold, TREMOLO_OT_make, TREMOLO_OT_jiggle, TREMOLO_OT_bake, TREMOLO_OT_clear, TREMOLO_OT_cancel)


def register():
    for one in kClasses:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(kClasses):
        bpy.utils.unregister_class(one)


