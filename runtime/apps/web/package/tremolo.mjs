// The engine in JavaScript: models, bodies, colliders and hands of runtime/tremolo.h with typed
// arrays. Units are SI; positions are x y z x y z ... Whatever fails throws a TremoloError with the
// library's message. Objects hold memory of the engine until release().
import createEngine from './engine.mjs';

const STATUS = ['ok', 'system', 'usage', 'content', 'solver', 'bound'];

export class TremoloError extends Error {
  constructor(status, message) {
    super(message);
    this.name = 'TremoloError';
    this.status = status;
    this.kind = STATUS[status] ?? 'unknown';
  }
}

// A module whose only function makes a vector.
const kVectors = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0,
  10, 8, 1, 6, 0, 65, 0, 253, 15, 11]);

// wasmBinary: the bytes of a module; without it, one is read from this file's folder: engine.wasm,
// or engine-plain.wasm without vectors (SIMD), or with `full` engine-full.wasm. Only that has
// driven and free bodies, gravity, bones, colliders, contact between bodies, joints and saved
// states; functions that need it say `full` in their comments.
export async function loadTremolo({ wasmBinary, full = false } = {}) {
  const core = WebAssembly.validate(kVectors) ? './engine.wasm' : './engine-plain.wasm';
  return new Tremolo(await createEngine({ wasmBinary, file: full ? './engine-full.wasm' : core }));
}

// Memory that a call needs, given back in the end.
class Scratch {
  constructor(engine) {
    this.engine = engine;
    this.held = [];
  }
  bytes(count) {
    const at = this.engine._malloc(Math.max(count, 8));
    if (at === 0) throw new TremoloError(1, 'out of memory');
    this.held.push(at);
    return at;
  }
  // Growing the engine's memory moves it, so a view is created for each use.
  doubles(values) {
    const at = this.bytes(8 * values.length);
    new Float64Array(this.engine.HEAPU8.buffer, at, values.length).set(values);
    return at;
  }
  text(value) {
    const bytes = new TextEncoder().encode(`${value}\0`);
    const at = this.bytes(bytes.length);
    this.engine.HEAPU8.set(bytes, at);
    return at;
  }
  free() {
    for (const at of this.held) this.engine._free(at);
    this.held = [];
  }
}

// A function that the module lacks throws when it is called, and names the module that has it.
const absent = new Proxy({}, {
  get(none, name) {
    if (typeof name !== 'string' || !name.startsWith('_tremolo_')) return undefined;
    return () => {
      throw new TremoloError(2, `${name.slice(1)} is not in this module but in engine-full.wasm: ` +
        'loadTremolo({ full: true })');
    };
  },
});

export class Tremolo {
  constructor(engine) {
    // The functions of tremolo.h, each with _ before its name.
    this.engine = Object.setPrototypeOf(engine, absent);
  }

  string(at) {
    const heap = this.engine.HEAPU8;
    return new TextDecoder().decode(heap.slice(at, heap.indexOf(0, at)));
  }

  check(status) {
    if (status !== 0) throw new TremoloError(status, this.string(this.engine._tremolo_last_error()));
  }

  // Calls work(scratch) and frees its memory.
  with(work) {
    const scratch = new Scratch(this.engine);
    try {
      return work(scratch);
    } finally {
      scratch.free();
    }
  }

  // Returns an array of the type, filled by call(pointer, length).
  read(Type, length, call) {
    return this.with((scratch) => {
      const at = scratch.bytes(Type.BYTES_PER_ELEMENT * length);
      this.check(call(at, length));
      return new Type(this.engine.HEAPU8.buffer, at, length).slice();
    });
  }

  // The object that call(pointer to it) makes.
  make(call) {
    return this.with((scratch) => {
      const at = scratch.bytes(4);
      this.check(call(at, scratch));
      return new DataView(this.engine.HEAPU8.buffer).getUint32(at, true);
    });
  }

  get version() {
    return this.string(this.engine._tremolo_version());
  }

  get integrators() {
    const names = [];
    for (let at; (at = this.engine._tremolo_integrator_name(names.length)) !== 0; )
      names.push(this.string(at));
    return names;
  }

