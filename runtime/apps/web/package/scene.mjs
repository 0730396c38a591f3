// Scenes of bodies of all kinds in JavaScript: reduced and rigid bodies, tetrahedra and cloths in
// contact with each other and with colliders, as scene files describe them. The module,
// engine-world.wasm, is read when the first scene is loaded. Units are SI; positions are
// x y z x y z ... Whatever fails throws a TremoloError with the library's message.
import { read } from './engine.mjs';
import { Tremolo, TremoloError } from './tremolo.mjs';

export { TremoloError };

const kKinds = ['reduced', 'rigid', 'tets', 'cloth'];
const kAccount = ['kinetic', 'potential', 'contact', 'atStart', 'load', 'support', 'gravity', 'wind', 'contactGiven',
  'restitution', 'friction', 'hand', 'joint', 'damping', 'method', 'remainder'];
// Scenes name their files from a folder this deep, so that "../.." leads somewhere.
const kFolder = '/1/2/3/4/5/6/7/8';

let started = null;

// wasmBinary: the module's bytes; without it, it is read from this file's folder.
async function start(wasmBinary) {
  const { default: createEngine } = await import('./engine-world.mjs');
  const bytes = wasmBinary ?? (await read(new URL('./engine-world.wasm', import.meta.url)));
  const module = await createEngine({ wasmBinary: bytes, print: () => {}, printErr: () => {} });
  return { tremolo: new Tremolo(module), files: module.FS };
}

// Where a file of that name is for a scene.
function pathOf(name) {
  return decodeURIComponent(new URL(name, `file://${kFolder}/`).pathname);
}

// text: a scene file with [[bodies]] (TOML). files: the bytes of each file that it names, by the
// names in it: { 'duck.tets': bytes }. They are not needed after the call.
export async function loadScene(text, files = {}, { wasmBinary } = {}) {
  started ??= start(wasmBinary);
  started.catch(() => { started = null; });
  const { tremolo, files: disk } = await started;
  const { engine } = tremolo;
  const paths = [];
  let scene = 0;
  try {
    for (const [name, bytes] of Object.entries(files)) {
      const path = pathOf(name);
      disk.mkdirTree(path.slice(0, path.lastIndexOf('/')) || '/');
      disk.writeFile(path, bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes));
      paths.push(path);
    }
    scene = tremolo.make((out, scratch) =>
      engine._tremolo_scene_parse(scratch.text(text), scratch.text(`${kFolder}/scene.toml`), out));
    return new World(tremolo, tremolo.make((out) => engine._tremolo_world_create(scene, 1, out)));
  } catch (error) {
    if (error instanceof TremoloError) error.message = error.message.replaceAll(`${kFolder}/`, '');
    throw error;
  } finally {
    if (scene !== 0) engine._tremolo_scene_destroy(scene);
    for (const path of paths) disk.unlink(path);
  }
}

// Bodies are named by their names in the scene. A world holds memory until release().
export class World {
  constructor(tremolo, handle) {
    this.tremolo = tremolo;
    this.handle = handle;
  }

  call(name, ...rest) {
    this.tremolo.check(this.tremolo.engine[name](this.handle, ...rest));
  }
  // Numbers that call(pointer to the first) writes.
  numbers(count, call) {
    return this.tremolo.read(Float64Array, count, call);
  }
  // The id of a body.
  id(name) {
    const { engine } = this.tremolo;
    return this.tremolo.with((scratch) => {
      const at = scratch.bytes(8);
      this.tremolo.check(engine._tremolo_world_find(this.handle, scratch.text(name), at));
      return new DataView(engine.HEAPU8.buffer).getBigUint64(at, true);
    });
  }
  nameOf(id) {
    return this.tremolo.string(this.tremolo.engine._tremolo_world_name(this.handle, id));
  }

  get names() {
    const { engine } = this.tremolo;
    const count = engine._tremolo_world_bodies(this.handle);
    return Array.from({ length: count }, (_, k) => this.nameOf(engine._tremolo_world_body(this.handle, k)));
  }
  // 'reduced', 'rigid', 'tets' or 'cloth'.
  kind(body) {
    const id = this.id(body);
    return kKinds[this.tremolo.make((out) => this.tremolo.engine._tremolo_world_kind(this.handle, id, out))];
  }

  get time() {
    return this.tremolo.engine._tremolo_world_time(this.handle);
  }
  // Bodies that fail are named by the error; the world goes on without them at the next call.
  step(count = 1) {
    this.call('_tremolo_world_step', BigInt(count), 0);
  }

  // Corners of the drawn triangles.
  corners(body) {
    const id = this.id(body), { engine } = this.tremolo;
    return this.tremolo.read(Uint32Array, 3 * engine._tremolo_world_triangles(this.handle, id),
      (at, n) => engine._tremolo_world_triangle_corners(this.handle, id, at, n));
  }
  // Of the drawn vertices, in single precision.
  positions(body) {
    const id = this.id(body), { engine } = this.tremolo;
    return this.tremolo.read(Float32Array, 3 * engine._tremolo_world_vertices(this.handle, id),
      (at, n) => engine._tremolo_world_positions_float(this.handle, id, at, n));
  }
  velocities(body) {
    const id = this.id(body), { engine } = this.tremolo;
    return this.tremolo.read(Float64Array, 3 * engine._tremolo_world_vertices(this.handle, id),
      (at, n) => engine._tremolo_world_velocities(this.handle, id, at, n));
  }

