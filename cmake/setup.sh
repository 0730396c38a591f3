# Functions of ./demo and ./check: the packages they need, and the build.
# Source it from the top of the repository.

say() { printf '\n== %s\n' "$*"; }
give_up() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 1; }

packages_build="g++ cmake make ninja-build pkg-config libeigen3-dev libxxhash-dev libcli11-dev
  libtomlplusplus-dev nlohmann-json3-dev libfmt-dev libpugixml-dev libassimp-dev
  zlib1g-dev liblz4-dev
  libpetsc-real-dev libslepc-real-dev libopenmpi-dev openmpi-bin libmetis-dev libopenblas-dev
  libsuitesparse-dev"
packages_mesher="libcgal-dev"  # of tremolo-mesh alone
# Of tremolo-view alone; the last two draw without a graphics card.
packages_view="libglfw3-dev libimgui-dev libepoxy-dev libegl-dev libpng-dev libegl-mesa0 libgl1-mesa-dri"
# The three after the first contain surfaces for tests/corpus:
# 52 MB to download.
# Xvfb and xdotool are a display and a mouse for the window of tremolo-view, ffmpeg makes its films.
packages_test="libgtest-dev libcgal-demo assimp-testmodels glmark2-data xvfb xdotool ffmpeg"
# The Python module; the last six are of its tests, notebooks and wheel.
packages_python="python3-dev pybind11-dev python3-numpy python3-scipy python3-meshio python3-matplotlib mypy
  python3-pip python3-venv procps"
packages_fuzz="clang libclang-rt-14-dev"  # the fuzzers of ./check --full
# The add-on's tests and the readers of ./check --full; Blender needs numpy. 65 packages: 113 MB to download, 446 MB
# installed, a minute.
packages_blender="blender python3-numpy"
# Programs that read the files of `tremolo export`: ./check --full. An installed node or npm is kept.
packages_readers="python3-vtk9 $packages_blender"
# The engine in a page: ./demo --live, ./check --full.
packages_web="emscripten node-acorn"
packages_browser="chromium"
command -v node >/dev/null || packages_readers="$packages_readers nodejs"
command -v npm >/dev/null || packages_readers="$packages_readers npm"

# apt_get WORD...: apt-get as root, which prints only its errors. It waits, and says so, while another program
# holds a lock of apt (unattended-upgrades, or a second terminal).
apt_get() {
  local errors reported= root=()
  [ "$(id -u)" = 0 ] || root=(sudo)
  errors=$(mktemp)
  until "${root[@]}" env LC_ALL=C DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=0 -q=2 "$@" \
    >/dev/null 2>"$errors"; do
    if ! grep -qE 'Could not get lock|Unable to (lock|acquire)' "$errors"; then
      cat "$errors" >&2
      rm -f "$errors"
      return 1
    fi
    [ -n "$reported" ] || say "another program holds apt ($(grep -m 1 -E 'lock' "$errors")): waiting for it"
    reported=yes
    sleep 2
  done
  rm -f "$errors"
}

# need PACKAGE...: installs those that are missing.
need() {
  local missing=() package
  if ! command -v apt-get >/dev/null; then
    say "this is not a Debian system: not installing anything"
    printf 'Needed (names of Debian 12): %s\n' "$*"
    command -v cmake >/dev/null || give_up "cmake is missing; install the list above"
    return
  fi
  for package in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] ||
      missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  say "installing ${missing[*]}"
  [ "$(id -u)" = 0 ] || command -v sudo >/dev/null ||
    give_up "run as root, install sudo, or do: apt-get install --no-install-recommends ${missing[*]}"
  apt_get update || give_up "apt-get update failed: is the network there?"
  apt_get install -y --no-install-recommends "${missing[@]}" ||
    give_up "apt-get could not install ${missing[*]}"
}

# build PRESET [CONFIGURE OPTION]... [-- TARGET...]: configures and builds.
build() {
  local preset=$1 options=() targets=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
  [ $# -gt 0 ] && shift
  [ $# -gt 0 ] && targets=(--target "$@")
  say "building ($preset)"
  # A new tree compiles the files of a target by eights, which takes two thirds of the time. One that
  # was configured otherwise stays as it is.
  local fresh=() tree=build
  [ "$preset" = release ] || tree=build/$preset
  [ -e "$tree/CMakeCache.txt" ] ||
    fresh=(-G Ninja -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8)
  mkdir -p "$tree"
  cmake --preset "$preset" "${fresh[@]}" "${options[@]}" >"$tree/configure.log" 2>&1 ||
    { cat "$tree/configure.log" >&2; give_up "cmake could not configure"; }
  cmake --build --preset "$preset" --parallel "$(nproc)" "${targets[@]}" ||
    give_up "the build failed"
}

models="beam basket bridge horse tower heart"
scene_models="horse-free horse-rig heart-free basket-free ball-free bell finger domino"  # which scenes need
scene_colliders="bell basket heart horse"
scene_tets="bar bar-free duck mat"

# precompute MODEL: its basis file, unless it is newer than everything it is made of. The mesh is that of
# the name up to a hyphen: horse-free is another model of the horse.
precompute() {
  local name=$1 mesh=assets/meshes/${1%%-*}.msh out=build/models/$1.tremolo log=build/models/$1.log source
  local sources=($mesh assets/models/$name.toml build/bin/tremolo-precompute)
  mkdir -p build/models
  if [ -e "$out" ] && [ -e "$log" ]; then
    for source in "${sources[@]}"; do [ "$source" -nt "$out" ] && break; source=; done
    [ -z "$source" ] && return
  fi
  build/bin/tremolo-precompute "$mesh" --config "assets/models/$name.toml" \
    -o "$out" 2>"$log" || { cat "$log" >&2; give_up "the precompute of $name failed"; }
}

# make_collider MESH: makes the file of distances of its boundary, unless it is newer.
make_collider() {
  local mesh=assets/meshes/$1.msh out=build/models/$1.collider
  mkdir -p build/models
  [ -e "$out" ] && [ ! "$mesh" -nt "$out" ] && [ ! build/bin/tremolo-precompute -nt "$out" ] && return
  build/bin/tremolo-precompute collider "$mesh" -o "$out" 2>"build/models/$1.collider.log" ||
    { cat "build/models/$1.collider.log" >&2; give_up "the collider of $1 failed"; }
}

# make_tets MESH: makes the file of tetrahedra for a body of kind "tets", unless it is newer. A recipe first draws
# its surface.
make_tets() {
  local mesh=assets/meshes/${1%%-*}.msh config=assets/models/$1-tets.toml out=build/models/$1.tets source
  local recipe=assets/recipes/${1%%-*}.awk
  mkdir -p build/models
  if [ -e "$out" ]; then
    for source in "$mesh" "$config" "$recipe" build/bin/tremolo-precompute; do [ "$source" -nt "$out" ] && break; source=; done
    [ -z "$source" ] && return
  fi
  grep -q '^render' "$config" && awk -v part=surface -v n=30 -f "$recipe" >"build/models/$1.ply"
  build/bin/tremolo-precompute tets "$mesh" --config "$config" -o "$out" 2>"build/models/$1.tets.log" ||
    { cat "build/models/$1.tets.log" >&2; give_up "the file of tetrahedra of $1 failed"; }
}

# MPI refuses to start more ranks than cores, or as root, without permission.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
