#!/usr/bin/env bash
# Reduction error and integration error side by side, against the number of coordinates r.
#
#   tests/bench/error_against_r.sh BIN OUT [MODEL...]
#
# BIN: the folder of tremolo and tremolo-precompute; models: all six samples unless named. For each
# model a basis is made for each r (k = r/2 linear modes, at least 3, at most 24: a prefix of one
# large basis is not a small basis), and for its default load as impulse, square and sine
#   reduction    max |u - Uq| / max |u| in the M norm: the whole mesh against the reduced model, both
#                by the same steps of the averaged vector field;
#   projection   the same for the best q; tip: |u - Uq| where the load acts;
#   integration  max |q - q'| / max |q'|: ep4 and newmark at their step against ep4 at a fifteenth.
# OUT/MODEL.csv stores finished results, so a second start continues. Then tremolo-lab makes
# OUT/error.csv, OUT/table.md and OUT/error-against-r.html (.png, if Chromium is installed) from all
# results.
#
# Environment: ELEMENTS (1: order of the elements; with 2 the whole mesh's motion takes hours),
# DERIVATIVES (3: up to which order), ORDERS (of the basis, r: 5 10 15 20 30 40 60), TARGET (0.02: a basis of --target-error beside them; empty:
# none), STEP (0.003 s), DURATION (0.45 s), THREADS (1).
set -euo pipefail

bin=${1:?usage: error_against_r.sh BIN OUT [MODEL...]}
out=${2:?usage: error_against_r.sh BIN OUT [MODEL...]}
shift 2
models=${*:-beam horse heart bridge basket tower}
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/bench/readers.sh"
orders=${ORDERS:-5 10 15 20 30 40 60}
target=${TARGET-0.02} elements=${ELEMENTS:-1} derivatives=${DERIVATIVES:-3}
step=${STEP:-0.003} duration=${DURATION:-0.45} threads=${THREADS:-1}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mkdir -p "$out"

simulate() { # FILE LOAD INTEGRATOR PARTS FOLDER: steps of STEP / PARTS
  local r coordinates=()
  rm -f "$5/run.csv"
  r=$(field "$1" r)
  for ((i = 0; i < r; i++)); do coordinates+=(--coordinate "$i"); done
  "$bin/tremolo" run "$1" --load "$2" --integrator "$3" --tolerance 1e-9 --out "$5" \
    --step "$(awk -v h="$step" -v n="$4" 'BEGIN { printf "%.17g", h / n }')" --every "$4" \
    --duration "$duration" "${coordinates[@]}" --json > "$5.json" 2> "$5.log" ||
    rm -f "$5/run.csv"
}