  // The energy balance, J: what is there now, and what was given since the start.
  account(body) {
    const id = this.id(body);
    const values = this.numbers(kAccount.length,
      (at) => this.tremolo.engine._tremolo_world_account(this.handle, id, at));
    return Object.fromEntries(kAccount.map((name, k) => [name, values[k]]));
  }
  momentum(body) {
    const id = this.id(body);
    const both = this.numbers(6, (at) => this.tremolo.engine._tremolo_world_momentum(this.handle, id, at, at + 24));
    return { linear: [...both.slice(0, 3)], angular: [...both.slice(3)] };
  }

  // Contacts that began or ended in the last call of step(). other: the other body's name, or null
  // where `collider` is a collider's number.
  events() {
    const { engine } = this.tremolo;
    const count = engine._tremolo_world_events(this.handle);
    return Array.from({ length: count }, (_, k) => this.tremolo.with((scratch) => {
      const at = scratch.bytes(112);
      this.call('_tremolo_world_event', k, at);
      const view = new DataView(engine.HEAPU8.buffer, at, 112);
      const vector = (from) => [0, 8, 16].map((more) => view.getFloat64(from + more, true));
      const other = view.getBigUint64(16, true);
      return { time: view.getFloat64(0, true), begins: view.getInt32(28, true) !== 0,
        body: this.nameOf(view.getBigUint64(8, true)), other: other === 0n ? null : this.nameOf(other),
        collider: other === 0n ? view.getUint32(24, true) : null, impulse: view.getFloat64(32, true),
        push: vector(40), position: vector(64), normal: vector(88) };
    }));
  }

  // The first hit of a ray on a drawn surface: { body, triangle, weights, distance, point }, or null.
  pick(origin, direction) {
    const { engine } = this.tremolo;
    return this.tremolo.with((scratch) => {
      const site = scratch.bytes(40), rest = scratch.bytes(32);
      this.call('_tremolo_world_pick', scratch.doubles(origin), scratch.doubles(direction), site, rest, rest + 8);
      const view = new DataView(engine.HEAPU8.buffer), number = (at) => view.getFloat64(at, true);
      const id = view.getBigUint64(site, true);
      if (id === 0n) return null;
      return { body: this.nameOf(id), triangle: view.getUint32(site + 8, true),
        weights: [16, 24, 32].map((k) => number(site + k)), distance: number(rest),
        point: [8, 16, 24].map((k) => number(rest + k)) };
    });
  }
  // hit: of pick(). Stiffness in N/m, damping in N s/m. Returns the hand, for the calls below.
  grab(hit, stiffness, damping = 0) {
    const { engine } = this.tremolo, id = this.id(hit.body);
    return this.tremolo.with((scratch) => {
      const site = scratch.bytes(40), out = scratch.bytes(8), view = new DataView(engine.HEAPU8.buffer);
      view.setBigUint64(site, id, true);
      view.setUint32(site + 8, hit.triangle, true);
      view.setUint32(site + 12, 0, true);
      hit.weights.forEach((weight, k) => view.setFloat64(site + 16 + 8 * k, weight, true));
      this.call('_tremolo_world_grab_site', site, stiffness, damping, out);
      return { id, number: new DataView(engine.HEAPU8.buffer).getBigUint64(out, true) };
    });
  }
  // Where the hand is at the end of the next step, m, world.
  moveHand(hand, place) {
    this.tremolo.with((s) => this.call('_tremolo_world_move_hand', hand.id, hand.number, s.doubles(place)));
  }
  letGo(hand) {
    this.call('_tremolo_world_let_go', hand.id, hand.number);
  }

  // Removes a body with its hands and joints.
  remove(body) {
    this.call('_tremolo_world_remove', this.id(body));
  }
  // A collider, by its name, goes to the pose (m; w, x, y, z) in the next step.
  moveCollider(name, position, quaternion = [1, 0, 0, 0]) {
    const { engine } = this.tremolo;
    this.tremolo.with((s) => {
      const at = s.bytes(4);
      this.call('_tremolo_world_find_collider', s.text(name), at);
      const number = new DataView(engine.HEAPU8.buffer).getUint32(at, true);
      this.call('_tremolo_world_move_collider', number, s.doubles(position), s.doubles(quaternion));
    });
  }

  // The state between steps; restore() takes the bytes of a world of the same scene.
  save() {
    const size = this.tremolo.make((out) => this.tremolo.engine._tremolo_world_save(this.handle, 0, 0, out));
    return this.tremolo.with((scratch) => {
      const out = scratch.bytes(4), at = scratch.bytes(size);
      this.call('_tremolo_world_save', at, size, out);
      return this.tremolo.engine.HEAPU8.slice(at, at + size);
    });
  }
  restore(bytes) {
    this.tremolo.with((scratch) => {
      const at = scratch.bytes(bytes.length);
      this.tremolo.engine.HEAPU8.set(bytes, at);
      this.call('_tremolo_world_restore', at, bytes.length);
    });
  }

  release() {
    this.tremolo.engine._tremolo_world_destroy(this.handle);
    this.handle = 0;
  }
}
