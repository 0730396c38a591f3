// Types of scene.mjs, which says what each does. Units are SI.
import { Vector } from './tremolo.mjs';
export { TremoloError } from './tremolo.mjs';

export type Kind = 'reduced' | 'rigid' | 'tets' | 'cloth';
export type Hit = { body: string; triangle: number; weights: number[]; distance: number; point: number[] };
export type Hand = { readonly id: bigint; readonly number: bigint };
export type Account = Record<
  'kinetic' | 'potential' | 'contact' | 'atStart' | 'load' | 'support' | 'gravity' | 'wind' | 'contactGiven' |
  'restitution' | 'friction' | 'hand' | 'joint' | 'damping' | 'method' | 'remainder', number>;
export type ContactEvent = {
  time: number; begins: boolean; body: string; other: string | null; collider: number | null; impulse: number;
  push: number[]; position: number[]; normal: number[];
};

/** text: a scene file; files: the bytes of each file that it names, by the names in it. */
export function loadScene(text: string, files?: Record<string, Uint8Array | ArrayBuffer>,
  options?: { wasmBinary?: Uint8Array | ArrayBuffer }): Promise<World>;

export class World {
  readonly names: string[];
  readonly time: number;
  kind(body: string): Kind;
  step(count?: number): void;
  corners(body: string): Uint32Array;
  positions(body: string): Float32Array;
  velocities(body: string): Float64Array;
  account(body: string): Account;
  momentum(body: string): { linear: number[]; angular: number[] };
  events(): ContactEvent[];
  pick(origin: Vector, direction: Vector): Hit | null;
  grab(hit: Hit, stiffness: number, damping?: number): Hand;
  moveHand(hand: Hand, place: Vector): void;
  letGo(hand: Hand): void;
  remove(body: string): void;
  moveCollider(name: string, position: Vector, quaternion?: Vector): void;
  save(): Uint8Array;
  restore(bytes: Uint8Array): void;
  release(): void;
}
