// The package in node: its numbers against the native engine's, its errors, its memory.
// usage: node engine_test.mjs PACKAGE TREMOLO MODEL FOLDER
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';

const [packagePath, program, modelPath, folder] = process.argv.slice(2);
const bytes = readFileSync(modelPath);
const kCoreBytes = 270000; // 265 271 now; 150 000 are aimed at
const kVertex = 1045, kForce = [0.05, 0.4, -0.2], kSteps = 1000, kStep = 0.003;

function nativeState(integrator) {
  const out = join(folder, integrator);
  execFileSync(program, ['run', modelPath, '--integrator', integrator, '--tolerance', '1e-12', '--load',
    'impulse', '--at', `${kVertex}`, '--force', kForce.join(','), '--duration', `${kSteps * kStep}`,
    '--every', `${kSteps}`, '--coordinate', 'all', '--out', out],
  { env: { ...process.env, TREMOLO_VECTORS: 'plain' }, stdio: 'ignore' });
  const lines = readFileSync(join(out, 'run.csv'), 'utf8').trim().split('\n');
  const names = lines[0].split(','), last = lines.at(-1).split(',').map(Number);
  return names.flatMap((name, k) => (/^q\d+$/.test(name) ? [last[k]] : []));
}

for (const file of ['tremolo.mjs', 'tremolo.single.mjs']) {
  const { loadTremolo, TremoloError } = await import(pathToFileURL(join(packagePath, file)));
  const tremolo = await loadTremolo();
  assert.match(tremolo.version, /^\d+\.\d+\.\d+$/);
  const model = tremolo.loadModel(bytes);
  for (const integrator of ['ep4', 'ep2', 'newmark', 'imexv', 'implicit-euler']) {
    const body = model.createBody({ integrator, step: kStep, tolerance: 1e-12 });
    body.applyForce(kVertex, kForce, 1);
    body.step(kSteps);
    const { q } = body.state(), expected = nativeState(integrator);
    assert.equal(q.length, expected.length);
    const size = Math.max(...expected.map(Math.abs));
    const worst = Math.max(...expected.map((x, i) => Math.abs(x - q[i])));
    console.log(`${file} ${integrator}: ${(worst / size).toExponential(1)} of max |q|`);
    assert.ok(size > 0 && worst <= 1e-9 * size, `${integrator}: ${worst / size}`);
    body.release();
  }
  // The energy balance: the work of the pull is the body's energy.
  const body = model.createBody({ frame: 'fixed' });
  body.setContact();
  const rest = body.positions(), corners = model.corners();
  const target = [0, 1, 2].map((k) => (rest[3 * corners[0] + k] + rest[3 * corners[1] + k] +
    rest[3 * corners[2] + k]) / 3);
  const hit = body.pick([target[0], target[1] - 1, target[2]], [0, 2, 0]);
  assert.ok(hit && Math.abs(hit.distance - (hit.point[1] - target[1] + 1)) < 1e-12);
  const hand = body.grab(hit, 5, 0);
  body.moveHand(hand, [hit.point[0], hit.point[1] + 0.02, hit.point[2]]);
  body.step(50);
  assert.ok(Math.hypot(...body.handForce(hand)) > 1e-4);
  body.letGo(hand);
  const before = body.energy().total;
  assert.ok(before > 0);
  body.step(2000);
  assert.ok(Math.abs(body.energy().total - before) <= 1e-12 * before);
  // Errors have the library's message and change nothing.
  const refused = (work, kind, words) => assert.throws(work, (error) =>
    error instanceof TremoloError && error.kind === kind && error.message.includes(words));
  refused(() => tremolo.loadModel(bytes.subarray(0, 1000)), 'content', 'memory');
  refused(() => tremolo.loadModel(new Uint8Array(64)), 'content', 'basis');
  refused(() => model.createBody({ integrator: 'magic' }), 'usage', 'magic');
  refused(() => body.applyForce(1e9, [1, 0, 0]), 'usage', 'vertex');
  refused(() => body.setDamping(-1, 0), 'usage', '');
  body.release();
  model.release();
  // The wrapper gives structs the room that they take: their first number is their size.
  for (const [name, bytes] of [['body', 88], ['contact', 56]]) {
    const at = tremolo.engine._malloc(256);
    tremolo.engine[`_tremolo_${name}_options_init`](at);
    assert.equal(new DataView(tremolo.engine.HEAPU8.buffer).getUint32(at, true), bytes, `tremolo_${name}_options`);
    tremolo.engine._free(at);
  }
  // Memory is given back: as much again fits into what there is.
  const grown = () => tremolo.engine.HEAPU8.length;
  const cycle = () => {
    const again = tremolo.loadModel(bytes);
    again.createBody().release();
    again.release();
  };
  cycle();
  const size = grown();
  for (let k = 0; k < 10; ++k) cycle();
  assert.equal(grown(), size);
}

