#!/usr/bin/env bash
# Turek & Hron's CSM3: the bar of CSM1 released from rest under its weight, by the full model and by
# the reduced one. Published are the mean (max + min) / 2, the amplitude (max - min) / 2 and the
# frequency of A's motion over one oscillation. The second mode also swings, so oscillations differ
# from each other. Compared is the average over all whole ones; their range is printed.
. "$(dirname "$0")/lib.sh"
. "$here/bar.sh"

n=12 step=0.01 duration=10 bound=1
[ -n "$short" ] && n=4 step=0.02 duration=2 bound=6
k=5 r=15
wide_bar $n
basis basis "wide_$n" $k $r "${wide[@]}"
run both tremolo-precompute reference "$out/wide_$n.veg" "${wide[@]}" --gravity 0,-2,0 \
  --integrator avf --step $step --duration $duration --probe "$wide_end" \
  --compare "$out/basis.tremolo" --out "$out/both" --json

# oscillations NAME PATTERN: OUT/NAME, mean, amplitude and frequency of each, of the column of
# run.csv whose name is like that.
oscillations() {
  local column
  column=$(head -n 1 "$out/both/run.csv" | tr ',' '\n' | grep -n "$2" | cut -d: -f1)
  awk -F, -v column="$column" -f "$here/oscillation.awk" "$out/both/run.csv" >"$out/$1"
}
average() { awk -v c="$2" '{ sum += $c } END { printf "%.9g\n", sum / NR }' "$out/$1"; }
range() {
  awk -v c="$2" 'NR == 1 { low = high = $c } $c < low { low = $c } $c > high { high = $c }
    END { printf "%.4g to %.4g\n", low, high }' "$out/$1"
}
for model in full:u reduced:r; do
  IFS=: read -r model letter <<<"$model"
  for axis in x y; do oscillations "${model}_$axis" "^$letter[0-9]*$axis\$"; done
  what=$model
  [ $model = full ] || what="$k modes, $r coordinates"
  for row in 'u_x mean:x:1' 'u_x amplitude:x:2' 'u_y mean:y:1' 'u_y amplitude:y:2' 'frequency:y:3'; do
    IFS=: read -r name axis column <<<"$row"
    within "$name, $what" "$(average "${model}_$axis" "$column")" "$(published "$name")" $bound
    [ $model = reduced ] || shown "$name, single oscillations" "$(range "full_$axis" "$column")"
  done
done
off_full "shape, $k modes, $r coordinates, off full" "$(field both error_of_largest)" 1
between "energy off its balance" "$(field both energy_drift_max)" 0 1e-8
finish
