"""The page: one file with the engine and the first model, the other models beside it.

usage: make_page.py SOURCE TREMOLO MODELS OUT"""
import base64
import json
import pathlib
import subprocess
import sys

source, program, models, out = (pathlib.Path(name) for name in sys.argv[1:5])
names = ["horse", "heart", "tower", "bridge", "basket", "beam"]
there = [name for name in names if (models / f"{name}.tremolo").exists()]
if not there:
    sys.exit(f"make_page.py: {models} has no models: run ./demo first")
(out / "models").mkdir(parents=True, exist_ok=True)
calls = {}
for name in there:
    light = out / "models" / f"{name}.tremolo"
    subprocess.run([program, "export", models / f"{name}.tremolo", "--light", light], check=True,
                   stdout=subprocess.DEVNULL)
    calls[name] = f"tremoloModel('{name}', '{base64.b64encode(light.read_bytes()).decode()}');\n"
    if name != there[0]:
        (out / "models" / f"{name}.js").write_text(calls[name])

engine = (out / "engine.inline.js").read_text()
renderer = (source / "page/renderer.js").read_text().replace("export ", "")
page = (source / "page/page.js").read_text().replace("const kFirst = 'horse';",
                                                     f"const kFirst = {json.dumps(there[0])};")
script = "\n".join([f"const tremoloModelNames = {json.dumps(there)};", calls[there[0]], engine,
                    renderer, page])
html = (source / "page/page.html").read_text().replace("/*SCRIPT*/", script)
(out / "index.html.partial").write_text(html)
(out / "index.html.partial").rename(out / "index.html")
print(f"{out / 'index.html'}: {len(html) / 1e6:.1f} MB, {len(there)} models")
