#!/bin/bash
# Installs what BUILD has into a stage, moves that elsewhere, and uses it as an outside project does:
# by CMake, by pkg-config, as a shared library, and as README.md says. MODEL: a basis file to run
# on. usage: run.sh BUILD MODEL
set -eu
build=$(realpath "$1") model=$(realpath "$2")
here=$(cd "$(dirname "$0")" && pwd)
readme=$here/../../README.md
stage=$build/consumer
rm -rf "$stage"
mkdir -p "$stage/readme"
fail() { printf 'consumer: %s\n' "$*" >&2; exit 1; }

cmake --install "$build" --prefix "$stage/installed" >"$stage/install.log"
mv "$stage/installed" "$stage/moved"  # the package does not know its location
moved=$stage/moved

# The program of README.md compiles without a warning and runs; without a model it says so.
by_cmake() {
  awk '/^```cpp$/ { inside = 1; next } /^```$/ { inside = 0 } inside' "$readme" >"$stage/readme.cpp"
  cmake -S "$here" -B "$stage/build" -DCMAKE_PREFIX_PATH="$moved" \
    -DREADME_PROGRAM="$(realpath "$stage/readme.cpp")" >/dev/null
  cmake --build "$stage/build" >/dev/null
  "$stage/build/vibrate" "$model"
  "$stage/build/vibrate_c" "$model"
  "$stage/build/vibrate_shared" "$model"
  local code=0
  (cd "$stage/readme" && "$stage/build/readme") 2>"$stage/readme/err" || code=$?
  [ $code = 1 ] || fail "README's program without mine.tremolo ends with $code"
  grep -q 'mine\.tremolo' "$stage/readme/err" || fail "README's program does not say what is missing"
  ln -s "$model" "$stage/readme/mine.tremolo"
  (cd "$stage/readme" && "$stage/build/readme") | grep '^[0-9.e+-]* J after 0\.6 s$'
}

# README's lines for C, as they stand there, and the same for C++.
by_pkg_config() {
  local library line count=0
  library=$(dirname "$(find "$moved" -name tremolo.pc)")/..
  export PKG_CONFIG_PATH=$library/pkgconfig
  cp "$here/vibrate_c.c" "$stage/readme/vibrate.c"
  while read -r line; do
    count=$((count + 1))
    (cd "$stage/readme" && eval "$line" && LD_LIBRARY_PATH=$library ./a.out "$model")
  done < <(sed -n 's/^    \(cc vibrate\.c .*pkg-config.*\)$/\1/p' "$readme")
  [ $count = 2 ] || fail "README has $count lines with pkg-config, not 2"
  # Both ways to include the headers go with both packages.
  printf '#include <%s>\n' tremolo/tremolo.h tremolo/tremolo_scene.h tremolo.h tremolo_scene.h \
    >"$stage/readme/both.c"
  for line in tremolo-c tremolo; do
    # shellcheck disable=SC2046
    cc -c "$stage/readme/both.c" $(pkg-config --cflags "$line") -o "$stage/readme/both.o" ||
      fail "the headers are not found with pkg-config --cflags $line"
  done
  # shellcheck disable=SC2046
  g++ -std=c++20 "$here/vibrate.cpp" $(pkg-config --cflags --libs --static tremolo) \
    -o "$stage/readme/vibrate"
  "$stage/readme/vibrate" "$model"
}

# It has a name with a version, exports what its four headers declare, and nothing else.
shared_library() {
  local library
  library=$(find "$moved" -name libtremolo.so)
  readelf -d "$library" | grep -q 'SONAME.*\[libtremolo\.so\.[0-9]*\.[0-9]*\]' ||
    fail "libtremolo.so has no soname with a version"
  nm -D --defined-only "$library" | sed -n 's/.* [A-Z] \([^@]*\)@.*/\1/p' | sort >"$stage/exported"
  nm -D --defined-only "$library" | grep -v ' T tremolo_' | grep -v ' A TREMOLO_[0-9.]*$' &&
    fail "libtremolo.so exports more than its interface"
  cat "$moved"/include/tremolo/tremolo{,_cloth,_tets,_scene}.h |
    sed 's|/\*.*\*/||' | sed 's|^ \*.*||' | grep -o '\btremolo_[a-z_]*(' | tr -d '(' |
    sort -u >"$stage/declared"
  [ -s "$stage/declared" ] || fail "no function was found in tremolo.h"
  diff "$stage/declared" "$stage/exported" || fail "tremolo.h and libtremolo.so differ"
}

# A tree in which one program was not built: the same script, given a program that does not exist.
left_out() {
  local program=$1 script=$stage/partial.cmake
  sed "s|/bin/$program\"|/bin/$program-not-built\"|g" "$build/cmake_install.cmake" >"$script"
  grep -q "$program-not-built" "$script" || fail "$program is not among what is installed"
  cmake -DCMAKE_INSTALL_PREFIX="$stage/partial" -P "$script" >"$stage/partial.log" 2>&1 ||
    { cat "$stage/partial.log" >&2; fail "install fails where $program was not built"; }
  grep -q "Left out, not built: $program " "$stage/partial.log" || fail "$program is left out in silence"
  [ -e "$stage/partial/bin/tremolo" ] || fail "the rest was not installed"
}

by_cmake
by_pkg_config
shared_library
left_out tremolo-precompute
