// three.js reads a .glb: where it puts the vertices of a body at the times of a run's surfaces.
//
//     node three_positions.mjs NODE_MODULES FILE.glb BODY RUN TOLERANCE
//
// RUN: a folder of `tremolo run --surfaces N`. Exit code 1 if a vertex is farther off than
// TOLERANCE of the size that run_surfaces.mjs returns.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { readRun } from './run_surfaces.mjs';

const [modules, file, name, run, tolerance] = process.argv.slice(2);
globalThis.self = globalThis;  // what the loader asks a browser for
const from = (what) => import(pathToFileURL(path.join(modules, what)).href);
const THREE = await from('three/build/three.module.js');
const { GLTFLoader } = await from('three/examples/jsm/loaders/GLTFLoader.js');

const bytes = fs.readFileSync(file);
const data = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
const gltf = await new GLTFLoader().parseAsync(data, '');
const first = gltf.asset.extras.first_frame_s;
const mixer = new THREE.AnimationMixer(gltf.scene);
const action = mixer.clipAction(gltf.animations[0]);
action.setLoop(THREE.LoopOnce);  // else the last time is the first one
action.clampWhenFinished = true;
// A body of several materials is a group of meshes with common vertices.
const body = gltf.scene.getObjectByName(name);
const mesh = body.isMesh ? body : body.children.find((child) => child.isMesh);

let worst = 0, seen = 0;
const x = new THREE.Vector3();
for (const { time, places, size } of readRun(run)) {
  action.reset().play();
  mixer.setTime(Math.min(time - first, gltf.animations[0].duration));
  gltf.scene.updateMatrixWorld(true);
  // Behind the vertices of the run are those of sharp edges.
  if (mesh.geometry.attributes.position.count < places.length) throw new Error('other vertices');
  places.forEach((w, v) => {
    // The root has rotated z up into y up.
    mesh.getVertexPosition(v, x).applyMatrix4(mesh.matrixWorld);
    worst = Math.max(worst, Math.hypot(x.x - w[0], -x.z - w[1], x.y - w[2]) / size);
  });
  seen += 1;
}
console.log(`${path.basename(file)}: three.js has '${name}' at ${seen} moments to ` +
            `${worst.toExponential(1)} of its size`);
if (seen < 2 || !(worst <= Number(tolerance))) process.exit(1);
