# Sourced by every case, CASE.sh BIN_DIR OUT_DIR [--short]: runs the programs, keeps what they say in
# OUT_DIR/CASE, writes its rows to OUT_DIR/CASE/rows.tsv and prints them. Exit code 6 when a
# criterion is missed. --short: coarse meshes, seconds, with the bounds of coarse meshes.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
case_name=$(basename "$0" .sh)
[ $# -ge 2 ] && [ $# -le 3 ] && [ "${3---short}" = --short ] ||
  { echo "usage: $case_name.sh BIN_DIR OUT_DIR [--short]" >&2; exit 2; }
bin=$(cd "$1" && pwd)
mkdir -p "$2/$case_name"
out=$(cd "$2/$case_name" && pwd)
short=${3:+yes}
rows=$out/rows.tsv
: >"$rows"
# As root, Open MPI needs explicit permission.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

# make_mesh NAME AWK VARIABLE=VALUE...: OUT/NAME.veg by AWK.awk, unless it is there.
make_mesh() {
  local mesh=$out/$1 script=$here/$2.awk variables=() one
  [ -e "$mesh.veg" ] && return
  shift 2
  for one in "$@"; do variables+=(-v "$one"); done
  awk "${variables[@]}" -f "$script" >"$mesh.partial"
  mv "$mesh.partial" "$mesh.veg"
}

# strip NAME NX NY BOX THICK [ARC]: OUT/NAME.veg, unless it is there (strip.awk).
strip() { make_mesh "$1" strip "nx=$2" "ny=$3" "box=$4" "thick=$5" "arc=${6-}"; }

# The order of the elements is 1 unless ORDER says otherwise.
# run LOG PROGRAM ARGUMENTS...: stdout to OUT/LOG.json, stderr to OUT/LOG.log, shown if it fails.
run() {
  local log=$1 program=$2 code=0
  shift 2
  [ "$program" = tremolo-precompute ] && set -- "$@" --order "${ORDER:-1}"
  "$bin/$program" "$@" >"$out/$log.json" 2>"$out/$log.log" || code=$?
  [ $code = 0 ] && return
  tail -n 5 "$out/$log.log" >&2
  echo "$case_name: $program ended with code $code: $program $*" >&2
  exit 1
}

# basis NAME MESH K R ARGUMENTS...: OUT/NAME.tremolo of K linear modes and R coordinates.
basis() {
  local name=$1 mesh=$2 k=$3 r=$4
  shift 4
  run "$name" tremolo-precompute "$out/$mesh.veg" -o "$out/$name.tremolo" --linear-modes "$k" \
    --modes "$r" "$@"
}

# field LOG NAME [WHICH]: a number, or a list of numbers with blanks between, of OUT/LOG.json; if
# the name occurs several times, the last or the WHICHth. A value that is not a number is reported
# and left empty: no criterion is met by it.
field() {
  local value
  value=$(tr -d '\n ' <"$out/$1.json" | grep -o "\"$2\":\[\{0,1\}[-+0-9.e,]*" | sed -n "${3-$}p" |
    sed 's/.*:\[\{0,1\}//' | tr ',' ' ')
  [ -n "$value" ] || echo "$case_name: no number '$2' in $out/$1.json" >&2
  printf '%s\n' "$value"
}

# calc EXPRESSION: a number, by awk, with the closed forms.
calc() { awk -f "$here/closed_forms.awk" -f <(printf 'BEGIN { printf "%%.9g\\n", %s }\n' "$1"); }

published() {  # QUANTITY: its value in published.csv
  awk -F, -v want="$case_name" -v what="$1" \
    '$1 == want && $2 == what { print $3; found = 1 } END { exit !found }' "$here/published.csv"
}

# within WHAT MEASURED EXPECTED PERCENT: a row; met if they differ by at most so much.
within() {
  awk -v name="$case_name" -v what="$1" -v m="$2" -v e="$3" -v most="$4" 'BEGIN {
    OFS = "\t"; off = 100 * (m / e - 1); met = off <= most && off >= -most
    print name, what, sprintf("%.5g", m), sprintf("%.5g", e), sprintf("%+.2g %%", off),
          "within " most " %", met ? "met" : "MISSED" }' >>"$rows"
}

# between WHAT MEASURED LOW HIGH: a row; met if it lies there.
between() {
  awk -v name="$case_name" -v what="$1" -v m="$2" -v low="$3" -v high="$4" 'BEGIN {
    OFS = "\t"; met = m >= low && m <= high
    print name, what, sprintf("%.3g", m), "", "", low " to " high, met ? "met" : "MISSED" }' >>"$rows"
}

# at_most WHAT FRACTION PERCENT: a row; met if the fraction is at most so many percent.
at_most() {
  awk -v name="$case_name" -v what="$1" -v m="$2" -v most="$3" 'BEGIN {
    OFS = "\t"; met = m != "" && m >= 0 && 100 * m <= most
    print name, what, sprintf("%.2g %%", 100 * m), "", "", "at most " most " %",
          met ? "met" : "MISSED" }' >>"$rows"
}

# off_full WHAT FRACTION PERCENT: how far a reduced model is off the full one. With quadratic
# elements it has no criterion: their lowest modes include the strips' torsions, which linear
# elements lock out, and as many coordinates bend less.
off_full() {
  if [ "${ORDER:-1}" = 1 ]; then at_most "$@"; else shown "$1" "$(percent "$2")"; fi
}

# shown WHAT TEXT: a row without a criterion.
shown() { printf '%s\t%s\t%s\t\t\t\ttold\n' "$case_name" "$1" "$2" >>"$rows"; }

percent() { calc "100 * $1" | awk '{ printf "%.2g %%\n", $1 }'; }

# Of values on meshes refined by two and once more: the order seen, and the limit at the order of
# the elements' frequencies, 2 of linear ones and 4 of quadratic ones.
order() { calc "log(($1 - $2) / ($2 - $3)) / log(2)"; }
refined() { calc "$3 + ($3 - $2) / (4 ^ ${ORDER:-1} - 1)"; }

# orderly WHAT ORDER LOW HIGH: a row on the order seen. That of quadratic elements has a range of its
# own where the body is smooth (smooth=yes) and none where corners or the solver's tolerance decide.
orderly() {
  if [ "${ORDER:-1}" = 1 ]; then
    between "$@"
  elif [ -n "${smooth-}" ]; then
    between "$1" "$2" 3.3 4.2
  else
    shown "$1" "$2"
  fi
}

# The case's last line: prints its rows.
finish() {
  "$here/table.sh" "$rows"
}
