#!/usr/bin/python3
"""Reads what `tremolo export` writes and compares it with the surfaces of `tremolo run`.

    read_exports.py check FILE.glb                    its structure; prints what it holds
    read_exports.py compare FILE BODY RUN TOLERANCE   .glb, .pc2, .mdd, .pvd, .usda, or
                                                      the .csv of a series of .ply

RUN is a folder of `tremolo run --surfaces N` (.ply): each surface is looked for in FILE by its time,
and the largest distance of a vertex, over the surface's size, must be at most TOLERANCE. .pc2 knows
no times: frame k is at k/RATE, given as FILE@RATE. Knows the formats by their specifications and
needs nothing but Python.
"""
import base64
import json
import math
import os
import re
import struct
import sys
import xml.etree.ElementTree


def need(condition, what):
    if not condition:
        sys.exit(f'{sys.argv[2]}: {what}')


# ---- surfaces of `tremolo run` ----

def read_ply(path):
    data = open(path, 'rb').read()
    head, body = data.split(b'end_header\n', 1)
    lines = head.decode().split('\n')
    count = int([l for l in lines if l.startswith('element vertex')][0].split()[2])
    sizes = {'float': 4, 'uchar': 1}
    stride = 0
    for line in lines[lines.index(f'element vertex {count}') + 1:]:
        if not line.startswith('property') or 'list' in line:
            break
        stride += sizes[line.split()[1]]
    return [struct.unpack_from('<3f', body, stride * v) for v in range(count)]


def read_run(folder):
    for line in open(os.path.join(folder, 'frames.csv')).read().split('\n')[1:]:
        if line:
            _, time, name = line.split(',')
            yield float(time), read_ply(os.path.join(folder, name))


# ---- glTF ----

