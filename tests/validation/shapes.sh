#!/usr/bin/env bash
# Cases in which linear elements lock, with linear and quadratic ones side by side, for any ORDER: a
# thin square plate clamped at its four edges, a hoop (a thin curved shell, free), and slender
# cantilevers that can hardly be compressed. Lowest frequencies against published ones and closed
# forms. Quadratic elements have a criterion; the error of linear ones is printed. Every run leaves
# a row in OUT/shapes/points.tsv for tests/charts/orders.py: body, order, cells, dofs, seconds,
# error.
. "$(dirname "$0")/lib.sh"

points=$out/points.tsv
: >"$points"

# block NAME NX NY NZ SIZE [RADIUS]: OUT/NAME.veg, unless it is there (block.awk).
block() { make_mesh "$1" block "nx=$2" "ny=$3" "nz=$4" "size=$5" "radius=${6-0}"; }

# lowest BODY MESH CELLS ORDER UNIT EXPECTED ARGUMENTS...: the first frequency in that unit, Hz, and
# its row among the points.
lowest() {
  local body=$1 mesh=$2 cells=$3 elements=$4 unit=$5 expected=$6 log seconds
  shift 6
  log=${mesh}_${body// /_}_$elements
  ORDER=$elements run "$log" tremolo-precompute "$out/$mesh.veg" -o "$out/$log.tremolo" --linear \
    --linear-modes 4 --density 1000 --young 1e6 "$@" --json
  first=$(calc "$(field "$log" frequencies_hz | cut -d' ' -f1) / $unit")
  seconds=$(awk '$1 == "total" { print $2 }' "$out/$log.log")
  printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$body" "$elements" "$cells" "$(field "$log" dofs)" "$seconds" \
    "$(calc "$first / $expected - 1")" >>"$points"
}

# study BODY WHAT CELLS... -- BOUND UNIT EXPECTED ARGUMENTS...: meshes OUT/MESH_CELLS; the finest
# with quadratic elements is judged, in per cent.
study() {
  local body=$1 mesh=$2 levels=()
  shift 2
  while [ "$1" != -- ]; do levels+=("$1"); shift; done
  local bound=$2 unit=$3 expected=$4 n
  shift 4
  for n in "${levels[@]}"; do
    lowest "$body" "${mesh}_$n" "$n" 1 "$unit" "$expected" "$@"
    shown "$body, $n cells, linear" "$(percent "($first / $expected - 1)") off"
    lowest "$body" "${mesh}_$n" "$n" 2 "$unit" "$expected" "$@"
    [ "$n" = "${levels[-1]}" ] ||
      shown "$body, $n cells, quadratic" "$(percent "($first / $expected - 1)") off"
  done
  within "$body, $n cells, quadratic" "$first" "$expected" "$bound"
}

plate="8 16 32" hoop="24 48 96" bar="20 40 80"
bounds=(1 1 1)  # per cent: plate, hoop, bar
[ -n "$short" ] && plate="8 16" hoop="24 48" bar="20 40" bounds=(4 1 3)

# sqrt(D / (rho h)) / a^2 / 2 pi, D = E h^3 / (12 (1 - nu^2)); a = 1, h = 0.01.
for n in $plate; do block "plate_$n" "$n" "$n" 1 "1 1 0.01"; done
study plate plate $plate -- "${bounds[0]}" \
  "$(calc 'sqrt(1e6 * 0.01 ^ 2 / (12 * 0.91 * 1000)) / (2 * atan2(0, -1))')" \
  "$(published 'clamped plate')" --poisson 0.3 --fix 'x<1e-9' --fix 'x>0.999999' --fix 'y<1e-9' \
  --fix 'y>0.999999'

# sqrt(E I / (rho A)) / R^2 / 2 pi, I / A = t^2 / 12; R = 1, t = 0.02; two modes of two waves.
for n in $hoop; do block "hoop_$n" "$n" 2 1 "1 0.2 0.02" 1; done
study hoop hoop $hoop -- "${bounds[1]}" "$(calc 'sqrt(1e6 * 0.02 ^ 2 / 12 / 1000) / (2 * atan2(0, -1))')" \
  "$(published 'ring of two waves')" --poisson 0 --fix none

# sqrt(E I / (rho A)) / L^2 / 2 pi; L = 1, h = 0.02 along z, 0.03 across; a cell in 20 across.
for n in $bar; do block "bar_$n" "$n" $((n / 20)) $((n / 20)) "1 0.03 0.02"; done
for nu in 0.3 0.49 0.499; do
  study "bar, nu $nu" bar $bar -- "${bounds[2]}" \
    "$(calc 'sqrt(1e6 * 0.02 ^ 2 / 12 / 1000) / (2 * atan2(0, -1))')" \
    "$(published 'cantilever mode 1')" --poisson $nu --fix 'x<1e-9'
done
finish