# The numbers of a file, as the reference printed them.
reduction_of() { # FILE JSON
  awk -v file="$1" '
    index($0, "\"" file "\"") { inside = 1 }
    inside && match($0, /"[a-z_]+": *[^,]*/) {
      split(substr($0, RSTART + 1, RLENGTH - 1), part, /": */); value[part[1]] = part[2] }
    /}/ { inside = 0 }
    function number(name) { return value[name] ~ /^[-0-9]/ ? sprintf("%.6g", value[name]) : "" }
    END { printf "%s,%s,%s,%s", number("error_of_largest"), number("projection_of_largest"),
          number("tip_error_of_largest"), number("load_unseen") }' "$2"
}

make_basis() { # MODEL NAME OPTIONS...
  local model=$1 file=$out/work-$1/$2.tremolo
  shift 2
  [ -s "$file" ] || "$bin/tremolo-precompute" "$root/assets/meshes/$model.msh" \
    --config "$root/assets/models/$model.toml" "$@" --order "$elements" \
    --derivatives "$derivatives" --no-certify --threads "$threads" \
    -o "$file" 2> "${file%.tremolo}.log"
}

study() { # MODEL
  local model=$1 work=$out/work-$1 table=$out/$1.csv names=()
  mkdir -p "$work"
  [ -s "$table" ] ||
    echo "model,load,r,k,reduction,projection,tip,unseen,ep4,newmark,basis" > "$table"
  for r in $orders; do
    local k=$(((r + 1) / 2))
    k=$((k < 3 ? 3 : k > 24 ? 24 : k))
    make_basis "$model" "$r" --linear-modes "$k" --modes "$r" --keep-modes 0
    names+=("$r")
  done
  if [ -n "$target" ]; then
    # A target that is missed leaves no file.
    if make_basis "$model" "target-$target" --target-error "$target"; then
      names+=("target-$target")
    else
      tail -n 1 "$work/target-$target.log" >&2
    fi
  fi
  for load in impulse square sine; do
    local compare=() pending=()
    for name in "${names[@]}"; do
      grep -q "^$model,$load,.*,$name\$" "$table" && continue
      pending+=("$name")
      compare+=(--compare "$work/$name.tremolo")
    done
    [ ${#pending[@]} -gt 0 ] || continue
    # Code 4: one of the reduced models failed; the others are printed.
    "$bin/tremolo-precompute" reference "$root/assets/meshes/$model.msh" \
      --config "$root/assets/models/$model.toml" --order "$elements" --integrator avf --load "$load" --step "$step" \
      --duration "$duration" --threads "$threads" "${compare[@]}" --out "$work/$load" --json \
      > "$work/$load.json" 2> "$work/$load.log" || [ $? = 4 ]
    local rows=() file
    for name in "${pending[@]}"; do
      file=$work/$name.tremolo
      for method in ep4 newmark; do simulate "$file" "$load" "$method" 1 "$work/$method"; done
      simulate "$file" "$load" ep4 15 "$work/fine"
      rows+=("$model,$load,$(field "$file" r),$(field "$file" linear_modes),$(
        reduction_of "$file" "$work/$load.json"),$(
        distance "$work/ep4/run.csv" "$work/fine/run.csv"),$(
        distance "$work/newmark/run.csv" "$work/fine/run.csv"),$name")
    done
    printf '%s\n' "${rows[@]}" >> "$table"
  done
}

for model in $models; do study "$model"; done

# Only tables that there are: awk ends at the first file that it cannot open.
tables=()
for model in beam horse heart bridge basket tower; do
  [ ! -s "$out/$model.csv" ] || tables+=("$out/$model.csv")
done
awk 'FNR > 1 || NR == 1' "${tables[@]}" > "$out/error.csv"

# One row a model and load: reduction and integration (ep4) in per cent, a column for each r.
awk -F, '
  function percent(x) { return x == "" ? "-" : sprintf("%.2g", 100 * x) }
  NR == 1 { next }
  { if (!($11 in seen)) { seen[$11] = 1; order[++orders] = $11 }
    key = $1 " | " $2; if (!(key in known)) { known[key] = 1; keys[++count] = key }
    cell[key, $11] = percent($5) " / " percent($9)
    if ($11 ~ /^target/) cell[key, $11] = cell[key, $11] ", r = " $3 }
  END {
    printf "| model | load |"
    for (i = 1; i <= orders; i++) printf order[i] ~ /^target/ ? " %s |" : " r = %s |", order[i]
    printf "\n|---|---|"; for (i = 1; i <= orders; i++) printf "---|"; print ""
    for (n = 1; n <= count; n++) {
      printf "| %s |", keys[n]
      for (i = 1; i <= orders; i++) printf " %s |", cell[keys[n], order[i]]
      print "" } }' "$out/error.csv" > "$out/table.md"

# Two panels a load: what the basis leaves out, what the step leaves out.
[ -x "$bin/tremolo-lab" ] || { echo "no $bin/tremolo-lab: no page" >&2; exit 0; }
"$root/tests/charts/error_against_r.py" "$bin" "$out/error.csv" "$out/error-against-r.html" "$out/error-against-r.png"
