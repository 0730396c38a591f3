// Starts the engine, a WebAssembly module: the functions of runtime/tremolo.h, each with _ before
// its name, and its memory. wasmBinary: the module's bytes; without it, `file` is read from this
// file's folder.
export default async function createEngine({ wasmBinary, file = './engine.wasm' } = {}) {
  let memory = null;
  const leave = (code) => {
    throw new Error(`the engine gave up (${code})`);
  };
  // It has no files, no environment and no output, and only the time since its start.
  const kNoSuchFunction = 52; // WASI's ENOSYS
  const system = {
    proc_exit: leave,
    clock_time_get(clock, precision, out) {
      const now = BigInt(Math.round(1e6 * performance.now()));
      new DataView(memory.buffer).setBigUint64(out, now, true);
      return 0;
    },
  };
  const imports = {
    env: { emscripten_notify_memory_growth() {} },
    wasi_snapshot_preview1: new Proxy(system, { get: (all, name) => all[name] ?? (() => kNoSuchFunction) }),
  };
  const started = wasmBinary
    ? await WebAssembly.instantiate(wasmBinary, imports)
    : await WebAssembly.instantiate(await read(new URL(file, import.meta.url)), imports);
  const { exports } = started.instance;
  memory = exports.memory;
  exports._initialize?.();
  // Growing the memory moves it: a view is created for each use.
  const engine = { get HEAPU8() { return new Uint8Array(memory.buffer); } };
  for (const [name, value] of Object.entries(exports))
    if (typeof value === 'function') engine[`_${name}`] = value;
  return engine;
}

export async function read(url) {
  if (url.protocol === 'file:' && globalThis.process?.versions?.node) {
    // node fetches no files.
    const { readFile } = await import('node:fs/promises');
    return readFile(url);
  }
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}
