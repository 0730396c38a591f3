// three.js's parser of USD's text reads a .usda: the positions of a body's vertices at the times of
// a run's surfaces.
//
//     node usda_positions.mjs NODE_MODULES FILE.usda PRIM RUN TOLERANCE
//
// Arguments and exit code as of three_positions.mjs; PRIM: the mesh's name in the stage.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { readRun } from './run_surfaces.mjs';

const [modules, file, prim, run, tolerance] = process.argv.slice(2);
const from = (what) => import(pathToFileURL(path.join(modules, what)).href);
const { USDAParser } = await from('three/examples/jsm/loaders/usd/USDAParser.js');
const THREE = await from('three/build/three.module.js');

const specs = new USDAParser().parseData(fs.readFileSync(file, 'utf8')).specsByPath;
const stage = specs['/'].fields;
if (Number(stage.metersPerUnit) !== 1 || stage.upAxis !== 'Z') throw new Error('another unit or axis');
const rate = Number(stage.timeCodesPerSecond);

// The value of an attribute at a time code that it has.
function at(name, code) {
  const fields = specs[`/tremolo/${prim}.${name}`]?.fields;
  if (fields === undefined) return undefined;
  if (fields.timeSamples === undefined) return fields.default;
  const k = fields.timeSamples.times.findIndex((t) => Math.abs(t - code) < 1e-6);
  if (k < 0) throw new Error(`${name} has no sample at ${code}`);
  return fields.timeSamples.values[k];
}

let worst = 0, seen = 0;
const x = new THREE.Vector3();
for (const { time, places, size } of readRun(run)) {
  const points = at('points', time * rate).flat();
  if (points.length !== 3 * places.length) throw new Error('other vertices');
  const move = at('xformOp:translate', time * rate) ?? [0, 0, 0];
  // The file has w first, the parser hands out x, y, z, w.
  const turn = new THREE.Quaternion(...(at('xformOp:orient', time * rate) ?? [0, 0, 0, 1]));
  places.forEach((wanted, k) => {
    x.set(...points.slice(3 * k, 3 * k + 3)).applyQuaternion(turn).add(new THREE.Vector3(...move));
    worst = Math.max(worst, x.distanceTo(new THREE.Vector3(...wanted)) / size);
  });
  seen += 1;
}
console.log(`${path.basename(file)}: three.js's USD parser has '${prim}' at ${seen} moments to ` +
            `${worst.toExponential(1)} of its size`);
if (seen < 2 || !(worst <= Number(tolerance))) process.exit(1);
