#!/usr/bin/env bash
# Runs the libFuzzer targets of build/fuzz, two at a time, and prints what each did.
#     tests/fuzz/run.sh [SECONDS | -runs=N] [TARGET]...
# 20 seconds each by default; TREMOLO_FUZZ_SEED=N repeats a run; TREMOLO_FUZZ_LENGTH=N lets inputs
# grow to N bytes, 4 096 by default. Exit code 1 if there is a finding; its input is stored in
# build/fuzz/findings and printed, since a file can be out of reach. The inputs that a run learns
# are stored in build/fuzz/learned and start the next one.
set -eu
cd "$(dirname "$0")/../.."
readonly tree=build/fuzz here=tests/fuzz

# The inputs of a target's findings, as text for `base64 -d`.
show_findings() {
  local input
  for input in "$tree/findings/$1"/*; do
    [ -f "$input" ] || continue
    printf '%s: %s\n' "$input" "$(head -c 4096 "$input" | base64 -w 0)"
  done
}

# One target; prints its line of the table.
fuzz_one() {
  local target=$1 limit=$2 log=$tree/logs/$1.log options=() code=0
  mkdir -p "$tree/logs" "$tree/findings/$target" "$tree/seeds/$target"
  [ -e "$here/dictionaries/$target.dict" ] && options+=("-dict=$here/dictionaries/$target.dict")
  [ -d "$here/corpus/$target" ] && options+=("$here/corpus/$target")
  # A seed means the same inputs only where addresses and the clock have no say in them.
  local fixed=() learned=$tree/learned/$target
  if [ -n "${TREMOLO_FUZZ_SEED-}" ]; then
    learned=$tree/learned-from-seed/$target
    rm -rf "$learned"
    setarch -R true 2>/dev/null && fixed=(setarch -R)
    options+=(-reload=0)
  fi
  mkdir -p "$learned"
  # Inputs are small: 64 MB at once, or 512 MB in all with what the sanitizer keeps, is too much.
  ASAN_OPTIONS=quarantine_size_mb=16:allocator_release_to_os_interval_ms=500 \
    nice "${fixed[@]}" "$tree/bin/fuzz_$target" "$limit" \
    -max_len="${TREMOLO_FUZZ_LENGTH:-4096}" -timeout=10 -malloc_limit_mb=64 -rss_limit_mb=512 \
    -seed="${TREMOLO_FUZZ_SEED:-0}" -print_final_stats=1 -verbosity=1 -artifact_prefix="$tree/findings/$target/" \
    "$learned" "$tree/seeds/$target" "${options[@]}" >"$log" 2>&1 || code=$?
  local runs rate found=none
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' "$log")
  [ $code -eq 0 ] || found=$(grep -m 1 -E '^finding:|ERROR: |runtime error:' "$log" || tail -n 1 "$log")
  printf '%-12s %12s %10s   %s\n' "$target" "${runs:--}" "${rate:--}" "$found"
  [ $code -eq 0 ] || show_findings "$target" >&2
  return "$code"
}

if [ "${1-}" = --one ]; then
  fuzz_one "$2" "$3"
  exit
fi

limit=-max_total_time=20
case "${1-}" in
  -runs=*) limit=$1; shift ;;
  [0-9]*) limit=-max_total_time=$1; shift ;;
esac
[ $# -gt 0 ] || set -- $(ls "$tree"/bin/fuzz_* | sed 's|.*/fuzz_||' | grep -v '^seeds$')
"$tree/bin/fuzz_seeds" "$tree/seeds"
printf '%-12s %12s %10s   %s\n' target executions 'a second' finding
code=0
printf '%s\n' "$@" | xargs -P 2 -I{} "$here/run.sh" --one {} "$limit" || code=1
[ $code -eq 0 ] || printf '%s: findings; inputs in %s, logs in %s\n' "$0" "$tree/findings" "$tree/logs" >&2
exit $code
