// Types of tremolo.mjs, which says what each does. Units are SI.
export type Vector = ArrayLike<number>;
export type Place = { triangle: number; weights: ArrayLike<number> };
export type Hit = Place & { vertex: number; distance: number; point: number[] };

export class TremoloError extends Error {
  status: number;
  kind: 'system' | 'usage' | 'content' | 'solver' | 'bound' | 'unknown';
}

export function loadTremolo(options?: {
  wasmBinary?: Uint8Array | ArrayBuffer;
  /** engine-full.wasm: also moving frames, gravity, bones, colliders, joints, saved states. */
  full?: boolean;
}): Promise<Tremolo>;

export class Tremolo {
  readonly engine: Record<string, (...values: (number | bigint)[]) => number> & { HEAPU8: Uint8Array };
  readonly version: string;
  readonly integrators: string[];
  loadModel(bytes: Uint8Array | ArrayBuffer, options?: { modes?: number }): Model;
  /** Colliders need `full`. */
  plane(): Collider;
  sphere(radius: number): Collider;
  capsule(radius: number, halfLength: number): Collider;
  cylinder(radius: number, halfLength: number): Collider;
  box(halfExtents: Vector): Collider;
}

export interface BodyOptions {
  integrator?: string;
  split?: string;
  step?: number;
  alpha?: number;
  dampingRatio?: string;
  beta?: number;
  newmarkBeta?: number;
  newmarkGamma?: number;
  safety?: number;
  tolerance?: number;
  maxIterations?: number;
  /** 'driven' and 'free' need `full`. */
  frame?: 'fixed' | 'driven' | 'free';
}

export class Model {
  readonly modes: number;
  readonly vertices: number;
  readonly triangles: number;
  readonly hasUvs: boolean;
  frequencies(): Float64Array;
  corners(): Uint32Array;
  vertexIds(): Uint32Array;
  uvs(): Float32Array;
  shapes(): { rest: Float32Array; shapes: Float32Array };
  createBody(options?: BodyOptions): Body;
  release(): void;
}

export class Collider {
  release(): void;
}

export interface PlacedCollider {
  collider: Collider;
  position?: Vector;
  quaternion?: Vector;
  nextPosition?: Vector;
  nextQuaternion?: Vector;
  friction?: number;
  restitution?: number;
}

export class Body {
  readonly model: Model;
  readonly modes: number;
  readonly vertices: number;
  readonly time: number;
  step(count?: number): void;
  state(): { q: Float64Array; p: Float64Array };
  setState(q: Vector, p?: Vector): void;
  applyForce(vertex: number, force: Vector, steps?: number): void;
  clearForces(): void;
  energy(): { kinetic: number; potential: number; highBand: number; total: number };
  positions(): Float64Array;
  surface(): { positions: Float32Array; normals: Float32Array };
  setDamping(alpha: number, beta: number): void;
  /** These four need `full`. */
  setGravity(gravity: Vector): void;
  setPose(position: Vector, quaternion?: Vector): void;
  pose(): { position: Float64Array; quaternion: Float64Array };
  setMotion(velocity: Vector, spin?: Vector): void;
  pick(origin: Vector, direction: Vector): Hit | null;
  setContact(options?: { points?: number; margin?: number; stiffness?: number; modulus?: number }): void;
  grab(place: Place, stiffness: number, damping?: number): bigint;
  pin(place: Place): bigint;
  moveHand(hand: bigint, place: Vector): void;
  letGo(hand: bigint): void;
  handForce(hand: bigint): Float64Array;
  /** Needs `full`. */
  stepAmong(placed: PlacedCollider[]): void;
  release(): void;
}
