#!/usr/bin/env bash
# run.sh BIN_DIR OUT_DIR [--short] [CASE...]: the programs against what others have published or
# solved in closed form (docs/validation.md), all cases or those named. Prints one table. Exit code
# 6 when a criterion is missed, 1 when a program fails. A case alone: CASE.sh BIN_DIR OUT_DIR.
set -u
here=$(cd "$(dirname "$0")" && pwd)
[ $# -ge 2 ] || { echo "usage: run.sh BIN_DIR OUT_DIR [--short] [CASE...]" >&2; exit 2; }
bin=$1 folder=$2 short=
shift 2
[ "${1-}" = --short ] && { short=--short; shift; }
[ $# -gt 0 ] || set -- spectra csm1 csm3 built_in elastica shapes orders vibration
failed=() tables=()
for name in "$@"; do
  [ -x "$here/$name.sh" ] || { echo "run.sh: there is no case $name" >&2; exit 2; }
  # shellcheck disable=SC2086
  "$here/$name.sh" "$bin" "$folder" $short >/dev/null
  case $? in
    0 | 6) tables+=("$folder/$name/rows.tsv") ;;
    *) failed+=("$name") ;;
  esac
done
code=0
[ ${#tables[@]} -eq 0 ] || "$here/table.sh" "${tables[@]}" || code=$?
[ ${#failed[@]} -eq 0 ] || { echo "run.sh: no result of ${failed[*]}" >&2; code=1; }
exit $code
