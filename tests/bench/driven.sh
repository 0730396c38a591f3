#!/usr/bin/env bash
# Sample models whose support moves, beside their whole meshes moved the same way (docs/validation.md).
#
#   tests/bench/driven.sh BIN OUT [MODEL...]
#
# BIN: the folder of tremolo and tremolo-precompute; models: beam and tower unless named. Linear
# elements; ep4 at 3 ms and the whole mesh at 1 ms for 0.6 s; bases of the model's own r and of 2 r. The
# figures are of the loaded vertex, largest difference over largest displacement: in motion, and at rest
# under two static loads that move it as far, the model's own and a uniform acceleration across the
# body, along the shake. OUT keeps what is done; OUT/driven.md is the table. Exit code 6: a basis misses
# the motion by more than it misses the rest under the model's own load. Twelve minutes of processor
# time.
set -euo pipefail

bin=$(cd "${1:?usage: driven.sh BIN OUT [MODEL...]}" && pwd)
mkdir -p "${2:?usage: driven.sh BIN OUT [MODEL...]}"
out=$(cd "$2" && pwd)
shift 2
models=${*:-beam tower}
assets=$(cd "$(dirname "$0")/../../assets" && pwd)
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

# A line a motion: name, amplitude (mm) along (5, 1.5, 2) / 5, frequency (Hz), rate (rad/s), damped or not.
declare -A motions=(
  [beam]="shake:30:1.5:0: spin:0:1:3: both:30:1.5:3:damped"
  [tower]="shake:5:1.2:0: far:20:1.2:0: spin:0:1:3: both:10:1.2:3:damped")
declare -A across=([beam]="0,0.3,0.4" [tower]="1,0.3,0")
declare -A moved=([shake]="shake" [far]="shake, four times as far" [spin]="spin-up"
  [both]="both, damped, in gravity")

config() { # MODEL KEY: a number of the model's file
  sed -n "s/^$2 *= *\"\{0,1\}\([^ \"#]*\).*/\1/p" "$assets/models/$1.toml"
}

# poses AMPLITUDE FREQUENCY RATE: a shake, s = sin^3, and a turn about y that sets in within 0.5 s.
poses() {
  awk -v a="$1" -v f="$2" -v rate="$3" 'BEGIN {
    pi = atan2(0, -1); ramp = 0.5
    for (i = 0; i <= 1300; ++i) {
      t = i * 5e-4
      s = a / 1000 * sin(2 * pi * f * t) ^ 3
      half = (t < ramp ? t - ramp / pi * sin(pi * t / ramp) : 2 * t - ramp) * rate / 4
      printf "%.17g,%.17g,%.17g,%.17g,%.17g,0,%.17g,0\n", t, s, 0.3 * s, 0.4 * s, cos(half), sin(half)
    }
  }'
}

field() { tr -d '\n ' <"$1" | grep -o "\"$2\":[-+0-9.e]*" | sed -n "${3-1}p" | sed 's/.*://'; }

# whole MODEL FILE ARGUMENTS...: the reference's JSON, unless it is there.
whole() {
  local model=$1 file=$2
  shift 2
  [ -s "$file" ] && return
  "$bin/tremolo-precompute" reference "$assets/meshes/$model.msh" --config "$assets/models/$model.toml" \
    --order 1 --threads 1 --probe "$probe" --json "$@" >"$file.partial" 2>"$file.log" ||
    { tail -n 2 "$file.log" >&2; return 1; }
  mv "$file.partial" "$file"
}

columns() { # RUN.CSV: time and the probe's three
  awk -F, -v u="u${probe#vertex:}" 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
    { print $1, $at[u "x"], $at[u "y"], $at[u "z"] }' "$1"
}

