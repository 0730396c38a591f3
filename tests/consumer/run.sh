#!/bin/sh
# Installs the runtime from BUILD into a stage, builds the consumer against it, runs it on a basis
# file. usage: run.sh BUILD MODEL
set -eu
build=$1 model=$2
here=$(cd "$(dirname "$0")" && pwd)
stage=$build/consumer
rm -rf "$stage"
cmake --install "$build" --prefix "$stage/installed" >/dev/null
cmake -S "$here" -B "$stage/build" -DCMAKE_PREFIX_PATH="$stage/installed" >/dev/null
cmake --build "$stage/build" >/dev/null
"$stage/build/vibrate" "$model"
"$stage/build/vibrate_c" "$model"
