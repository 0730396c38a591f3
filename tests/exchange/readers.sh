#!/usr/bin/env bash
# What `tremolo export` writes of the sample models and scenes, read by programs that others wrote:
# Khronos's glTF validator and three.js, by node; with --long also VTK and Blender.
#
#     tests/exchange/readers.sh BIN MODELS WORK [--long]
#
# BIN: the programs; MODELS: the sample models, with the scenes two folders above them (build/models).
# WORK: a folder for what is written. Exit code 77 where node or npm's registry is not to be had; what
# --long asks for is skipped with a word where it is not installed.
set -eu
[ $# -ge 3 ] || { echo "usage: $0 BIN MODELS WORK [--long]" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
tremolo=$(cd "$1" && pwd)/tremolo models=$(cd "$2" && pwd) long=${4-}
mkdir -p "$3"
work=$(cd "$3" && pwd)
scenes=$(cd "$here/../../assets/scenes" && pwd)

for program in node npm; do
  command -v $program >/dev/null || { echo "skipped: no $program"; exit 77; }
done
mkdir -p "$work/npm"
cp "$here/package.json" "$work/npm/"
if ! timeout 120 npm install --prefix "$work/npm" --no-audit --no-fund --silent >"$work/npm.log" 2>&1; then
  # What an earlier run has loaded will do.
  if ! [ -e "$work/npm/node_modules/three/package.json" ] ||
     ! [ -e "$work/npm/node_modules/gltf-validator/package.json" ]; then
    echo "skipped: npm's registry cannot be reached ($work/npm.log)"
    exit 77
  fi
fi
modules=$work/npm/node_modules

# Scenes name their models relative to themselves, in build/models: others are read as copies.
relocated() {
  sed "s#\"../../build/models/#\"$models/#" "$scenes/$1.toml" >"$work/$1.toml"
  cp "$scenes"/*.csv "$work/"
  echo "$work/$1.toml"
}

# Ten steps from frame to frame, so that a frame of PC2 is at the time of a surface.
times="--step 0.0025 --duration 1"
exported() {  # NAME FILE: all formats and the run that they are compared with
  rm -rf "$work/$1-run"
  "$tremolo" run "$2" $times --surfaces 4 --out "$work/$1-run" 2>/dev/null
  "$tremolo" export "$2" $times --rate 40 --glb "$work/$1.glb" --pc2 "$work/$1.pc2" \
    --mdd "$work/$1.mdd" --pvd "$work/$1.pvd" --usda "$work/$1.usda" >"$work/$1.log" 2>&1 ||
    { cat "$work/$1.log" >&2; exit 1; }
}
exported horse "$models/horse.tremolo"
exported heart "$models/heart.tremolo"
exported tumbling "$(relocated tumbling)"
exported dropped-heart "$(relocated dropped-heart)"
exported bells "$(relocated bells)"
exported walking-horse "$(relocated walking-horse)"

# The size that ten seconds of the heart may have.
"$tremolo" export "$models/heart.tremolo" --duration 10 --rate 60 --glb "$work/ten.glb" --json \
  >"$work/ten.json" 2>/dev/null
node -e '
  const file = JSON.parse(require("fs").readFileSync(process.argv[1])).files[0];
  const floats = 24 * file.vertices * (file.targets + 1) + 4 * file.targets * 601;
  console.log(`ten.glb: ${file.bytes} bytes, ${(file.bytes / floats).toFixed(3)} of its numbers`);
  process.exit(file.targets === 30 && file.bytes <= 1.3 * floats ? 0 : 1);' "$work/ten.json"

node "$here/validate.mjs" "$modules" "$work"/*.glb

# NAME BODY FOLDER-OF-THE-RUN. The tolerance is of the body's size or, if that is more, of its distance from
# the origin: floats know seven digits of a place.
compared() {
  node "$here/three_positions.mjs" "$modules" "$work/$1.glb" "$2" "$work/$1-run/$3" 5e-7
  node "$here/usda_positions.mjs" "$modules" "$work/$1.usda" "${2//-/_}" "$work/$1-run/$3" 5e-7
}
compared horse horse ""
compared heart heart ""
compared tumbling horse horse
compared dropped-heart heart heart
compared bells bell-1 bell-1
compared bells ball-2 ball-2
# three.js reads four bones a vertex, the mane has five: the .glb is Blender's to read.
node "$here/usda_positions.mjs" "$modules" "$work/walking-horse.usda" horse "$work/walking-horse-run/horse" 5e-7

[ "$long" = --long ] || exit 0
if /usr/bin/python3 -c 'import vtkmodules' 2>/dev/null; then
  /usr/bin/python3 "$here/vtk_positions.py" "$work/horse.pvd" horse "$work/horse-run" 5e-7
  /usr/bin/python3 "$here/vtk_positions.py" "$work/bells.pvd" ball-2 "$work/bells-run/ball-2" 5e-7
  /usr/bin/python3 "$here/vtk_positions.py" "$work/walking-horse.pvd" horse "$work/walking-horse-run/horse" 5e-7
else
  echo "skipped: no VTK (python3-vtk9)"
fi
if command -v blender >/dev/null; then
  in_blender() {  # FILE BODY RUN
    blender -b --python-exit-code 1 --python "$here/blender_positions.py" -- "$work/$1" "$2" \
      "$work/$3" 40 2e-6 >"$work/blender.log" 2>&1 || { tail -n 20 "$work/blender.log" >&2; exit 1; }
    grep -E 'Blender has|SKIPPED' "$work/blender.log"
  }
  for file in horse.glb horse.pc2 horse.mdd horse.usda; do in_blender $file horse horse-run; done
  in_blender heart.glb heart heart-run
  in_blender tumbling.glb horse tumbling-run/horse
  in_blender dropped-heart.glb heart dropped-heart-run/heart
  in_blender walking-horse.glb horse walking-horse-run/horse
  for body in bell-1 bell-2 ball-2; do in_blender bells.glb $body bells-run/$body; done
  in_blender bells-bell-2.mdd bells-bell-2 bells-run/bell-2
else
  echo "skipped: no blender"
fi