// The module for browsers without vectors moves like the native engine, too. Who asks for no module
// there gets it.
{
  const { loadTremolo } = await import(pathToFileURL(join(packagePath, 'tremolo.mjs')));
  const { validate, instantiate } = WebAssembly, started = [];
  WebAssembly.instantiate = (bytes, imports) => {
    started.push(bytes.length);
    return instantiate(bytes, imports);
  };
  await loadTremolo();
  WebAssembly.validate = () => false;
  const plain = await loadTremolo();
  Object.assign(WebAssembly, { validate, instantiate });
  const model = plain.loadModel(bytes);
  for (const integrator of ['ep4', 'imexv']) {
    const body = model.createBody({ integrator, step: kStep, tolerance: 1e-12 });
    body.applyForce(kVertex, kForce, 1);
    body.step(kSteps);
    const { q } = body.state(), expected = nativeState(integrator);
    const size = Math.max(...expected.map(Math.abs));
    const worst = Math.max(...expected.map((x, i) => Math.abs(x - q[i])));
    console.log(`engine-plain.wasm ${integrator}: ${(worst / size).toExponential(1)} of max |q|`);
    assert.ok(size > 0 && worst <= 1e-9 * size, `${integrator}: ${worst / size}`);
    body.release();
  }
  model.release();
  const sizes = ['engine.wasm', 'engine-plain.wasm'].map((name) => readFileSync(join(packagePath, name)).length);
  assert.deepEqual(started, sizes);
}

// The core is small; the parts left out of it are in the full module. A body of both moves equally,
// to the bit, also in a hand.
const sizeOf = (...names) => names.reduce((sum, name) =>
  sum + gzipSync(readFileSync(join(packagePath, name)), { level: 9 }).length, 0);
const core = sizeOf('engine.wasm', 'engine.mjs', 'tremolo.mjs'), whole = sizeOf('engine-full.wasm');
console.log(`gzip -9: core with both scripts ${core} bytes, full module ${whole} bytes`);
assert.ok(core <= kCoreBytes, `the core has grown to ${core} bytes`);
const { loadTremolo } = await import(pathToFileURL(join(packagePath, 'tremolo.mjs')));
const small = await loadTremolo(), full = await loadTremolo({ full: true });
for (const name of ['_tremolo_contacts_step', '_tremolo_body_step_among', '_tremolo_body_create_on_bones',
  '_tremolo_body_set_gravity', '_tremolo_body_save'])
  assert.deepEqual([small, full].map(({ engine }) => Object.hasOwn(engine, name)), [false, true], name);
// A call that the core lacks says where it is.
const elsewhere = (work) => assert.throws(work, (error) => error.constructor.name === 'TremoloError' &&
  error.kind === 'usage' && error.message.includes('engine-full.wasm'));
const fixed = small.loadModel(bytes).createBody();
for (const work of [() => small.plane(), () => small.box([1, 1, 1]), () => fixed.setGravity([0, 0, -9.81]),
  () => fixed.setPose([0, 0, 0]), () => fixed.setMotion([0, 0, 1]), () => fixed.stepAmong([]),
  () => fixed.model.createBody({ frame: 'driven' }), () => fixed.model.createBody({ frame: 'free' })])
  elsewhere(work);
const states = [small, full].map((tremolo) => {
  const body = tremolo.loadModel(bytes).createBody({ step: kStep });
  body.applyForce(kVertex, kForce, 1);
  body.step(100);
  body.setContact();
  const hand = body.grab({ triangle: 0, weights: [0.2, 0.3, 0.5] }, 5, 0.01);
  body.moveHand(hand, [0, 0, 0]);
  body.step(20);
  assert.ok(Math.hypot(...body.handForce(hand)) > 0);
  return body.state().q;
});
assert.deepEqual(states[0], states[1]);
full.make((out) => full.engine._tremolo_contacts_create(0, out));
// A driven body is where it is put, and gravity bends it.
const horse = full.loadModel(bytes), driven = horse.createBody({ frame: 'driven', step: kStep });
const atRest = driven.positions();
driven.setPose([1, 2, 3]);
assert.ok(driven.positions().every((x, i) => Math.abs(x - atRest[i] - 1 - (i % 3)) < 1e-14));
driven.setGravity([0, 0, -9.81]);
driven.step(10);
assert.ok(driven.energy().total > 0);
// A plate that moves down onto a body presses it down: nothing is above it except by contact's
// depth.
const pressed = horse.createBody({ step: kStep }), top = (all) => all.reduce((most, z, i) =>
  (i % 3 === 2 ? Math.max(most, z) : most), -Infinity);
pressed.setContact();
const plate = full.plane(), high = top(atRest), down = [0, 1, 0, 0];
for (let k = 0; k < 100; ++k)
  pressed.stepAmong([{ collider: plate, position: [0, 0, high - 1e-4 * k], quaternion: down,
    nextPosition: [0, 0, high - 1e-4 * (k + 1)], nextQuaternion: down }]);
const pushed = top(pressed.positions());
console.log(`a plate 0.01 m down: the top is ${(high - pushed).toFixed(4)} m lower`);
assert.ok(pushed < high - 5e-3 && pushed < high - 1e-2 + 5e-3, `${pushed} of ${high}`);
console.log('1 passed, 0 failed');
