"""The npm package: engine, wrapper, types, and a single file with everything inside.

usage: make_package.py SOURCE CORE FULL PLAIN WORLD OUT VERSION; CORE to WORLD: folders of the modules"""
import base64
import json
import pathlib
import re
import shutil
import sys

source, core, full, plain, world, out = (pathlib.Path(name) for name in sys.argv[1:7])
package = out / "package"
package.mkdir(parents=True, exist_ok=True)
for module in (core / "engine.wasm", full / "engine-full.wasm", world / "engine-world.wasm", world / "engine-world.mjs"):
    shutil.copy(module, package / module.name)
shutil.copy(plain / "engine.wasm", package / "engine-plain.wasm")
for name in ("tremolo.mjs", "engine.mjs", "scene.mjs", "tremolo.d.ts", "scene.d.ts", "README.md"):
    shutil.copy(source / "package" / name, package / name)
shutil.copy(source.resolve().parents[2] / "LICENSE", package / "LICENSE")

# One module: the starter without its export, the core's bytes, the wrapper without its import.
starter, found = re.subn(r"^export default ", "", (source / "package/engine.mjs").read_text(), flags=re.M)
starter = starter.replace("export async", "async")
wrapper, imported = re.subn(r"^import createEngine from '\./engine\.mjs';\n", "",
                            (source / "package/tremolo.mjs").read_text(), flags=re.M)
single, given = re.subn(r"\{ wasmBinary, full = false \} = \{\}",
                        "{ wasmBinary = tremoloWasm(), full = false } = {}", wrapper)
if (found, imported, given) != (1, 1, 1):
    sys.exit("make_package.py: engine.mjs or tremolo.mjs has another shape than expected")
wasm = (core / "engine.wasm").read_bytes()
inlined = ("function tremoloWasm() {\n  const raw = atob('" + base64.b64encode(wasm).decode() +
           "');\n  return Uint8Array.from(raw, (c) => c.charCodeAt(0));\n}\n")
(out / "engine.inline.js").write_text(starter + inlined + wrapper.replace("export ", ""))
(package / "tremolo.single.mjs").write_text(starter + inlined + single)
(package / "package.json").write_text(json.dumps({
    "name": "tremolo", "version": sys.argv[7], "type": "module", "license": "MIT",
    "description": "Deformable solids that vibrate in real time without losing their energy",
    "main": "tremolo.mjs", "types": "tremolo.d.ts",
    "exports": {".": {"types": "./tremolo.d.ts", "default": "./tremolo.mjs"},
                "./scene": {"types": "./scene.d.ts", "default": "./scene.mjs"},
                "./single": {"types": "./tremolo.d.ts", "default": "./tremolo.single.mjs"}},
    "files": ["*.mjs", "*.d.ts", "*.wasm", "README.md", "LICENSE"]}, indent=2) + "\n")