class Glb:
    def __init__(self, path):
        data = open(path, 'rb').read()
        magic, version, size = struct.unpack_from('<4sII', data)
        need(magic == b'glTF' and version == 2 and size == len(data), 'the header is wrong')
        length, kind = struct.unpack_from('<I4s', data, 12)
        need(kind == b'JSON' and length % 4 == 0, 'the first chunk is not JSON')
        self.json = json.loads(data[20:20 + length])
        bin_length, kind = struct.unpack_from('<I4s', data, 20 + length)
        need(kind == b'BIN\0' and 28 + length + bin_length == len(data), 'the second chunk is wrong')
        self.bin = data[28 + length:]
        need(self.json['buffers'] == [{'byteLength': bin_length}], 'the buffer is wrong')
        self.size = size

    def array(self, index):
        accessor = self.json['accessors'][index]
        view = self.json['bufferViews'][accessor['bufferView']]
        width = {'SCALAR': 1, 'VEC2': 2, 'VEC3': 3, 'VEC4': 4}[accessor['type']]
        code = {5121: 'B', 5123: 'H', 5125: 'I', 5126: 'f'}[accessor['componentType']]
        item = struct.Struct(f'<{width}{code}')
        stride = view.get('byteStride', item.size)
        start = view['byteOffset'] + accessor['byteOffset']
        end = start + stride * (accessor['count'] - 1) + item.size
        need(end <= view['byteOffset'] + view['byteLength'], f'accessor {index} leaves its view')
        values = [item.unpack_from(self.bin, start + stride * i) for i in range(accessor['count'])]
        for bound, choose in (('min', min), ('max', max)):
            if bound in accessor:
                for k in range(width):
                    told, found = accessor[bound][k], choose(v[k] for v in values)
                    need(abs(told - found) <= 1e-7 * abs(found), f'accessor {index}: its {bound}')
        return values

    def sampler(self, node, path):
        animation = self.json.get('animations', [None])[0]
        if animation is None:
            return None
        for channel in animation['channels']:
            if channel['target'] == {'node': node, 'path': path}:
                return animation['samplers'][channel['sampler']]
        return None

    def times(self):
        animation = self.json.get('animations', [None])[0]
        if animation is None:
            return [0.0]
        inputs = {s['input'] for s in animation['samplers']}
        need(len(inputs) == 1, 'the samplers have more than one clock')
        return [t for (t,) in self.array(inputs.pop())]

    def value(self, node, path, key, width, usual):
        sampler = self.sampler(node, path)
        if sampler is None:
            return self.json['nodes'][node].get(path, usual)
        output = self.array(sampler['output'])
        if path == 'weights':
            return [w for (w,) in output[width * key:width * (key + 1)]]
        return output[key]

    # The node's own matrix [R c] at a key.
    def local(self, node, key):
        c = self.value(node, 'translation', key, 3, (0, 0, 0))
        x, y, z, w = self.value(node, 'rotation', key, 4, (0, 0, 0, 1))
        return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), c[0]],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), c[1]],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), c[2]]]

    def world(self, node, key):
        matrix = self.local(node, key)
        for parent, other in enumerate(self.json['nodes']):
            if node in other.get('children', []):
                return product(self.world(parent, key), matrix)
        return matrix

    # World positions of a body, with the root's turn undone: z is up again.
    def positions(self, name, key):
        nodes = self.json['nodes']
        node = [i for i, n in enumerate(nodes) if n.get('name') == name and 'mesh' in n][0]
        mesh = self.json['meshes'][nodes[node]['mesh']]
        primitive = mesh['primitives'][0]
        for other in mesh['primitives']:
            need(other['attributes'] == primitive['attributes'], 'primitives differ in vertices')
        places = [list(x) for x in self.array(primitive['attributes']['POSITION'])]
        targets = primitive.get('targets', [])
        weights = self.value(node, 'weights', key, len(targets), mesh.get('weights', []))
        need(len(weights) == len(targets), 'another number of weights than targets')
        for weight, target in zip(weights, targets):
            for x, d in zip(places, self.array(target['POSITION'])):
                for k in range(3):
                    x[k] += weight * d[k]
        if 'skin' not in nodes[node]:
            return [upright(transformed(self.world(node, key), x)) for x in places]
        joints = self.json['skins'][nodes[node]['skin']]['joints']
        matrices = [self.world(j, key) for j in joints]
        moved = [[0.0, 0.0, 0.0] for _ in places]
        for part in (0, 1, 2):
            if f'JOINTS_{part}' not in primitive['attributes']:
                continue
            ids = self.array(primitive['attributes'][f'JOINTS_{part}'])
            shares = self.array(primitive['attributes'][f'WEIGHTS_{part}'])
            for v, x in enumerate(places):
                for j, share in zip(ids[v], shares[v]):
                    if share > 0:
                        y = transformed(matrices[j], x)
                        for k in range(3):
                            moved[v][k] += share * y[k]
        return [upright(x) for x in moved]

    def check(self):
        nodes = self.json['nodes']
        summary = {'bytes': self.size, 'keys': len(self.times()), 'bodies': [], 'images': 0}
        times = self.times()
        need(all(a < b for a, b in zip(times, times[1:])), 'times do not ascend')
        for i in range(len(self.json['accessors'])):
            for value in self.array(i):
                need(all(math.isfinite(x) for x in value), f'accessor {i} is not finite')
        for i, node in enumerate(nodes):
            turn = self.sampler(i, 'rotation')
            if turn is not None:
                keys = self.array(turn['output'])
                need(all(abs(sum(x * x for x in q) - 1) < 1e-5 for q in keys), 'a quaternion')
                need(all(sum(x * y for x, y in zip(a, b)) > 0 for a, b in zip(keys, keys[1:])),
                     'a quaternion changes its sign')
            if 'mesh' not in node:
                continue
            primitives = self.json['meshes'][node['mesh']]['primitives']
            targets = len(primitives[0].get('targets', []))
            vertices = self.json['accessors'][primitives[0]['attributes']['POSITION']]['count']
            corners = [c for p in primitives for (c,) in self.array(p['indices'])]
            need(max(corners) < vertices, 'a corner is no vertex')
            weights = self.sampler(i, 'weights')
            spans = None
            if weights is not None:
                values = [w for (w,) in self.array(weights['output'])]
                need(len(values) == targets * len(times), 'the weights are not all there')
                spans = [min(values), max(values)]
            summary['bodies'].append({'name': node['name'], 'vertices': vertices,
                                      'targets': targets, 'triangles': len(corners) // 3,
                                      'weights': spans, 'primitives': len(primitives),
                                      'attributes': sorted(primitives[0]['attributes'])})
            if 'NORMAL' in primitives[0]['attributes']:
                for n in self.array(primitives[0]['attributes']['NORMAL']):
                    need(abs(sum(x * x for x in n) - 1) < 1e-5, 'a normal is not of length one')
        summary['images'] = len(self.json.get('images', []))
        return summary


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) + (a[i][3] if j == 3 else 0)
             for j in range(4)] for i in range(3)]


