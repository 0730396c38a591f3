#!/usr/bin/env bash
# A page with a recorded motion in Chromium; the package in node and the live page in Chromium.
# usage: run.sh BUILD [--film]; --film: the page with a recorded motion alone. Exit 77 where a tool is
# missing.
set -eu
build=$(realpath "$1") here=$(dirname "$(realpath "$0")")
for tool in node npm; do
  command -v $tool >/dev/null || { echo "$tool is missing"; exit 77; }
done
work=$build/web/tests
mkdir -p "$work"
cp "$here"/*.mjs "$here"/package.json "$work"
chromium=$(command -v chromium || command -v chromium-headless-shell) || { echo "no chromium"; exit 77; }
(cd "$work" && npm install --silent --no-audit --no-fund) || { echo "npm's registry is out of reach"; exit 77; }

# The page of ./demo: every second step of three seconds, and two runs.
horse="$build/models/horse.tremolo --duration 3 --load sine"
for method in imexv newmark; do
  "$build/bin/tremolo" run $horse --integrator $method --out "$work/film/$method" --surfaces 4 --surface-format obj >/dev/null
done
"$build/bin/tremolo" export $horse --integrator imexv --rate 166.66666667 --page "$work/film.html" \
  --runs "$work/film/imexv" --runs "$work/film/newmark" --note "A note with \`code\`."
node "$work/film_test.mjs" "$work/film.html" "$chromium" "$work/photos" "$work/film/imexv"
[ "${2-}" != --film ] || exit 0

command -v emcmake >/dev/null || { echo "emcmake is missing"; exit 77; }
cmake --build "$build" --target web
node "$work/engine_test.mjs" "$build/web/package" "$build/bin/tremolo" "$build/models/horse.tremolo" "$work"
node "$work/scene_test.mjs" "$build/web/package" "$build/bin/tremolo" "$build/models" "$work"
# Damaged files, as far as an engine without checksums lets them in; what the fuzzer has learned of
# basis files, where it has run.
cmake --build "$build" --target web_engine_unchecked
mkdir -p "$work/unchecked"
cp "$build/web/engine-unchecked/bin/engine.wasm" "$build"/web/package/{tremolo,engine}.mjs "$work/unchecked"
node "$work/corpus_test.mjs" "$work/unchecked" "$here/../formats/golden" "$build"/fuzz/learned*/model
node "$work/page_test.mjs" "$build/web/index.html" "$chromium" "$work/photos"
# The page of ./demo --live.
mkdir -p "$work/live/models"
cp "$build/web/index.html" "$work/live/live.html"
cp "$build"/web/models/*.js "$work/live/models"
"$build/bin/tremolo" export $horse --integrator imexv --page "$work/live/index.html" --live live.html
node "$work/live_test.mjs" "$work/live/index.html" "$chromium" "$work/photos"