  // bytes: of a basis file. modes: leading coordinates to keep, 0 for all.
  loadModel(bytes, { modes = 0 } = {}) {
    const source = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    const handle = this.make((out, scratch) => {
      const at = scratch.bytes(source.length);
      this.engine.HEAPU8.set(source, at);
      return this.engine._tremolo_model_load_memory(at, source.length, modes, out);
    });
    return new Model(this, handle);
  }

  // full
  plane() {
    return new Collider(this, this.make((out) => this.engine._tremolo_collider_plane(out)));
  }
  sphere(radius) {
    return new Collider(this, this.make((out) => this.engine._tremolo_collider_sphere(radius, out)));
  }
  capsule(radius, halfLength) {
    const make = (out) => this.engine._tremolo_collider_capsule(radius, halfLength, out);
    return new Collider(this, this.make(make));
  }
  cylinder(radius, halfLength) {
    const make = (out) => this.engine._tremolo_collider_cylinder(radius, halfLength, out);
    return new Collider(this, this.make(make));
  }
  box(halfExtents) {
    const make = (out, s) => this.engine._tremolo_collider_box(s.doubles(halfExtents), out);
    return new Collider(this, this.make(make));
  }
}

export class Model {
  constructor(tremolo, handle) {
    this.tremolo = tremolo;
    this.handle = handle;
    const engine = tremolo.engine;
    this.modes = engine._tremolo_model_modes(handle);
    this.vertices = engine._tremolo_model_surface_vertices(handle);
    this.triangles = engine._tremolo_model_triangles(handle);
  }

  array(Type, length, name) {
    const { tremolo } = this;
    return tremolo.read(Type, length, (at, n) => tremolo.engine[name](this.handle, at, n));
  }

  // Hz, ascending.
  frequencies() {
    return this.array(Float64Array, this.modes, '_tremolo_model_frequencies');
  }
  // Corners of the triangles, indices of the surface's vertices.
  corners() {
    return this.array(Uint32Array, 3 * this.triangles, '_tremolo_model_triangle_corners');
  }
  // For each vertex of the surface that of the mesh to push.
  vertexIds() {
    return this.array(Uint32Array, this.vertices, '_tremolo_model_surface_ids');
  }
  get hasUvs() {
    return this.tremolo.engine._tremolo_model_has_uvs(this.handle) !== 0;
  }
  uvs() {
    return this.array(Float32Array, 2 * this.vertices, '_tremolo_model_uvs');
  }

  // rest: 3 s positions; shapes: of each coordinate the 3 s displacements for q = 1, one after the
  // other. The surface is rest + sum of q_i shapes_i.
  shapes() {
    const length = 3 * this.vertices;
    const body = this.createBody();
    const q = new Float64Array(this.modes);
    const rest = body.positions();
    const shapes = new Float32Array(this.modes * length);
    for (let i = 0; i < this.modes; ++i) {
      q.fill(0);
      q[i] = 1;
      body.setState(q);
      const moved = body.positions();
      for (let k = 0; k < length; ++k) shapes[i * length + k] = moved[k] - rest[k];
    }
    body.release();
    return { rest: Float32Array.from(rest), shapes };
  }