def transformed(m, x):
    return [m[i][0] * x[0] + m[i][1] * x[1] + m[i][2] * x[2] + m[i][3] for i in range(3)]


def upright(x):
    return [x[0], -x[2], x[1]]


# ---- the others: [(time, [(x, y, z), ...]), ...] ----

def read_cache(data, order, start, vertices, times):
    item = struct.Struct(order + '3f')
    need(len(data) == start + 12 * vertices * len(times), 'its size does not fit its head')
    return [(t, [item.unpack_from(data, start + 12 * (vertices * f + v)) for v in range(vertices)])
            for f, t in enumerate(times)]


def read_pc2(path, _):
    path, rate = path.split('@')
    data = open(path, 'rb').read()
    magic, version, vertices, first, sampling, frames = struct.unpack_from('<12siiffi', data)
    need(magic == b'POINTCACHE2\0' and version == 1 and first == 0 and sampling == 1, 'its head')
    return read_cache(data, '<', 32, vertices, [f / float(rate) for f in range(frames)])


def read_mdd(path, _):
    data = open(path, 'rb').read()
    frames, vertices = struct.unpack_from('>ii', data)
    times = struct.unpack_from(f'>{frames}f', data, 8)
    return read_cache(data, '>', 8 + 4 * frames, vertices, times)


def read_series(path, body):
    rows = [line.split(',') for line in open(path).read().split('\n')[1:] if line]
    return [(float(t), read_ply(os.path.join(os.path.dirname(path), name)))
            for _, t, of, name in rows if of == body]


def read_vtu(path):
    piece = xml.etree.ElementTree.parse(path).getroot().find('.//Piece')

    def floats(element):
        raw = base64.b64decode(element.text)
        need(struct.unpack_from('<Q', raw)[0] == len(raw) - 8, 'an array has another size than told')
        return list(struct.iter_unpack('<3f', raw[8:]))

    points = floats(piece.find('Points/DataArray'))
    moved = floats(piece.find('PointData/DataArray[@Name="displacement"]'))
    need(len(points) == len(moved) == int(piece.get('NumberOfPoints')), 'points are missing')
    return points


def read_pvd(path, body):
    frames = []
    for data in xml.etree.ElementTree.parse(path).getroot().iter('DataSet'):
        if data.get('group') == body:
            frames.append((float(data.get('timestep')),
                           read_vtu(os.path.join(os.path.dirname(path), data.get('file')))))
    return frames


def samples(block, name):
    found = re.search(re.escape(name) + r'\.timeSamples = \{(.*?)\n        \}', block, re.S)
    if found:
        return [(float(code), value) for code, value in
                re.findall(r'\n\s+([-+.\de]+): (.*),', found.group(1))]
    found = re.search(re.escape(name) + r' = (.*)', block)
    return [(None, found.group(1))] if found else None


