// Basis files that are none, in the engine for pages: each is refused in the reader's words or
// becomes a model that can step; nothing traps, and memory is given back. The engine is one that
// does not check checksums, so that damage gets as far as it can.
// usage: node corpus_test.mjs PACKAGE GOLDEN [CORPUS...]
// PACKAGE: tremolo.mjs with that engine next to it. GOLDEN, CORPUS: folders of files.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [packagePath, golden, ...corpora] = process.argv.slice(2);
const { loadTremolo, TremoloError } = await import(pathToFileURL(join(packagePath, 'tremolo.mjs')));
const tremolo = await loadTremolo({ wasmBinary: readFileSync(join(packagePath, 'engine.wasm')) });
const filesOf = (folder) => (existsSync(folder) ? readdirSync(folder).map((name) => join(folder, name))
  .filter((path) => statSync(path).isFile()).map((path) => new Uint8Array(readFileSync(path))) : []);

const counts = { models: 0, refused: 0 };
function read(bytes) {
  let model = null;
  try {
    model = tremolo.loadModel(bytes);
    const body = model.createBody({ step: 1e-3 });
    body.step(1);
    body.positions();
    body.release();
    ++counts.models;
  } catch (error) {
    // A trap or an error of the glue is no TremoloError.
    if (!(error instanceof TremoloError)) throw error;
    assert.ok(error.message.length > 10, error.message);
    ++counts.refused;
  }
  model?.release();
}

// Numbers that are the same every time (xorshift).
let seed = 0x9e3779b9;
function below(n) {
  seed ^= seed << 13;
  seed ^= seed >>> 17;
  seed ^= seed << 5;
  return (seed >>> 0) % n;
}
const kOdd = [0, 1, 0x7f, 0x80, 0xff];
function damaged(bytes) {
  const copy = bytes.slice(0, below(8) === 0 ? below(bytes.length) : bytes.length);
  for (let k = 1 + below(4); k > 0 && copy.length > 0; --k) {
    const at = below(2) === 0 ? below(Math.min(copy.length, 1200)) : below(copy.length);
    for (let i = at; i < Math.min(copy.length, at + [1, 4, 8][below(3)]); ++i)
      copy[i] = below(2) === 0 ? kOdd[below(5)] : below(256);
  }
  return copy;
}

const whole = filesOf(golden);
assert.ok(whole.length >= 3, `${golden} has no files`);
for (const bytes of [...whole, ...corpora.flatMap(filesOf)]) read(bytes);
assert.ok(counts.models >= whole.length, 'the golden files are models');
for (const bytes of whole) for (let length = 0; length < bytes.length; length += 7) read(bytes.slice(0, length));
for (let k = 0; k < 3000; ++k) read(damaged(whole[k % whole.length]));
// A refused file has returned its memory.
const size = tremolo.engine.HEAPU8.length;
for (let k = 0; k < 1000; ++k) read(damaged(whole[k % whole.length]));
console.log(`${counts.models} models, ${counts.refused} refused, ${size >> 20} MB`);
assert.equal(tremolo.engine.HEAPU8.length, size);
console.log('1 passed, 0 failed');
