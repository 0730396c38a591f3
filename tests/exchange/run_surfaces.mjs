// The surfaces of `tremolo run --surfaces N`: [{ time, places: [[x, y, z], ...], size }, ...]. size: the
// longest side of the box of the vertices and of the origin, as floats know seven digits of a place.
import fs from 'node:fs';
import path from 'node:path';

function readPly(name) {
  const bytes = fs.readFileSync(name);
  const end = bytes.indexOf('end_header\n') + 11;
  const lines = bytes.subarray(0, end).toString().split('\n');
  const element = lines.findIndex((line) => line.startsWith('element vertex'));
  let stride = 0;
  for (const line of lines.slice(element + 1)) {
    if (!line.startsWith('property') || line.includes('list')) break;
    stride += line.includes('uchar') ? 1 : 4;
  }
  const at = (v, k) => bytes.readFloatLE(end + stride * v + 4 * k);
  const count = Number(lines[element].split(' ')[2]);
  return Array.from({ length: count }, (_, v) => [at(v, 0), at(v, 1), at(v, 2)]);
}

export function readRun(folder) {
  const rows = fs.readFileSync(path.join(folder, 'frames.csv'), 'utf8').trim().split('\n').slice(1);
  return rows.map((row) => {
    const [, time, name] = row.split(',');
    const places = readPly(path.join(folder, name));
    const extent = (k) => {
      let low = 0, high = 0;
      for (const x of places) { low = Math.min(low, x[k]); high = Math.max(high, x[k]); }
      return high - low;
    };
    return { time: Number(time), places, size: Math.max(extent(0), extent(1), extent(2)) };
  });
}
