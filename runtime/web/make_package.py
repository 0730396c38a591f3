"""The npm package: engine, wrapper, types, and a single file with everything inside.

usage: make_package.py SOURCE ENGINE OUT VERSION"""
import base64
import json
import pathlib
import re
import shutil
import sys

source, engine, out = (pathlib.Path(name) for name in sys.argv[1:4])
package = out / "package"
package.mkdir(parents=True, exist_ok=True)
glue = (engine / "tremolo_engine.mjs").read_text().replace("tremolo_engine.wasm", "engine.wasm")
wasm = (engine / "tremolo_engine.wasm").read_bytes()
wrapper = (source / "package/tremolo.mjs").read_text()
(package / "engine.mjs").write_text(glue)
(package / "engine.wasm").write_bytes(wasm)
for name in ("tremolo.mjs", "tremolo.d.ts", "README.md"):
    shutil.copy(source / "package" / name, package / name)
shutil.copy(source.parent.parent / "LICENSE", package / "LICENSE")

# One module: the glue without its export, the bytes, the wrapper without its import.
bare_glue, found = re.subn(r"export default (\w+);\s*$", r"const createEngine = \1;\n", glue)
bare_wrapper, imported = re.subn(r"import createEngine from '\./engine\.mjs';\n", "", wrapper)
if found != 1 or imported != 1:
    sys.exit("make_package.py: the engine's glue or the wrapper has another shape than expected")
inlined = ("function tremoloWasm() {\n  const raw = atob('" + base64.b64encode(wasm).decode() +
           "');\n  return Uint8Array.from(raw, (c) => c.charCodeAt(0));\n}\n")
(out / "engine.inline.js").write_text(bare_glue + inlined + bare_wrapper.replace("export ", ""))
single = bare_wrapper.replace("{ wasmBinary } = {}", "{ wasmBinary = tremoloWasm() } = {}")
(package / "tremolo.single.mjs").write_text(bare_glue + inlined + single)
(package / "package.json").write_text(json.dumps({
    "name": "tremolo", "version": sys.argv[4], "type": "module", "license": "MIT",
    "description": "Deformable solids that vibrate in real time without losing their energy",
    "main": "tremolo.mjs", "types": "tremolo.d.ts",
    "exports": {".": {"types": "./tremolo.d.ts", "default": "./tremolo.mjs"},
                "./single": {"types": "./tremolo.d.ts", "default": "./tremolo.single.mjs"}},
    "files": ["*.mjs", "*.d.ts", "engine.wasm", "README.md", "LICENSE"]}, indent=2) + "\n")
