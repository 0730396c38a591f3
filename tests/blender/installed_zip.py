"""The zip of the build, installed as a user does, in a Blender with empty preferences.

    blender -b --python tests/blender/installed_zip.py -- build/tremolo_blender.zip"""
import os
import sys
import tempfile
import zipfile

import bpy

# The version of the tree must not answer in place of the zip's.
archive = os.path.abspath(sys.argv[sys.argv.index('--') + 1])
names = sorted(zipfile.ZipFile(archive).namelist())
print(names)
try:
    assert 'tremolo_blender/__init__.py' in names
    assert all(name.startswith('tremolo_blender/') and name.endswith('.py') for name in names), names
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with tempfile.TemporaryDirectory() as folder:
        # Blender installs into this folder of scripts, not into the user's.
        bpy.context.preferences.filepaths.script_directory = folder
        os.makedirs(os.path.join(folder, 'addons'))
        bpy.utils.refresh_script_paths()
        bpy.ops.preferences.addon_install(filepath=archive, target='PREFS', overwrite=True)
        bpy.ops.preferences.addon_enable(module='tremolo_blender')
        import tremolo_blender
        assert tremolo_blender.__file__.startswith(folder), tremolo_blender.__file__
        addon = bpy.context.preferences.addons['tremolo_blender']
        addon.preferences.programs = '/nowhere/at/all'
        assert tremolo_blender.settings.programs_folder() == '/nowhere/at/all'
        for name in ('hold', 'make', 'jiggle', 'bake', 'clear', 'cancel'):
            assert hasattr(bpy.types, f'TREMOLO_OT_{name}'), name
        bpy.ops.preferences.addon_disable(module='tremolo_blender')
        assert not hasattr(bpy.types.Object, 'tremolo')
        bpy.ops.preferences.addon_enable(module='tremolo_blender')
        assert hasattr(bpy.types.Object, 'tremolo')
        bpy.ops.preferences.addon_disable(module='tremolo_blender')
    print('installed, enabled, disabled and enabled again')
except BaseException:  # Blender would end with 0
    import traceback
    traceback.print_exc()
    sys.exit(1)
