// Scenes of all kinds in node: closed forms, the native program's energies, saved states, errors, memory.
// usage: node scene_test.mjs PACKAGE TREMOLO MODELS FOLDER
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';

const [packagePath, program, models, folder] = process.argv.slice(2);
const { loadScene, TremoloError } = await import(pathToFileURL(join(packagePath, 'scene.mjs')));
const kG = 9.81, kStep = 0.004, kSteps = 60;

const scene = `
step = ${kStep}
duration = ${kStep * kSteps}
gravity = [0, 0, -${kG}]
[[bodies]]
name = "ball"
kind = "rigid"
shape = "sphere"
radius = 0.05
mass = 0.5
position = [0, 0, 0.5]
[[bodies]]
name = "sheet"
kind = "cloth"
columns = 12
rows = 12
width = 0.5
height = 0.5
corner = [-0.25, -0.25, 0.3]
thickness = 0.004
density = 1
pins = "corners"
[[bodies]]
name = "duck"
kind = "tets"
model = "duck.tets"
degree = "linear"
position = [2, 0, 0.1]
[[bodies]]
name = "heart"
kind = "free"
model = "heart-free.tremolo"
modes = 6
position = [5, 0, 1]
[[colliders]]
name = "floor"
shape = "plane"
`;
const files = Object.fromEntries(['duck.tets', 'heart-free.tremolo'].map((name) => [name, readFileSync(join(models, name))]));

const world = await loadScene(scene, files);
assert.deepEqual(world.names.map((name) => [name, world.kind(name)]).sort(),
  [['ball', 'rigid'], ['duck', 'tets'], ['heart', 'reduced'], ['sheet', 'cloth']]);
const height = (name) => {
  const all = world.positions(name);
  return all.reduce((sum, x, k) => sum + (k % 3 === 2 ? x : 0), 0) / (all.length / 3);
};
const before = ['ball', 'heart'].map(height);
world.step(30);
assert.ok(Math.abs(world.time - 30 * kStep) < 1e-12);
['ball', 'heart'].forEach((name, k) => {
  const fallen = before[k] - height(name);
  assert.ok(Math.abs(fallen - 0.5 * kG * world.time ** 2) < 1e-4, `${name} has fallen by ${fallen} m`);
});
assert.ok(Math.abs(world.momentum('ball').linear[2] + 0.5 * kG * world.time) < 1e-9);

// The native program has the same energies and contacts.
const saved = world.save();
const begun = [];
for (let k = 30; k < kSteps; ++k) {
  world.step();
  begun.push(...world.events().filter((event) => event.begins));
}
assert.ok(begun.some((event) => [event.body, event.other].sort().join() === 'ball,sheet'), JSON.stringify(begun));
assert.ok(begun.some((event) => event.body === 'duck' && event.collider === 0));
for (const [name, bytes] of Object.entries(files)) writeFileSync(join(folder, name), bytes);
writeFileSync(join(folder, 'scene.toml'), scene);
const native = JSON.parse(execFileSync(program, ['run', join(folder, 'scene.toml'), '--json'],
  { env: { ...process.env, TREMOLO_VECTORS: 'plain' }, stdio: ['ignore', 'pipe', 'ignore'] }));
for (const body of native.bodies) {
  const account = world.account(body.body);
  const total = account.kinetic + account.potential + account.contact;
  const off = Math.abs(total - body.energy_final) / Math.abs(body.energy_final);
  console.log(`${body.body}: energy ${total} J, ${off.toExponential(1)} off the native one`);
  assert.ok(off < 1e-6, `${body.body}: ${total} J, native ${body.energy_final} J`);
}

// A restored world continues with the same bits.
const after = world.names.map((name) => world.positions(name));
world.restore(saved);
assert.ok(Math.abs(world.time - 30 * kStep) < 1e-12);
world.step(kSteps - 30);
world.names.forEach((name, k) => assert.deepEqual(world.positions(name), after[k]));
assert.throws(() => world.restore(saved.slice(0, 100)), TremoloError);

// A hand holds the duck; without it the duck is gone.
const hit = world.pick([2, 0, 3], [0, 0, -1]);
assert.equal(hit.body, 'duck');
assert.ok(Math.abs(hit.weights.reduce((sum, x) => sum + x) - 1) < 1e-9);
const hand = world.grab(hit, 200, 2);
for (let k = 0; k < 100; ++k) {
  world.moveHand(hand, [hit.point[0], hit.point[1], hit.point[2] + 0.005 * k]);
  world.step();
}
assert.ok(height('duck') > 0.2, `the duck is at ${height('duck')} m`);
world.letGo(hand);
assert.throws(() => world.letGo(hand), (error) => error instanceof TremoloError && error.kind === 'usage');
world.moveCollider('floor', [0, 0, -0.01]);
world.remove('duck');
assert.deepEqual(world.names.sort(), ['ball', 'heart', 'sheet']);
assert.throws(() => world.positions('duck'), /no body 'duck'/);
world.step(5);
assert.equal(world.corners('sheet').length, 3 * 2 * 11 * 11);
assert.equal(world.velocities('sheet').length, 3 * 144);

// Errors name line, key and file; they leave the module usable.
for (const [text, kind, words] of [['step = [', 'content', /scene\.toml: line 1/], [scene.replace('mass', 'mess'), 'content', /mess/],
  [scene.replace('duck.tets', 'swan.tets'), 'system', /swan\.tets/], [scene.replace('0, 0, 0.5', '0, 0, 0'), 'content', /floor/]])
  await assert.rejects(loadScene(text, files), (error) => error instanceof TremoloError && error.kind === kind && words.test(error.message));
await assert.rejects(loadScene(scene, { ...files, 'duck.tets': files['duck.tets'].slice(0, 1000) }), TremoloError);
world.release();

// Worlds give their memory back.
const { heap } = { heap: () => world.tremolo.engine.HEAPU8.length };
let size = 0;
for (let k = 0; k < 12; ++k) {
  const one = await loadScene(scene, files);
  one.step(2);
  one.release();
  if (k === 3) size = heap();
}
assert.equal(heap(), size);
const bytes = ['engine-world.wasm', 'engine-world.mjs', 'scene.mjs'].map((name) => gzipSync(readFileSync(join(packagePath, name)), { level: 9 }).length);
console.log(`engine-world.wasm, engine-world.mjs, scene.mjs: ${bytes.join(', ')} bytes compressed; memory ${size / 1e6} MB`);
