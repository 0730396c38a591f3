"""Tremolo in Blender: solids that vibrate and cloth, moved by the programs of Tremolo.

The add-on needs no compiled module. Motions are point caches and shape keys, which Blender plays by itself."""
bl_info = {
    'name': 'Tremolo',
    'description': 'Solids that vibrate and cloth, driven by the animation of their objects',
    'author': 'The authors of Tremolo',
    'version': (0, 1, 0),
    'blender': (3, 4, 0),
    'location': '3D View > Sidebar > Tremolo',
    'category': 'Physics',
}

from . import operators, panel, settings  # noqa: E402

kParts = (settings, operators, panel)


def register():
    for part in kParts:
        part.register()


def unregister():
    for part in reversed(kParts):
        part.unregister()
