#!/usr/bin/env bash
# A strip built in at both ends (L/h = 50, nu = 0) under its weight, up to more than three times its
# thickness: the deflection of the middle against the closed form of Timoshenko & Woinowsky-Krieger,
# which has the tension of von Karman and no shear; and the reduced model against the full one.
. "$(dirname "$0")/lib.sh"

# Shear lets a little bent strip give 9.6 (h/L)^2 = 0.4 % more.
cells="4 8 16" fine_bound=1 limit_bound=0.5 loads="1 16 64 200 1000"
[ -n "$short" ] && cells="2 4 8" fine_bound=2 limit_bound=1 loads="16 1000"
height=0.02
built_in="--young 1e9 --poisson 0 --density 1000 --fix x<1e-9 --fix x>0.9999999"
seen="--static --probe near:0.5,0.01,0 --json"
# load = q l^4 / (E h^4), the weight a square metre being q = 1000 g h.
gravity() { calc "$1 * 1e9 * $height ^ 3 / 1000"; }

for load in $loads; do
  w=()
  for n in $cells; do
    strip "strip_$n" $((50 * n)) "$n" "0 1 0 $height" 0.4
    # shellcheck disable=SC2086
    run "full_${n}_$load" tremolo-precompute reference "$out/strip_$n.veg" $built_in $seen \
      --fix-z 'z>=0%' --gravity "0,-$(gravity "$load"),0"
    read -r _ y _ <<<"$(field "full_${n}_$load" displacement)"
    w+=("$(calc "-($y) / $height")")
  done
  expected=$(calc "built_in_strip($load)")
  within "load $load: w/h, $n cells" "${w[2]}" "$expected" $fine_bound
  within "load $load: w/h, refined" "$(refined "${w[@]}")" "$expected" $limit_bound
done

n=$((n / 2))
for basis in '1 2' '3 6' '5 15' '10 30'; do
  read -r k r <<<"$basis"
  # shellcheck disable=SC2086
  basis "basis_$r" "strip_$n" "$k" "$r" $built_in
  for load in $loads; do
    # shellcheck disable=SC2086
    run "reduced_${r}_$load" tremolo-precompute reference "$out/strip_$n.veg" $built_in $seen \
      --gravity "0,-$(gravity "$load"),0" --compare "$out/basis_$r.tremolo"
    off=$(field "reduced_${r}_$load" error_of_largest)
    what="load $load: shape, $k modes, $r coordinates, off full"
    if [ "$r" = 30 ]; then off_full "$what" "$off" 0.5; else shown "$what" "$(percent "$off")"; fi
  done
done
finish
