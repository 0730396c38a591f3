"""Point caches: PC2 and MDD, as `tremolo export` writes them and Blender's Mesh Cache modifier reads them."""
import os
import struct

import numpy

from .programs import Refused


def read_pc2(path):
    """Positions of a .pc2 file: float32, (frames, vertices, 3)."""
    with open(path, 'rb') as file:
        head = file.read(32)
        if len(head) < 32 or head[:12] != b'POINTCACHE2\0':
            raise Refused(f'{path} is not a point cache')
        _, vertices, _, _, frames = struct.unpack('<iiffi', head[12:])
        data = numpy.fromfile(file, '<f4')
    if data.size != 3 * vertices * frames:
        raise Refused(f'{path} is cut off: it has {data.size} numbers instead of {3 * vertices * frames}')
    return data.reshape(frames, vertices, 3)


def _pc2_head(positions):
    return struct.pack('<12siiffi', b'POINTCACHE2\0', 1, positions.shape[1], 0.0, 1.0, positions.shape[0])


def _mdd_head(positions, rate):
    times = numpy.arange(positions.shape[0]) / rate
    return struct.pack('>ii', positions.shape[0], positions.shape[1]) + times.astype('>f4').tobytes()


def write_cache(path, positions, rate):
    """Writes positions (frames, vertices, 3) as .pc2 or .mdd, by the extension. rate: frames a second.

    The file is replaced at once, so a modifier that reads it never meets half of it."""
    mdd = path.lower().endswith('.mdd')
    head = _mdd_head(positions, rate) if mdd else _pc2_head(positions)
    partial = f'{path}.partial-{os.getpid()}'
    try:
        with open(partial, 'wb') as file:
            file.write(head)
            file.write(numpy.ascontiguousarray(positions, '>f4' if mdd else '<f4').tobytes())
        os.replace(partial, path)
    except OSError as error:
        if os.path.exists(partial):
            os.remove(partial)
        raise Refused(f'{path} cannot be written: {error.strerror}') from error


def write_ply(path, vertices, faces, held=None):
    """Writes a surface, .ply. vertices: (n, 3), m; faces: lists of vertices; held: (n,) bool, painted red."""
    head = ['ply', 'format binary_little_endian 1.0', f'element vertex {len(vertices)}']
    head += [f'property double {axis}' for axis in 'xyz']
    head += [f'property uchar {colour}' for colour in ('red', 'green', 'blue')]
    head += [f'element face {len(faces)}', 'property list int int vertex_indices', 'end_header', '']
    rows = numpy.zeros(len(vertices), [('position', '<f8', 3), ('colour', 'u1', 3)])
    rows['position'] = vertices
    if held is not None:
        rows['colour'][:, 0] = 255 * numpy.asarray(held)
    corners = []
    for face in faces:
        corners.append(len(face))
        corners.extend(face)
    data = '\n'.join(head).encode() + rows.tobytes() + numpy.asarray(corners, '<i4').tobytes()
    with open(path, 'wb') as file:
        file.write(data)
    return data
