#!/usr/bin/env bash
# The package in node and the page in Chromium. usage: run.sh BUILD; exit 77 where a tool is missing.
set -eu
build=$(realpath "$1") here=$(dirname "$(realpath "$0")")
for tool in node npm emcmake; do
  command -v $tool >/dev/null || { echo "$tool is missing"; exit 77; }
done
cmake --build "$build" --target web
work=$build/web/tests
mkdir -p "$work"
cp "$here"/*.mjs "$here"/package.json "$work"
node "$work/engine_test.mjs" "$build/web/package" "$build/bin/tremolo" "$build/models/horse.tremolo" "$work"
chromium=$(command -v chromium || command -v chromium-headless-shell) || { echo "no chromium"; exit 77; }
(cd "$work" && npm install --silent --no-audit --no-fund) || { echo "npm's registry is out of reach"; exit 77; }
node "$work/page_test.mjs" "$build/web/index.html" "$chromium" "$work/photos"