# reduced BASIS ARGUMENTS...: moved as FOLDER/poses.csv says; prints the largest difference from the
# whole mesh over its largest displacement.
reduced() {
  {
    echo "duration = 0.6"
    [ -z "$damped" ] || echo "gravity = [0, 0, -9.81]"
    echo "[[bodies]]
name = \"body\"
model = \"$1\"
kind = \"driven\"
probe = \"${probe#vertex:}\""
    [ -z "$damped" ] || printf 'alpha = 0.5\nbeta = 0.002\n'
    printf '[[bodies.motion]]\nkind = "csv"\nfile = "poses.csv"\n'
  } >"$folder/scene.toml"
  "$bin/tremolo" run "$folder/scene.toml" --step 0.003 --every 1 --out "$folder/reduced" >/dev/null 2>&1
  paste -d ' ' <(columns "$folder/full/run.csv") <(columns "$folder/reduced/body/run.csv") |
    awk '($1 - $5) ^ 2 > 1e-18 { exit 1 }
      { d = ($2 - $6) ^ 2 + ($3 - $7) ^ 2 + ($4 - $8) ^ 2; u = $2 ^ 2 + $3 ^ 2 + $4 ^ 2
        if (d > far) far = d; if (u > peak) peak = u }
      END { print sqrt(far / peak), sqrt(peak) }'
}

# at_rest NAME ARGUMENT: FOLDER/NAME.json, the rest in which the probe is moved by PEAK (0.5 %) under a
# load that ARGUMENT names: "scale", or "x,y,z" to be scaled.
at_rest() {
  local file=$folder/$1.json factor=1 reached
  [ -s "$file" ] && return
  for _ in 1 2 3 4 5 6 7 8; do
    rm -f "$file"
    if [ "$2" = scale ]; then
      whole "$model" "$file" --static --scale "$factor" "${compare[@]}"
    else
      whole "$model" "$file" --static --load none "${compare[@]}" --gravity "$(
        awk -v g="$factor" -v v="$2" 'BEGIN { split(v, p, ","); printf "%.9g,%.9g,%.9g", g * p[1], g * p[2], g * p[3] }')"
    fi
    reached=$(field "$file" displacement)
    awk -v a="$reached" -v b="$peak" 'BEGIN { exit !((a / b - 1) ^ 2 < 2.5e-5) }' && return
    factor=$(awk -v f="$factor" -v a="$reached" -v b="$peak" 'BEGIN { print f * b / a }')
  done
  echo "driven.sh: $1 of $model does not reach $peak m" >&2
  return 1
}

percent() { awk -v x="$1" 'BEGIN { printf "%.2g %%", 100 * x }'; }

code=0
{
  echo "| model, motion of its support | probe moves | r | driven | at rest, own load | at rest, accelerated |"
  echo "|---|---:|---:|---:|---:|---:|"
} >"$out/driven.md.partial"
for model in $models; do
  probe=$(config "$model" load-at)
  r=$(config "$model" modes) k=$(config "$model" linear-modes)
  compare=()
  for factor in 1 2; do
    basis=$out/$model-$((factor * r)).tremolo
    [ -s "$basis" ] || "$bin/tremolo-precompute" "$assets/meshes/$model.msh" --threads 1 \
      --config "$assets/models/$model.toml" --order 1 --linear-modes $((factor * k)) \
      --modes $((factor * r)) -o "$basis" 2>"$basis.log"
    compare+=(--compare "$basis")
  done
  for motion in ${motions[$model]}; do
    IFS=: read -r name amplitude frequency rate damped <<<"$motion"
    folder=$out/$model-$name
    mkdir -p "$folder"
    poses "$amplitude" "$frequency" "$rate" >"$folder/poses.csv"
    extra=(--load none --support-motion "$folder/poses.csv" --duration 0.6 --step 0.001 --every 3
      --out "$folder/full")
    [ -z "$damped" ] || extra+=(--gravity "0,0,-9.81" --alpha 0.5 --beta 0.002)
    whole "$model" "$folder/full.json" "${extra[@]}"
    n=0
    for factor in 1 2; do
      n=$((n + 1))
      result=$(reduced "$out/$model-$((factor * r)).tremolo")
      read -r driven peak <<<"$result"
      at_rest own scale
      at_rest accelerated "${across[$model]}"
      own=$(field "$folder/own.json" tip_error_of_largest $n)
      accelerated=$(field "$folder/accelerated.json" tip_error_of_largest $n)
      echo "| $model: ${moved[$name]} | $(awk -v u="$peak" 'BEGIN { printf "%.0f mm", 1000 * u }') |" \
        "$((factor * r)) | $(percent "$driven") | $(percent "$own") | $(percent "$accelerated") |" \
        >>"$out/driven.md.partial"
      awk -v a="$driven" -v b="$own" 'BEGIN { exit !(a <= b) }' || code=6
    done
  done
done
mv "$out/driven.md.partial" "$out/driven.md"
cat "$out/driven.md"
exit $code
