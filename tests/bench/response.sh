#!/usr/bin/env bash
# response.sh BIN_DIR MODELS_DIR OUT_DIR [RATIO [MODEL...]]: what a response curve costs, and the same
# curve by time stepping (docs/response.md, "What it costs"). RATIO: damping, 2% by default. For each of
# the sample models, or those named: the load that makes the peak 10 % of the size is the end of the damped
# backbone; then the curve about the first mode with 5 harmonics and its stable points by time stepping, and
# with 7 harmonics. Seconds are of the processor, one thread, without loading the model.
set -euo pipefail
[ $# -ge 3 ] || { echo "usage: response.sh BIN_DIR MODELS_DIR OUT_DIR [RATIO [MODEL...]]" >&2; exit 2; }
tremolo=$1/tremolo models=$2 out=$3 ratio=${4-2%}
shift $(($# > 4 ? 4 : $#))
[ $# -gt 0 ] || set -- beam horse basket tower heart bridge
mkdir -p "$out"

# number FILE KEY: the last one of that name at the top of the report.
number() { grep -o "\"$2\": *[-+0-9.e]*" "$1" | tail -n 1 | sed 's/.*: *//'; }
# report LOG ARGUMENTS...: OUT/LOG.json. A curve that ends early (4, 5) has its points.
report() {
  local log=$out/$1 code=0
  shift
  "$tremolo" "$@" --json >"$log.json" 2>"$log.log" || code=$?
  [ $code = 0 ] || [ $code = 4 ] || [ $code = 5 ] || { cat "$log.log" >&2; exit 1; }
}

printf '%-8s %3s %7s %7s %6s %8s %8s %9s %7s %6s %8s %5s %8s\n' model r points stable peak 'H=5, s' 'H=7, s' \
  'steps, s' ratio steps periods off differs
for model in "$@"; do
  file=$models/$model.tremolo
  report "$model.ridge" backbone "$file" --damped --damping-ratio "$ratio" --to-amplitude 10% --no-stability \
    --harmonics 5 --most-harmonics 5
  # The last point of the ridge, or of what there is of it, and the range about it.
  read -r load from to <<<"$(awk '
    /"linear_frequency_hz"/ { gsub(/[^-+0-9.e]/, "", $2); first = $2 + 0 }
    /"frequency_hz"/ { gsub(/[^-+0-9.e]/, "", $2); f = $2 + 0 }
    /"amplitude"/ { gsub(/[^-+0-9.e]/, "", $2); a = $2 + 0 }
    /"load_scale"/ { gsub(/[^-+0-9.e]/, "", $2); if (a > most) { most = a; load = $2 + 0; peak = f } }
    END { from = 0.8 * first; to = 1.2 * first
          if (0.85 * peak < from) from = 0.85 * peak
          if (1.1 * peak > to) to = 1.1 * peak
          print load, from, to }' "$out/$model.ridge.json")"
  common=(response "$file" --damping-ratio "$ratio" --load-scale "$load" --from "$from" --to "$to")
  report "$model.5" "${common[@]}" --harmonics 5 --most-harmonics 5 --by-stepping
  report "$model.7" "${common[@]}" --harmonics 7 --most-harmonics 7
  five=$out/$model.5.json
  points=$(grep -c '"phase_deg"' "$five")
  peak=$(grep -A 2 '"peak"' "$five" | grep -o '"amplitude": *[-+0-9.e]*' | sed 's/.*: *//')
  curve=$(grep -o '"processor_seconds": *[-+0-9.e]*' "$five" | head -n 1 | sed 's/.*: *//')
  stable=$(grep -A 8 '"by_stepping"' "$five" | grep -o '"points": *[0-9]*' | sed 's/.*: *//')
  awk -v model="$model" -v r="$(number "$five" coordinates)" -v points="$points" -v stable="$stable" \
    -v peak="$peak" -v size="$(number "$five" size)" -v curve="$curve" \
    -v seven="$(number "$out/$model.7.json" processor_seconds)" -v stepped="$(number "$five" processor_seconds)" \
    -v ratio="$(number "$five" ratio)" -v steps="$(number "$five" steps_per_period)" \
    -v periods="$(number "$five" periods)" -v off="$(number "$five" points_elsewhere)" \
    -v differs="$(number "$five" largest_difference)" 'BEGIN {
      printf "%-8s %3d %7d %7d %5.1f%% %8.2f %8.2f %9.1f %7.1f %6d %8.0f %5d %8.1e\n", model, r, points, stable,
        100 * peak / size, curve, seven, stepped, ratio, steps, periods / stable, off, differs }'
done