  // integrator, split: names; dampingRatio: "2%" in place of alpha and beta; step, alpha, beta, newmarkBeta, newmarkGamma, safety, tolerance,
  // maxIterations: numbers; frame: 'fixed', or 'driven' or 'free' (full).
  createBody(options = {}) {
    const { tremolo } = this;
    const { engine } = tremolo;
    const handle = tremolo.make((out, scratch) => {
      const at = scratch.bytes(88);
      engine._tremolo_body_options_init(at);
      const view = new DataView(engine.HEAPU8.buffer);
      const texts = { integrator: 8, split: 12, dampingRatio: 80 };
      for (const [name, offset] of Object.entries(texts))
        if (options[name] !== undefined) {
          const text = scratch.text(options[name]);
          new DataView(engine.HEAPU8.buffer).setUint32(at + offset, text, true);
        }
      const numbers = { step: 16, alpha: 24, beta: 32, newmarkBeta: 40, newmarkGamma: 48, safety: 56,
        tolerance: 64 };
      for (const [name, offset] of Object.entries(numbers))
        if (options[name] !== undefined)
          new DataView(engine.HEAPU8.buffer).setFloat64(at + offset, options[name], true);
      const last = new DataView(engine.HEAPU8.buffer);
      if (options.maxIterations !== undefined) last.setInt32(at + 4, options.maxIterations, true);
      if (options.frame !== undefined) {
        const kind = ['fixed', 'driven', 'free'].indexOf(options.frame);
        if (kind < 0) throw new TremoloError(2, `frame: there is no '${options.frame}'`);
        last.setInt32(at + 72, kind, true);
      }
      return engine._tremolo_body_create(this.handle, at, out);
    });
    return new Body(this, handle);
  }

  // Bodies keep the data of the model that they need.
  release() {
    this.tremolo.engine._tremolo_model_release(this.handle);
    this.handle = 0;
  }
}

export class Collider {
  constructor(tremolo, handle) {
    this.tremolo = tremolo;
    this.handle = handle;
  }
  release() {
    this.tremolo.engine._tremolo_collider_destroy(this.handle);
    this.handle = 0;
  }
}

export class Body {
  constructor(model, handle) {
    this.model = model;
    this.tremolo = model.tremolo;
    this.handle = handle;
    this.modes = model.modes;
    this.vertices = model.vertices;
  }

  call(name, ...rest) {
    this.tremolo.check(this.tremolo.engine[name](this.handle, ...rest));
  }
  callWith(name, ...vectors) {
    this.tremolo.with((s) => this.call(name, ...vectors.map((v) => s.doubles(v))));
  }

  step(count = 1) {
    this.call('_tremolo_body_step', BigInt(count), 0);
  }
  get time() {
    return this.tremolo.engine._tremolo_body_time(this.handle);
  }

  // q, p: Float64Arrays of modes entries.
  state() {
    const { tremolo, modes } = this;
    const both = tremolo.read(Float64Array, 2 * modes, (at) =>
      tremolo.engine._tremolo_body_state(this.handle, at, at + 8 * modes, modes));
    return { q: both.slice(0, modes), p: both.slice(modes) };
  }
  setState(q, p = new Float64Array(this.modes)) {
    this.tremolo.with((s) =>
      this.call('_tremolo_body_set_state', s.doubles(q), s.doubles(p), this.modes));
  }

  // N, world, over the next steps.
  applyForce(vertex, force, steps = 1) {
    this.tremolo.with((s) => this.call('_tremolo_body_apply_force', vertex, s.doubles(force), steps));
  }
  clearForces() {
    this.call('_tremolo_body_clear_forces');
  }

  // J.
  energy() {
    const { tremolo } = this;
    const [kinetic, potential, highBand] = tremolo.read(Float64Array, 3, (at) =>
      tremolo.engine._tremolo_body_energy(this.handle, at, at + 8, at + 16));
    return { kinetic, potential, highBand, total: kinetic + potential };
  }

  positions() {
    const { tremolo } = this;
    return tremolo.read(Float64Array, 3 * this.vertices, (at, n) =>
      tremolo.engine._tremolo_body_positions_double(this.handle, at, n));
  }
  // Positions and normals in single precision.
  surface() {
    const { tremolo } = this;
    const n = 3 * this.vertices;
    const both = tremolo.read(Float32Array, 2 * n, (at) =>
      tremolo.engine._tremolo_body_surface_float(this.handle, at, at + 4 * n, n));
    return { positions: both.slice(0, n), normals: both.slice(n) };
  }

