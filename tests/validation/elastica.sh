#!/usr/bin/env bash
# A slender cantilever (L/h = 50, nu = 0) under a load across its end that keeps its direction: how
# far the end is drawn in (u) and deflected (w), against Mattiasson's table of the inextensible
# elastica, for P L^2 / EI = 1, 2, 5, 10; and the reduced model against the full one.
. "$(dirname "$0")/lib.sh"

cells="4 8 16" fine_bound=1 limit_bound=0.3 loads="1 2 5 10"
[ -n "$short" ] && cells="2 4 8" fine_bound=4 limit_bound=2 loads="5"
young=1e7 width=0.4 height=0.02
clamped="--young $young --poisson 0 --fix x<1e-9"
pushed="--static --load-at x>0.9999999 --probe near:1,0.01,0 --json"
force() { calc "$1 * $young * $width * $height ^ 3 / 12"; }

for load in $loads; do
  u=() w=()
  for n in $cells; do
    strip "strip_$n" $((50 * n)) "$n" "0 1 0 $height" $width
    # shellcheck disable=SC2086
    run "full_${n}_$load" tremolo-precompute reference "$out/strip_$n.veg" $clamped $pushed \
      --fix-z 'z>=0%' --load-force "0,$(force "$load"),0"
    read -r x y _ <<<"$(field "full_${n}_$load" displacement)"
    u+=("$(calc "-($x)")") w+=("$y")
  done
  # Half a unit of the table's last digit is at most 0.009 %.
  within "P = $load: w/L, elliptic integrals" "$(calc "elastica_w($load)")" "$(published "w $load")" 0.01
  within "P = $load: u/L, elliptic integrals" "$(calc "elastica_u($load)")" "$(published "u $load")" 0.01
  within "P = $load: w/L, $n cells" "${w[2]}" "$(published "w $load")" $fine_bound
  within "P = $load: u/L, $n cells" "${u[2]}" "$(published "u $load")" "$(calc "2 * $fine_bound")"
  within "P = $load: w/L, refined" "$(refined "${w[@]}")" "$(published "w $load")" $limit_bound
  within "P = $load: u/L, refined" "$(refined "${u[@]}")" "$(published "u $load")" $limit_bound
  orderly "P = $load: w/L, order" "$(order "${w[@]}")" 1.7 2.1
done

# reduced PREFIX MESH LOADS K R: rows, how far the reduced model's shape is off the full one's.
reduced() {
  local prefix=$1 mesh=$2 loads=$3 k=$4 r=$5 load off what
  # shellcheck disable=SC2086
  basis "${mesh}_$r" "$mesh" "$k" "$r" $clamped
  for load in $loads; do
    # shellcheck disable=SC2086
    run "reduced_${mesh}_${r}_$load" tremolo-precompute reference "$out/$mesh.veg" $clamped $pushed \
      --load-force "0,$(force "$load"),0" --compare "$out/${mesh}_$r.tremolo"
    off=$(field "reduced_${mesh}_${r}_$load" error_of_largest)
    what="${prefix}P = $load: shape, $k modes, $r coordinates, off full"
    if [ "$r" = 15 ]; then off_full "$what" "$off" 0.2; else shown "$what" "$(percent "$off")"; fi
  done
}
reduced '' "strip_$((n / 2))" "$loads" 1 2
reduced '' "strip_$((n / 2))" "$loads" 3 6
reduced '' "strip_$((n / 2))" "$loads" 5 15
if [ -z "$short" ]; then
  # Four times as slender: what the coordinates cannot follow without stretching costs sixteen times
  # as much against bending.
  height=0.005
  strip slender 400 2 "0 1 0 $height" $width
  reduced 'L/h = 200, ' slender 10 3 6
  reduced 'L/h = 200, ' slender 10 5 15
fi
finish
