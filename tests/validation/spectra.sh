#!/usr/bin/env bash
# The first three bending frequencies of a slender cantilever and of a beam clamped at both ends
# (L/h = 50, nu = 0), in units of sqrt(EI / (rho A L^4)), on meshes refined twice: against
# Euler-Bernoulli's (published), and refined to the limit (omega^2 falls with the square of the cell)
# against Timoshenko's beam, whose shear and rotary inertia the solid has.
#
# The strip is 20 times as wide as thick: with linear elements all that bends or twists the other way
# is faster. Quadratic ones see its true torsion, which lies between; of them the frequency nearest to
# the beam's is taken.
. "$(dirname "$0")/lib.sh"

cells="4 8 16" fine_bound=1 limit_bound=0.02
[ -n "$short" ] && cells="2 4 8" fine_bound=2 limit_bound=0.2
modes=4
[ "${ORDER:-1}" = 2 ] && modes=12 smooth=yes
[ "${ORDER:-1}${short:+s}" = 2s ] && cells="1 2 4"

# mode_of FREQUENCIES MODE BEAM: which of them is the beam's, in its unit.
mode_of() {
  if [ "${ORDER:-1}" = 1 ]; then calc "$(cut -d' ' -f"$2" <<<"$1") / $unit"; return; fi
  tr ' ' '\n' <<<"$1" | awk -v unit="$unit" -v beam="$3" '{
    f = $1 / unit; off = f > beam ? f - beam : beam - f
    if (NR == 1 || off < least) { least = off; best = f } } END { printf "%.12g\n", best }'
}

unit=$(calc 'sqrt(2e11 / 7800) * 0.02 / sqrt(12) / (2 * atan2(0, -1))')

for ends in 1 2; do
  beam=$([ $ends = 1 ] && echo cantilever || echo clamped)
  far=$([ $ends = 1 ] || echo '--fix x>0.9999999')
  levels=()
  for n in $cells; do
    strip "strip_$n" $((50 * n)) "$n" '0 1 0 0.02' 0.4
    # shellcheck disable=SC2086
    run "${beam}_$n" tremolo-precompute "$out/strip_$n.veg" -o "$out/$beam.tremolo" --linear \
      --linear-modes $modes --young 2e11 --poisson 0 --density 7800 --fix 'x<1e-9' $far --json
    levels+=("$(field "${beam}_$n" frequencies_hz)")
  done
  for mode in 1 2 3; do
    found=() squares=()
    for level in "${levels[@]}"; do
      found+=("$(mode_of "$level" $mode "$(published "$beam mode $mode")")")
      squares+=("$(calc "${found[-1]} ^ 2")")
    done
    euler=$(published "$beam mode $mode")
    within "$beam mode $mode, $n cells, Euler-Bernoulli" "${found[2]}" "$euler" $fine_bound
    within "$beam mode $mode, refined, Timoshenko" \
      "$(calc "sqrt($(refined "${squares[@]}"))")" \
      "$(calc "timoshenko($ends, 0.02, $euler)")" $limit_bound
    orderly "$beam mode $mode, order" "$(order "${squares[@]}")" 1.9 2.1
  done
done
finish
