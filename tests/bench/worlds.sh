#!/bin/sh
# What a step costs a body in worlds of many free bodies on a floor (docs/performance.md, "Worlds").
#
# worlds.sh [TREMOLO [MODEL]]: rows of balls fall 2 cm on a floor, each by itself, for N = 10, 100 and
# 1 000; then the same for so long that they sleep, 27 in a heap, and 1 000 by two threads (time by
# the clock).
set -eu
tremolo=${1:-build/bin/tremolo}
model=$(realpath "${2:-build/models/ball-free.tremolo}")
dir=$(mktemp -d)
trap 'rm -r "$dir"' EXIT

# scene COPIES SPACING DURATION
scene() {
  cat <<S
duration = $3
step = 0.003
gravity = [0, 0, -9.81]
[[bodies]]
name = "ball"
model = "$model"
kind = "free"
copies = $1
spacing = $2
position = [0, 0, 0.05]
beta = 0.0004
shape = "sphere"
radius = 0.03
random-turns = true
contact-points = 60
[[colliders]]
name = "floor"
shape = "plane"
S
}

# value KEY FILE: of the world, not of a body
value() { sed -n "s/^  \"$1\": \([^,]*\),*\$/\1/p" "$2" | head -n 1; }

# measure NAME BODIES COPIES SPACING DURATION [THREADS]
measure() {
  scene "$3" "$4" "$5" >"$dir/world.toml"
  "$tremolo" run "$dir/world.toml" --threads "${6:-1}" --json >"$dir/report.json" 2>"$dir/log" || { cat "$dir/log" >&2; exit 1; }
  step=$(value microseconds_per_step "$dir/report.json")
  asleep=$(grep -c '"asleep": true' "$dir/report.json" || true)
  awk -v name="$1" -v n="$2" -v step="$step" -v asleep="$asleep" -v balance="$(value energy_balance_error "$dir/report.json")" \
    'BEGIN { printf "| %s | %d | %.3g | %.3g | %d | %.1e |\n", name, n, step, step / n, asleep, balance }'
}

echo "| world | bodies | us a step | us a body | asleep at the end | energy balance |"
echo "|---|---:|---:|---:|---:|---:|"
measure "falling and rebounding, 0.6 s" 10 "[10, 1, 1]" "[0.1, 0.1, 0.1]" 0.6
measure "falling and rebounding, 0.6 s" 100 "[10, 10, 1]" "[0.1, 0.1, 0.1]" 0.6
measure "falling and rebounding, 0.6 s" 1000 "[40, 25, 1]" "[0.1, 0.1, 0.1]" 0.6
measure "the same, 9 s" 1000 "[40, 25, 1]" "[0.1, 0.1, 0.1]" 9
measure "the same, 6 s" 100 "[10, 10, 1]" "[0.1, 0.1, 0.1]" 6
measure "the same, 27 s" 100 "[10, 10, 1]" "[0.1, 0.1, 0.1]" 27
measure "a heap, 1.5 s" 27 "[3, 3, 3]" "[0.062, 0.061, 0.065]" 1.5
measure "falling and rebounding, 0.6 s, two threads" 1000 "[40, 25, 1]" "[0.1, 0.1, 0.1]" 0.6 2
