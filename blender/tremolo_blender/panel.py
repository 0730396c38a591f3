"""The panel: Tremolo in the sidebar of the 3D view."""
import bpy


class Panel:
    bl_space_type = 'VIEW_3D'
    bl_region_type = 'UI'
    bl_category = 'Tremolo'


class TREMOLO_PT_body(Panel, bpy.types.Panel):
    bl_idname = 'TREMOLO_PT_body'
    bl_label = 'Tremolo'

    def draw(self, context):
        layout, thing, state = self.layout, context.object, context.window_manager.tremolo
        if thing is None or thing.type != 'MESH':
            layout.label(text='Click a mesh object', icon='INFO')
            return
        own = thing.tremolo
        layout.prop(own, 'kind', expand=True)
        column = layout.column(align=True)
        column.scale_y = 1.4
        column.operator('tremolo.hold', icon='PINNED', text='1  Hold selected vertices')
        if own.kind == 'SOLID':
            column.operator('tremolo.make', icon='MESH_ICOSPHERE', text='2  Make')
        column.operator('tremolo.jiggle', icon='PLAY', text='3  Jiggle' if own.kind == 'SOLID' else '2  Jiggle')
        if state.running:
            box = layout.box()
            box.label(text=state.text)
            row = box.row(align=True)
            row.prop(state, 'fraction', slider=True)
            row.operator('tremolo.cancel', icon='X', text='')
        elif own.kind == 'SOLID':
            layout.label(text=own.summary or 'No model yet', icon='CHECKMARK' if own.summary else 'DOT')


class TREMOLO_PT_material(Panel, bpy.types.Panel):
    bl_label = 'Material'
    bl_parent_id = 'TREMOLO_PT_body'

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == 'MESH'

    def draw(self, context):
        layout, own = self.layout, context.object.tremolo
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop_search(own, 'hold', context.object, 'vertex_groups')
        if own.kind == 'CLOTH':
            for name in ('area_density', 'stretch', 'shear', 'bend', 'thickness', 'gravity'):
                layout.prop(own, name)
            return
        for name in ('wobble', 'damping', 'gravity'):
            layout.prop(own, name)


class TREMOLO_PT_model(Panel, bpy.types.Panel):
    bl_label = 'Model (Make again)'
    bl_parent_id = 'TREMOLO_PT_body'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        thing = context.object
        return thing is not None and thing.type == 'MESH' and thing.tremolo.kind == 'SOLID'

    def draw(self, context):
        layout, own = self.layout, context.object.tremolo
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ('young', 'density', 'poisson', 'modes', 'tets', 'thicken', 'fill_holes', 'volume'):
            layout.prop(own, name)


class TREMOLO_PT_obstacle(Panel, bpy.types.Panel):
    bl_label = 'Obstacle'
    bl_parent_id = 'TREMOLO_PT_body'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == 'MESH'

    def draw_header(self, context):
        self.layout.prop(context.object.tremolo, 'collider', text='')

    def draw(self, context):
        layout, own = self.layout, context.object.tremolo
        layout.use_property_split = True
        layout.active = own.collider
        for name in ('shape', 'friction', 'restitution'):
            layout.prop(own, name)


class TREMOLO_PT_bake(Panel, bpy.types.Panel):
    bl_label = 'Bake'
    bl_parent_id = 'TREMOLO_PT_body'

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == 'MESH'

    def draw(self, context):
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        layout.use_property_decorate = False
        row = layout.row(align=True)
        row.prop(scene, 'frame_start', text='Frames')
        row.prop(scene, 'frame_end', text='')
        for name in ('substeps', 'output', 'folder'):
            layout.prop(scene.tremolo, name)
        row = layout.row(align=True)
        row.operator('tremolo.bake', icon='FILE_TICK')
        row.operator('tremolo.clear', icon='TRASH')


kClasses = (TREMOLO_PT_body, TREMOLO_PT_material, TREMOLO_PT_model, TREMOLO_PT_obstacle, TREMOLO_PT_bake)


def register():
    for one in kClasses:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(kClasses):
        bpy.utils.unregister_class(one)
