#!/usr/bin/env bash
# How long the precompute takes, stage by stage, beside the shortest time each stage could take.
#
#   tests/bench/precompute.sh BIN/tremolo-precompute [--large | --quadratic] [--threads N]
#
# Makes a beam of 30 000 linear tetrahedra (with --large: of 507 000), runs 20 modes, 210 derivatives, 30
# coordinates, and prints the stages, then wall time (start-up included), processor time and peak
# memory beside what must be reached: 4.5 s; 60 s and 6 GB. Then the same as a compact file: all its
# bytes beside those of a textbook's f64 tables (394 290 numbers at r = 30) and a full f64 basis, and
# how far off its displacements are: at most 1/4, 1e-4 of the size. Exit code 6 when something is
# missed; the machine should be idle.
#
# --quadratic: quadratic elements beside as many dofs of linear ones, by turns in one run, three times:
# the horse (18 616 tetrahedra, 90 975 dofs) and, linear, the mesh that --refine makes of it, r = 20. Of
# processor time (the least of three) at most 1.6 times the linear precompute's, of its stage
# `coefficients` at most twice, and 1.5 GB. Then 300 000 dofs of a quadratic beam in at most 120 s.
set -euo pipefail

program=${1:?usage: precompute.sh BIN/tremolo-precompute [--large | --quadratic] [--threads N]}
shift
cells="50 10 10 1.0 0.2 0.2" most_seconds=4.5 most_megabytes=6000 threads=2 order=1 quadratic=
while [ $# -gt 0 ]; do
  case $1 in
    --large) cells="130 26 25 5.2 1.0 1.0" most_seconds=60 ;;
    --quadratic) cells="69 13 13 5.2 1.0 1.01" most_seconds=120 quadratic=yes ;;
    --threads) threads=$2; shift ;;
    *) echo "precompute.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift
done
code=0
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

awk -v cells="$cells" -f "$(dirname "$0")/beam.awk" > "$folder/beam.veg"

# As root, Open MPI needs explicit permission.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
unset OPENBLAS_CORETYPE
echo "load before: $(cut -d' ' -f1 /proc/loadavg)"
run() {
  "$program" "$folder/beam.veg" -o "$folder/beam.tremolo" --fix 'x<0.001' --order $order \
    --threads "$threads" "$@"
}

# horse NAME OPTIONS...: appends the run's stages to FOLDER/NAME.
horse() {
  local name=$1 assets
  assets=$(dirname "$0")/../../assets
  shift
  "$program" "$assets/meshes/horse.msh" --config "$assets/models/horse.toml" --derivatives 2 \
    --linear-modes 20 --modes 20 --threads "$threads" -o "$folder/horse.tremolo" "$@" 2>>"$folder/$name"
}
# least NAME STAGE COLUMN: of the stage in all runs; columns 2, 4, 7 are seconds, processor seconds, MB.
least() {
  awk -v stage="$2" -v c="$3" '$1 == stage && (!n++ || $c < low) { low = $c } END { print low }' "$folder/$1"
}
compare_orders() {
  local stage
  for _ in 1 2 3; do
    horse linear --order 1 --refine 1
    horse quadratic --order 2
  done
  grep -h '^ *matrices' "$folder/linear" "$folder/quadratic" | awk '!seen[$8 $9 $10]++'
  for stage in mesh matrices modes derivatives certificate basis coefficients file total; do
    echo "$stage $(least linear $stage 4) $(least quadratic $stage 4) $(least quadratic $stage 7)"
  done | awk '
    { ratio[$1] = $2 > 0 ? $3 / $2 : 0; peak = $4
      printf "%-13s linear %6.2f s, quadratic %6.2f s of processor time: %.2f\n", $1, $2, $3, ratio[$1] }
    END {
      met = ratio["total"] <= 1.6 && ratio["coefficients"] <= 2 && peak <= 1500
      printf "in all %.2f (at most 1.6), coefficients %.2f (at most 2), %d MB (at most 1500): %s\n",
             ratio["total"], ratio["coefficients"], peak, met ? "met" : "MISSED"
      exit met ? 0 : 6 }'
}
if [ -n "$quadratic" ]; then
  compare_orders || code=$?
  order=2
fi
# The timed run does not measure the machine.
TIMEFORMAT='%R %U %S'
{ time run 2> "$folder/stages"; } 2> "$folder/time"
if [ -n "$quadratic" ]; then cat "$folder/stages"; else run --limits; fi
peak=$(awk '$1 == "total" {print $(NF - 1)}' "$folder/stages")
read -r wall user system < "$folder/time"
awk -v wall="$wall" -v user="$user" -v sys="$system" -v peak="$peak" -v s="$most_seconds" \
    -v m="$most_megabytes" 'BEGIN {
  met = wall <= s && peak <= m
  printf "wall %.2f s (at most %g), processor %.2f s, peak %.0f MB (at most %g): %s\n",
         wall, s, user + sys, peak, m, met ? "met" : "MISSED"
  exit met ? 0 : 6
}' || code=$?
[ -z "$quadratic" ] || exit "$code"

run --encoding compact --json > "$folder/json" 2>/dev/null
field() { sed -n "s/^ *\"$1\": *\([0-9.e+-]*\),\{0,1\}\$/\1/p" "$folder/json" | head -n 1; }
awk -v file="$(stat -c %s "$folder/beam.tremolo")" -v n="$(field n)" -v r="$(field r)" \
    -v error="$(field displacement_error_bound)" 'BEGIN {
  full = 8 * (394290 + 3 * n * r)
  met = file <= full / 4 && error <= 1e-4
  printf "compact file %d bytes of %d = %.3f (at most 0.25), displacement off by at most %.1e " \
         "(at most 1e-4) of the size: %s\n", file, full, file / full, error, met ? "met" : "MISSED"
  exit met ? 0 : 6
}' || code=$?
exit "$code"
