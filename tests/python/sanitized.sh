#!/bin/bash
# Builds the Python module under the address and undefined-behaviour sanitizers and runs its tests. The interpreter and
# the programs have none: libasan is loaded before them, and leaks are not looked for, of which Python has many.
#
# usage: tests/python/sanitized.sh [--module-alone] [TEST...]; by default all tests but those that start other
# interpreters. --module-alone: the engine in it is that of a release, which is faster to build. Environment:
# TREMOLO_BIN: the folder of the programs, build/bin by default; JOBS: of the build, 2; CMAKE_FLAGS: further ones.
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
cd "$top"
programs=$(realpath "${TREMOLO_BIN:-build/bin}")
[ -x "$programs/tremolo-precompute" ] || { echo "$0: there is no tremolo-precompute in $programs" >&2; exit 2; }
if [ "${1:-}" = --module-alone ]; then
  shift
  build=build/asan-module configure=(--preset release -DTREMOLO_SANITIZE_PYTHON=ON)
else
  build=build/asan-python configure=(--preset asan-full -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8)
fi
# shellcheck disable=SC2086
cmake "${configure[@]}" -B "$build" -G Ninja -DTREMOLO_BUILD_PRECOMPUTE=OFF -DTREMOLO_BUILD_MESHER=OFF \
  -DTREMOLO_BUILD_TESTS=OFF ${CMAKE_FLAGS:-} >/dev/null
ninja -C "$build" -j"${JOBS:-2}" tremolo_python
preload=
for library in asan stdc++; do preload+=:$("${CXX:-g++}" -print-file-name=lib$library.so); done
failed=0
for file in tests/python/*_test.py; do
  name=$(basename "$file" _test.py)
  case $name in package | notebooks) continue ;; esac
  [ $# = 0 ] || [[ " $* " == *" $name "* ]] || continue
  echo "== $name"
  env LD_PRELOAD="${preload#:}" ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1 \
    PYTHONPATH="$top/$build/python" PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg TREMOLO_BIN="$programs" \
    /usr/bin/python3 -X faulthandler "$file" || failed=1
done
exit $failed
