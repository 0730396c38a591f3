#!/usr/bin/env bash
# Turek & Hron's CSM1: an elastic bar, 0.35 m x 0.02 m, clamped along the arc of a cylinder and bent
# by its weight, in plane strain: where the middle A of its free end comes to rest.
. "$(dirname "$0")/lib.sh"
. "$here/bar.sh"

cells="6 12 24" bound=0.5
[ -n "$short" ] && cells="3 6 12" bound=1.5
x=() y=()
for n in $cells; do
  bar "$n" "$(calc "0.02 / $n")"
  # shellcheck disable=SC2086
  run "full_$n" tremolo-precompute reference "$out/bar_$n.veg" $plane_strain --fix "$arc" \
    --static --gravity 0,-2,0 --probe near:0.6,0.2,0 --json
  read -r ux uy _ <<<"$(field "full_$n" displacement)"
  x+=("$ux") y+=("$uy")
done
within "u_x of A, $n cells" "${x[2]}" "$(published u_x)" $bound
within "u_y of A, $n cells" "${y[2]}" "$(published u_y)" $bound
within "u_x of A, refined" "$(refined "${x[@]}")" "$(published u_x)" "$(calc "$bound / 5")"
within "u_y of A, refined" "$(refined "${y[@]}")" "$(published u_y)" "$(calc "$bound / 5")"
orderly "u_y of A, order" "$(order "${y[@]}")" 1.7 2.1

# The reduced model of the wide bar, which is in plane strain without being held.
n=${cells##* } n=$((n / 2))
wide_bar $n
run wide tremolo-precompute reference "$out/wide_$n.veg" "${wide[@]}" --static --gravity 0,-2,0 \
  --probe "$wide_end" --json
read -r _ uy _ <<<"$(field wide displacement)"
within "u_y of A, $n cells, wide bar" "$uy" "${y[1]}" 0.1
for basis in '1 2' '3 6' '5 15'; do
  read -r k r <<<"$basis"
  basis "basis_$r" "wide_$n" "$k" "$r" "${wide[@]}"
  run "reduced_$r" tremolo-precompute reference "$out/wide_$n.veg" "${wide[@]}" --static \
    --gravity 0,-2,0 --probe "$wide_end" --compare "$out/basis_$r.tremolo" --json
  off=$(field "reduced_$r" error_of_largest)
  what="shape, $k modes, $r coordinates, off full"
  if [ "$r" = 15 ]; then off_full "$what" "$off" 0.1; else shown "$what" "$(percent "$off")"; fi
done
finish
