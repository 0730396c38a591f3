"""The choices of the user: properties of objects and scenes, saved in the .blend, and preferences."""
import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty,
                       StringProperty)

from .rest_shape import kHold


class TremoloObject(bpy.types.PropertyGroup):
    """Of one object: the material, the held group, its model, and whether it is an obstacle."""
    kind: EnumProperty(name='Body', description='Kind of body', default='SOLID', items=[
        ('SOLID', 'Solid', 'A solid that the surface encloses: rubber, jelly, flesh'),
        ('CLOTH', 'Cloth', 'A sheet: every vertex moves independently, no model is made')])
    hold: StringProperty(name='Hold', default=kHold,
                         description='Vertex group that follows the animation; without it the body flies freely')
    young: FloatProperty(name='Stiffness', default=1e5, min=1.0, soft_max=1e9, precision=0, step=1000000,
                         description="Young's modulus, Pa: jelly 1e4, flesh 5e4, soft rubber 1e6, wood 1e10")
    poisson: FloatProperty(name='Poisson', default=0.45, min=0.0, max=0.4999, precision=3,
                           description="Poisson's ratio: 0.45 keeps the volume nearly, 0 squeezes like cork")
    density: FloatProperty(name='Density', default=1000.0, min=0.01, precision=1,
                           description='kg/m³; water has 1000')
    tets: IntProperty(name='Tetrahedra', default=0, min=0, soft_max=100000,
                      description='Number of tetrahedra inside the surface; 0: about 10 000')
    modes: IntProperty(name='Shapes', default=30, min=1, max=500,
                       description='Number of shapes in which the body can deform')
    thicken: FloatProperty(name='Thickness', default=0.0, min=0.0, precision=4, unit='LENGTH',
                           description='Of a surface that encloses nothing: makes a solid this thick; 0: closed')
    fill_holes: BoolProperty(name='Fill Holes', default=False, description='Close holes, however large they are')
    volume: StringProperty(name='Mesh File', subtype='FILE_PATH', default='',
                           description='Tetrahedra of your own (.msh, .vtk, ...) in the coordinates of the object')
    damping: FloatProperty(name='Damping', default=0.05, min=0.0, max=1.0, precision=3,
                           description='Fraction of critical damping of the slowest shape; 0: for ever')
    wobble: FloatProperty(name='Frequency', default=3.0, min=0.0, precision=2,
                          description='Vibrations per second of the slowest shape, whatever the stiffness; '
                          '0: that of the stiffness. The model need not be made again')
    gravity: BoolProperty(name='Gravity', default=True,
                          description="The scene's gravity; a held body begins at rest in it")
    # Of cloth.
    area_density: FloatProperty(name='Weight', default=0.2, min=1e-4, precision=3, description='kg/m²')
    stretch: FloatProperty(name='Stretch', default=1000.0, min=0.0, description='Stiffness along edges, N/m')
    shear: FloatProperty(name='Shear', default=300.0, min=0.0, description='Stiffness across faces, N/m')
    bend: FloatProperty(name='Bend', default=20.0, min=0.0, description='Stiffness against bending, N/m')
    thickness: FloatProperty(name='Distance', default=0.005, min=0.0, precision=4, unit='LENGTH',
                             description='Distance that the cloth keeps from obstacles')
    # Of an obstacle.
    collider: BoolProperty(name='Obstacle', default=False, description='Bodies collide with this object')
    shape: EnumProperty(name='Shape', default='AUTO', items=[
        ('AUTO', 'Automatic', 'A flat object is an endless plane, any other its mesh'),
        ('PLANE', 'Plane', 'All below its own z = 0'), ('BOX', 'Box', 'Its bounding box'),
        ('SPHERE', 'Sphere', 'A ball in its bounding box'), ('MESH', 'Mesh', 'Its closed surface')])
    friction: FloatProperty(name='Friction', default=0.3, min=0.0, soft_max=1.0)
    restitution: FloatProperty(name='Bounce', default=0.5, min=0.0, max=1.0)
    # Found by Make.
    model: StringProperty(name='Model', description='File that Make has written')
    made_of: StringProperty(description='Digest of all that the model was made of')
    made_stretch: FloatVectorProperty(size=9, description='Scale that the model was made at, m a unit')
    frequency: FloatProperty(description='Of the slowest shape, Hz')
    summary: StringProperty(description='Line about the model')


class TremoloScene(bpy.types.PropertyGroup):
    """Of a scene: how it is stepped and where files are written."""
    substeps: IntProperty(name='Sub-steps', default=8, min=1, max=1000, description='Steps in each frame')
    output: EnumProperty(name='Bake to', default='PC2', items=[
        ('PC2', 'PC2 cache', 'Point cache beside the .blend, played by a Mesh Cache modifier'),
        ('MDD', 'MDD cache', 'The same as MDD'),
        ('KEYS', 'Shape keys', 'A shape key for each frame, in the .blend itself')])
    folder: StringProperty(name='Folder', subtype='DIR_PATH', default='//tremolo',
                           description='Models and caches are written here')


class TremoloWindow(bpy.types.PropertyGroup):
    """The present work; not saved."""
    running: BoolProperty()
    cancel: BoolProperty()
    text: StringProperty()
    fraction: FloatProperty(name='Progress', subtype='PERCENTAGE', min=0, max=100, precision=0)


class TremoloPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    programs: StringProperty(name='Programs', subtype='DIR_PATH', default='',
                             description='Folder of tremolo and tremolo-precompute, e.g. /usr/local/bin')

    def draw(self, _context):
        from .programs import Refused, find_program
        self.layout.prop(self, 'programs')
        for name in ('tremolo', 'tremolo-precompute', 'tremolo-mesh'):
            try:
                self.layout.label(text=find_program(name, programs_folder()), icon='CHECKMARK')
            except Refused as error:
                self.layout.label(text=str(error), icon='ERROR')


def programs_folder():
    addon = bpy.context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.programs) if addon else ''


kClasses = (TremoloObject, TremoloScene, TremoloWindow, TremoloPreferences)


def register():
    for one in kClasses:
        bpy.utils.register_class(one)
    bpy.types.Object.tremolo = PointerProperty(type=TremoloObject)
    bpy.types.Scene.tremolo = PointerProperty(type=TremoloScene)
    bpy.types.WindowManager.tremolo = PointerProperty(type=TremoloWindow)


def unregister():
    del bpy.types.Object.tremolo, bpy.types.Scene.tremolo, bpy.types.WindowManager.tremolo
    for one in reversed(kClasses):
        bpy.utils.unregister_class(one)