  setDamping(alpha, beta) {
    this.call('_tremolo_body_set_damping', alpha, beta);
  }
  // full
  setGravity(gravity) {
    this.callWith('_tremolo_body_set_gravity', gravity);
  }
  // full; quaternion: w, x, y, z.
  setPose(position, quaternion = [1, 0, 0, 0]) {
    this.callWith('_tremolo_body_set_pose', position, quaternion);
  }
  pose() {
    const { tremolo } = this;
    const all = tremolo.read(Float64Array, 7, (at) =>
      tremolo.engine._tremolo_body_pose(this.handle, at, at + 24));
    return { position: all.slice(0, 3), quaternion: all.slice(3) };
  }
  setMotion(velocity, spin = [0, 0, 0]) {
    this.callWith('_tremolo_body_set_motion', velocity, spin);
  }

  // The first hit of a ray, or null.
  pick(origin, direction) {
    return this.tremolo.with((s) => {
      const at = s.bytes(72);
      this.call('_tremolo_body_pick', s.doubles(origin), s.doubles(direction), at);
      const view = new DataView(this.tremolo.engine.HEAPU8.buffer, at, 72);
      if (view.getInt32(0, true) === 0) return null;
      const three = (from) => [0, 1, 2].map((k) => view.getFloat64(from + 8 * k, true));
      return { triangle: view.getUint32(4, true), vertex: view.getUint32(8, true),
        weights: three(16), distance: view.getFloat64(40, true), point: three(48) };
    });
  }

  // Makes the body feel hands, and colliders (full).
  setContact({ points, margin, stiffness, modulus } = {}) {
    this.tremolo.with((s) => {
      const { engine } = this.tremolo;
      const at = s.bytes(56);
      engine._tremolo_contact_options_init(at);
      const view = new DataView(engine.HEAPU8.buffer);
      if (points !== undefined) view.setInt32(at + 4, points, true);
      if (margin !== undefined) view.setFloat64(at + 8, margin, true);
      if (stiffness !== undefined) view.setFloat64(at + 16, stiffness, true);
      if (modulus !== undefined) view.setFloat64(at + 48, modulus, true);
      this.call('_tremolo_body_set_contact', at);
    });
  }

  // A hand at a point that pick() found; returns its number.
  grab({ triangle, weights }, stiffness, damping = 0) {
    const number = this.tremolo.read(BigUint64Array, 1, (at) =>
      this.tremolo.with((s) => this.tremolo.engine._tremolo_body_grab_at(
        this.handle, triangle, s.doubles(weights), stiffness, damping, at)));
    return number[0];
  }
  pin({ triangle, weights }) {
    const number = this.tremolo.read(BigUint64Array, 1, (at) =>
      this.tremolo.with((s) => this.tremolo.engine._tremolo_body_pin_at(
        this.handle, triangle, s.doubles(weights), at)));
    return number[0];
  }
  moveHand(hand, place) {
    this.tremolo.with((s) => this.call('_tremolo_body_move_hand', hand, s.doubles(place)));
  }
  letGo(hand) {
    this.call('_tremolo_body_release', hand);
  }
  handForce(hand) {
    return this.tremolo.read(Float64Array, 3, (at) =>
      this.tremolo.engine._tremolo_body_hand_force(this.handle, hand, at));
  }

  // full. One step among colliders: [{collider, position, quaternion, nextPosition, nextQuaternion,
  // friction, restitution}]; a collider without a next pose is at rest.
  stepAmong(placed) {
    this.tremolo.with((s) => {
      const { engine } = this.tremolo;
      const at = s.bytes(136 * placed.length);
      placed.forEach((one, k) => {
        const from = at + 136 * k;
        engine._tremolo_placed_collider_init(from, one.collider.handle);
        const numbers = new Float64Array(engine.HEAPU8.buffer, from + 8, 16);
        const position = one.position ?? [0, 0, 0];
        const quaternion = one.quaternion ?? [1, 0, 0, 0];
        numbers.set(position, 0);
        numbers.set(quaternion, 3);
        numbers.set(one.nextPosition ?? position, 7);
        numbers.set(one.nextQuaternion ?? quaternion, 10);
        if (one.friction !== undefined) numbers[14] = one.friction;
        if (one.restitution !== undefined) numbers[15] = one.restitution;
      });
      this.call('_tremolo_body_step_among', at, placed.length);
    });
  }

  release() {
    this.tremolo.engine._tremolo_body_destroy(this.handle);
    this.handle = 0;
  }
}
