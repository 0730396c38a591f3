"""Files between Blender and the programs without the add-on: glTF with morph targets and with a rig, as Blender
writes it, and point caches of `tremolo export` in Blender's Mesh Cache modifier.

    blender -b --python tests/blender/exchange.py [-- NAME...]

TREMOLO_PROGRAMS: the folder of the programs; build/bin by default."""
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bpy  # noqa: E402
import numpy  # noqa: E402
import support  # noqa: E402
from case import limb  # noqa: E402
from read_exports import read_run  # noqa: E402
from support import program  # noqa: E402

kFloats = 1e-6  # of the size


def obj_vertices(path):
    with open(path, encoding='utf-8') as file:
        return numpy.array([line.split()[1:4] for line in file if line.startswith('v ')], float)


def same_points(found, wanted):
    """The largest distance from a point of one set to the nearest of the other, over the size."""
    distance = numpy.linalg.norm(found[:, None] - wanted[None], axis=2)
    return max(distance.min(axis=0).max(), distance.min(axis=1).max()) / support.size(wanted)


class Exchange(unittest.TestCase):
    def setUp(self):
        self.work = support.work_folder()
        self.folder = self.work.name
        self.scene = support.fresh(self.folder)

    def tearDown(self):
        self.work.cleanup()

    def path(self, name):
        return os.path.join(self.folder, name)

    def morphing_ball(self):
        thing = support.ball()
        thing.location = (0.5, 0.2, 1)
        thing.shape_key_add(name='Basis')
        wide = thing.shape_key_add(name='wide')
        for k, vertex in enumerate(thing.data.vertices):
            wide.data[k].co = (1.4 * vertex.co.x, vertex.co.y, vertex.co.z)
        for frame, value in ((1, 0), (20, 1)):
            wide.value = value
            wide.keyframe_insert('value', frame=frame)
        self.scene.frame_set(20)
        bpy.ops.export_scene.gltf(filepath=self.path('morphs.glb'), export_morph=True)
        self.scene.frame_set(1)
        return support.positions(thing, 1)

    def test_a_glb_with_morph_targets_is_meshed_in_its_rest_shape_and_that_is_said(self):
        wanted = self.morphing_ball()
        log = program('tremolo-precompute', 'morphs.glb', '-o', 'm.tremolo', '--up', 'y', '--fix', 'z<10%',
                      '--tets', '500', '--modes', '8', folder=self.folder)
        self.assertIn('shapes that morph: taken in their rest shape', log)
        program('tremolo', 'export', 'm.tremolo', '--load', 'none', '--duration', '0.1', '--step', '0.01', '--pc2',
                'm.pc2', folder=self.folder)
        self.assertLess(same_points(obj_vertices(self.path('m.obj')), wanted), kFloats)

    def test_a_glb_with_morph_targets_is_drawn_on_a_mesh_of_tetrahedra(self):
        wanted = self.morphing_ball()
        program('tremolo-mesh', 'morphs.glb', '-o', 'm.msh', '--tets', '500', folder=self.folder)
        log = program('tremolo-precompute', 'm.msh', '--render', 'morphs.glb', '-o', 'm.tremolo', '--up', 'y', '--fix',
                      'z<10%', '--modes', '8', folder=self.folder)
        self.assertIn('render surface', log)
        program('tremolo', 'run', 'm.tremolo', '--load', 'none', '--duration', '0.1', '--step', '0.01',
                '--surfaces', '1', '--out', 'run', folder=self.folder)
        points = numpy.array(list(read_run(self.path('run')))[-1][1])
        self.assertLess(same_points(points, wanted), kFloats)

    def test_a_rig_that_blender_exports_moves_a_stiff_body_as_blender_does(self):
        thing, rig = limb(self.scene, 1e12)
        bpy.ops.export_scene.gltf(filepath=self.path('rig.glb'), export_frame_range=True)
        # Blender's bones at rest are those of edit mode, and glTF places a skin by its bones.
        fixed = [f'near:{x},{y},{z},10' for x, y, z in self.core(thing, rig)]
        program('tremolo-precompute', 'rig.glb', '-o', 'rig.tremolo', '--up', 'y', '--young', '1e12', '--tets', '800',
                '--modes', '8', '--keep-elements', *sum((['--fix', f] for f in fixed), []), folder=self.folder)
        # Blender 3.4 writes the first key at the time of the first frame, 1/24 s.
        with open(self.path('rig.toml'), 'w', encoding='utf-8') as file:
            file.write(f'step = {1 / 240}\nduration = {40 / 24}\n[[bodies]]\nname = "body"\nmodel = "rig.tremolo"\n'
                       'kind = "driven"\nrig = true\ncontact = false\n')
        program('tremolo', 'run', 'rig.toml', '--surfaces', '4', '--out', 'run', folder=self.folder)
        worst, seen = 0.0, 0
        for time, points in read_run(self.path('run/body')):
            wanted = support.positions(thing, round(time * 24))
            worst = max(worst, same_points(numpy.array(points), wanted))
            seen += 1
        print(f'{self.id()}: {worst:.1e} of the size at {seen} frames')
        self.assertGreater(seen, 3)
        # glTF has a key a frame; the engine's splines through them and Blender's curves are the same at frames. A
        # stiff body is bent by the accelerations of its bones by less than this.
        self.assertLess(worst, 2e-5)

    def core(self, thing, rig):
        """Points on the bones as the file has them at rest."""
        self.scene.frame_set(1)
        matrix = numpy.array(rig.matrix_world, float)
        ends = [(b.head_local, b.tail_local) for b in rig.data.bones]
        points = [numpy.array(h) + s * (numpy.array(t) - numpy.array(h)) for h, t in ends for s in (0.2, 0.5, 0.8)]
        return [(matrix[:3, :3] @ p + matrix[:3, 3]).tolist() for p in points]

    def test_point_caches_of_an_export_fit_the_authors_mesh_in_order_and_axes(self):
        thing = support.ball(subdivisions=4)
        bpy.ops.object.select_all(action='DESELECT')
        thing.select_set(True)
        bpy.ops.wm.obj_export(filepath=self.path('ball.obj'), forward_axis='Y', up_axis='Z')
        program('tremolo-precompute', 'ball.obj', '-o', 'ball.tremolo', '--fix', 'z<10%', '--tets', '500',
                '--modes', '8', '--young', '3e4', '--load-at', 'near:0,0,1', '--load-force', '600,300,0', folder=self.folder)
        run = ['--step', '0.0041666666666666666', '--duration', '1']
        program('tremolo', 'export', 'ball.tremolo', *run, '--rate', '24', '--pc2', 'a.pc2', '--mdd', 'b.mdd',
                folder=self.folder)
        program('tremolo', 'run', 'ball.tremolo', *run, '--surfaces', '4', '--out', 'run', folder=self.folder)
        for name in ('a.pc2', 'b.mdd'):
            cache = thing.modifiers.new('Cache', 'MESH_CACHE')
            cache.cache_format = name[2:].upper()
            cache.filepath = self.path(name)
            cache.frame_start = 0
            cache.forward_axis, cache.up_axis = 'POS_Y', 'POS_Z'
            worst, moved = 0.0, 0.0
            rest = support.coordinates_at_rest(thing)
            for time, points in read_run(self.path('run')):
                # The file's vertices come first, copies for their normals after them.
                wanted = numpy.array(points)[:len(rest)]
                found = support.positions(thing, round(24 * time))
                worst = max(worst, numpy.abs(found - wanted).max() / support.size(rest))
                moved = max(moved, numpy.abs(wanted - rest).max() / support.size(rest))
            print(f'{self.id()}: {name} {worst:.1e} of the size, moved by {moved:.2g}')
            self.assertLess(worst, kFloats)
            self.assertGreater(moved, 0.01)
            thing.modifiers.remove(cache)


if __name__ == '__main__':
    support.run_tests()
