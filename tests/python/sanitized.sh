#!/bin/bash
# Builds the Python module under the address and undefined-behaviour sanitizers and runs its tests. The interpreter and
# the programs have none: libasan is loaded before them, and leaks are not looked for, of which Python has many.
#
# usage: tests/python/sanitized.sh [FOLDER_OF_PROGRAMS] [TEST...]; by default build/bin and all tests but those that
# start other interpreters. JOBS: of the build, 2 by default.
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
programs=$(realpath "${1:-$top/build/bin}")
shift || true
[ -x "$programs/tremolo-precompute" ] || { echo "$0: there is no tremolo-precompute in $programs" >&2; exit 2; }
build=$top/build/asan-python
cd "$top"
cmake --preset asan-full -B "$build" -G Ninja -DTREMOLO_BUILD_PRECOMPUTE=OFF -DTREMOLO_BUILD_MESHER=OFF \
  -DTREMOLO_BUILD_TESTS=OFF -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8 ${CMAKE_FLAGS:-} >/dev/null
ninja -C "$build" -j"${JOBS:-2}" tremolo_python
preload=
for library in asan stdc++; do preload+=:$("${CXX:-g++}" -print-file-name=lib$library.so); done
failed=0
for file in tests/python/*_test.py; do
  name=$(basename "$file" _test.py)
  case $name in package | notebooks) continue ;; esac
  [ $# = 0 ] || [[ " $* " == *" $name "* ]] || continue
  echo "== $name"
  # The programs are started without the library.
  env LD_PRELOAD="${preload#:}" ASAN_OPTIONS=detect_leaks=0:halt_on_error=1 UBSAN_OPTIONS=print_stacktrace=1 \
    PYTHONPATH="$build/python" PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg TREMOLO_BIN="$programs" \
    /usr/bin/python3 -X faulthandler "$file" || failed=1
done
exit $failed
