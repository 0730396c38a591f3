#!/usr/bin/env bash
# Free vibration of large amplitude: how the first frequency of a clamped beam and of a clamped square
# plate rises, edges immovable, against Ritz's method for the thin bodies (backbones.py; the beam also
# against Woinowsky-Krieger's elliptic integral, which one term of it gives). And an internal resonance:
# the plate's fourth mode has three times the first frequency (3.007, Leissa's table). By symmetry a
# perfect plate does not feel it. Cut into tetrahedra of one direction the plate has a loop there.
. "$(dirname "$0")/lib.sh"

export ORDER=2  # linear elements lock
plate=16 plate_modes="12 40" bound=0.5
[ -n "$short" ] && plate=10 plate_modes="6 27" bound=1.5
ratios="0.2 0.4 0.6 0.8 1"

# block NAME NX NY NZ SIZE MIRRORED: OUT/NAME.veg, unless it is there (block.awk).
block() { make_mesh "$1" block "nx=$2" "ny=$3" "nz=$4" "size=$5" "mirrored=$6"; }

# backbone NAME THICKNESS HARMONICS: of OUT/NAME.tremolo to that amplitude: OUT/NAME_backbone.json, .csv.
# A loop of many harmonics is narrower than the difference of the theories: few are asked for.
backbone() {
  run "$1_backbone" tremolo backbone "$out/$1.tremolo" --to-amplitude "$2m" --no-stability \
    --harmonics "$3" --most-harmonics "$3" --csv "$out/$1.csv" --json "${@:4}"
}

# at NAME THICKNESS RATIO: the frequency where the amplitude first is RATIO times the thickness, over that
# of small vibration. Between two points the square of the frequency is linear in that of the amplitude.
at() {
  awk -F, -v linear="$(field "$1_backbone" linear_frequency_hz)" -v want="$(calc "$2 * $3")" '
    NR > 1 && $2 >= want * (1 - 1e-9) {
      part = (want ^ 2 - a ^ 2) / ($2 ^ 2 - a ^ 2)
      printf "%.7g\n", sqrt(f ^ 2 + part * ($1 ^ 2 - f ^ 2)) / linear
      exit
    }
    { f = $1; a = $2 }' "$out/$1.csv"
}

# hardens WHAT NAME THICKNESS BODY: a row for each amplitude.
hardens() {
  local what=$1 name=$2 thickness=$3 ratio expected
  # shellcheck disable=SC2086
  python3 "$here/backbones.py" "$4" $ratios >"$out/$4.txt"
  while read -r ratio expected; do
    within "$what, w/h = $ratio: f/f0" "$(at "$name" "$thickness" "$ratio")" "$expected" $bound
  done <"$out/$4.txt"
}

block beam 40 2 2 "1 0.02 0.01" 1
basis beam beam 8 24 --young 1e9 --poisson 0 --density 1000 --fix 'x<1e-9' --fix 'x>0.999999'
backbone beam 0.01 5
hardens "clamped beam, L/h = 100" beam 0.01 beam

clamped="--young 1e9 --poisson 0.3 --density 1000 --fix x<1e-9 --fix x>0.999999 --fix y<1e-9 --fix y>0.999999"
read -r k r <<<"$plate_modes"
block plate "$plate" "$plate" 2 "1 1 0.02" 1
# shellcheck disable=SC2086
basis plate plate "$k" "$r" $clamped
backbone plate 0.02 5
hardens "clamped plate, a/h = 50" plate 0.02 plate

# The loop: the third harmonic of mode 4 takes over, and nearly all of it is gone again behind. In the JSON
# a point's frequency, its amplitude and its resonance follow each other.
block crooked 20 20 1 "1 1 0.02" 0
# shellcheck disable=SC2086
basis crooked crooked 6 27 $clamped
# A longer step crosses the narrow gap at its beginning, and goes round.
backbone crooked 0.008 3 --longest-step 0.05
tr -d '\n ' <"$out/crooked_backbone.json" | grep -o '"frequency_hz":[^}]*"resonance":{[^}]*}' |
  sed 's/"frequency_hz":\([^,]*\),.*"energy":\([^,]*\),.*"harmonic":\([0-9]*\),"mode":\([0-9]*\),"share":\([^}]*\)}/\1 \2 \3 \4 \5/' \
    >"$out/loop.txt"
read -r part frequency energy last <<<"$(awk '
  $3 == 3 && $4 == 4 && $5 > most { most = $5; at = $1; energy = $2 }
  { last = $3 == 3 && $4 == 4 ? $5 : 0 }
  END { print most + 0, at + 0, energy + 0, last }' "$out/loop.txt")"
between "1:3 with mode 4: largest part of its third harmonic" "$part" 0.9 1
# There the motion is one of mode 4 alone, whose own curve has that frequency at that energy.
run fourth tremolo backbone "$out/crooked.tremolo" --mode 4 --to-amplitude 0.01m --no-stability \
  --harmonics 1 --most-harmonics 1 --csv "$out/fourth.csv" --json
within "1:3 with mode 4: three times the frequency there, Hz" "$(calc "3 * $frequency")" \
  "$(awk -F, -v want="$energy" 'NR > 1 && $5 >= want {
       printf "%.7g\n", sqrt(f ^ 2 + (want - e) / ($5 - e) * ($1 ^ 2 - f ^ 2)); exit }
     { f = $1; e = $5 }' "$out/fourth.csv")" 0.1
at_most "1:3 with mode 4: part of its third harmonic behind the loop" "$last" 1
within "clamped plate: f4/f1" \
  "$(calc "$(field fourth linear_frequency_hz) / $(field crooked_backbone linear_frequency_hz)")" \
  "$(published 'clamped plate mode 4 over mode 1')" 1
finish