def read_usda(path, body):
    text = open(path).read()
    need(text.startswith('#usda 1.0\n') and 'metersPerUnit = 1\n' in text and 'upAxis = "Z"' in text,
         'the head of the stage')
    rate = float(re.search(r'timeCodesPerSecond = (\S+)', text).group(1))
    block = re.search(r'def Mesh "' + body.replace('-', '_') + r'"\n(.*?)\n    \}\n', text, re.S).group(1)

    def numbers(value):
        return [float(x) for x in re.findall(r'[-+.\de]+', value)]

    def at(entries, code):
        if entries is None:
            return None
        return numbers(entries[0][1] if entries[0][0] is None else dict(entries)[code])

    points = samples(block, 'point3f[] points')
    places = samples(block, 'double3 xformOp:translate')
    turns = samples(block, 'quatd xformOp:orient')
    frames = []
    for code, value in points:
        flat = numbers(value)
        xs = list(zip(flat[0::3], flat[1::3], flat[2::3]))
        if places is not None:
            c, (w, x, y, z) = at(places, code), at(turns, code)
            m = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), c[0]],
                 [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), c[1]],
                 [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), c[2]]]
            xs = [transformed(m, p) for p in xs]
        frames.append((code / rate, xs))
    return frames


def read_glb(path, body):
    glb = Glb(path)
    first = glb.json['asset']['extras']['first_frame_s']
    # Positions of a key are made when somebody asks for them.
    return [(first + t, lambda key=key: glb.positions(body, key))
            for key, t in enumerate(glb.times())]


def compare(path, body, run, tolerance):
    readers = {'.glb': read_glb, '.pc2': read_pc2, '.mdd': read_mdd, '.pvd': read_pvd,
               '.usda': read_usda, '.csv': read_series}
    frames = readers[os.path.splitext(path.split('@')[0])[1]](path, body)
    worst, seen, moved = 0.0, 0, 0.0
    start = None
    for time, wanted in read_run(run):
        near = [places for t, places in frames if abs(t - time) < 1e-4]
        need(len(near) == 1, f'{len(near)} frames at t = {time}')
        places = near[0]() if callable(near[0]) else near[0]
        # A cache has the author's vertices alone; in a run's .ply copies of them come behind.
        if path.split('@')[0].endswith(('.pc2', '.mdd')):
            copies = wanted[len(places):]
            need(set(copies) <= set(wanted[:len(places)]), 'vertices that are no copies are missing')
            wanted = wanted[:len(places)]
        # In glTF copies for the other sides of sharp edges come behind.
        if path.endswith('.glb'):
            copies = places[len(wanted):]
            need(set(map(tuple, copies)) <= set(map(tuple, places[:len(wanted)])), 'a vertex behind is no copy')
            places = places[:len(wanted)]
        need(len(places) == len(wanted), f'{len(places)} vertices, not {len(wanted)}')
        size = max(max(x[k] for x in wanted) - min(x[k] for x in wanted) for k in range(3))
        worst = max(worst, max(math.dist(a, b) for a, b in zip(places, wanted)) / size)
        start = start or wanted
        moved = max(moved, max(math.dist(a, b) for a, b in zip(start, wanted)) / size)
        seen += 1
    need(seen > 1, 'the run has fewer than two surfaces')
    need(moved > 1e-3, 'nothing moves, so that nothing is seen')
    print(json.dumps({'file': path, 'body': body, 'surfaces': seen, 'error': worst, 'moved': moved}))
    need(worst <= tolerance, f'{worst} of the size off, more than {tolerance}')


if __name__ == '__main__':
    if len(sys.argv) == 3 and sys.argv[1] == 'check':
        print(json.dumps(Glb(sys.argv[2]).check()))
    elif len(sys.argv) == 6 and sys.argv[1] == 'compare':
        compare(sys.argv[2], sys.argv[3], sys.argv[4], float(sys.argv[5]))
    else:
        sys.exit(__doc__)
