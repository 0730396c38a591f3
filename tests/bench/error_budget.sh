#!/usr/bin/env bash
# The errors of mesh, basis and step of a sample model under its own load, with linear and with
# quadratic elements: `--error-budget` as a table (docs/error.md).
#
#   tests/bench/error_budget.sh BIN OUT [MODEL...]
#
# BIN: the folder of tremolo and tremolo-precompute; models: all six samples unless named. OUT
# stores MODEL-ORDER.json and .log, so that a second start continues; OUT/table.md has all results.
#
# Environment: THREADS (2), MEMORY (none: refined meshes with a factor of more than 3e8 entries are left
# out; 18GB takes all six, one after the other, for half an hour).
set -euo pipefail

bin=${1:?usage: error_budget.sh BIN OUT [MODEL...]}
out=${2:?usage: error_budget.sh BIN OUT [MODEL...]}
shift 2
models=${*:-beam horse heart bridge basket tower}
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/bench/readers.sh"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mkdir -p "$out"

for model in $models; do
  for order in 1 2; do
    name=$out/$model-$order
    [ -s "$name.json" ] && continue
    "$bin/tremolo-precompute" "$root/assets/meshes/$model.msh" \
      --config "$root/assets/models/$model.toml" --order $order --threads "${THREADS:-2}" \
      ${MEMORY:+--memory "$MEMORY"} --error-budget --json -o "$name.tremolo" >"$name.partial" 2>"$name.log"
    mv "$name.partial" "$name.json"
  done
done

{
  echo "| model | order | tetrahedra | dofs | mesh | mesh, off its limit | basis | step |"
  echo "|---|---:|---:|---:|---:|---:|---:|---:|"
  for model in beam horse heart bridge basket tower; do
    for order in 1 2; do
      file=$out/$model-$order.json
      [ -s "$file" ] || continue
      echo "| $model | $order | $(number "$file" elements) | $(number "$file" dofs) |" \
        "$(percent "$(number "$file" discretisation)") |" \
        "$(percent "$(number "$file" discretisation_limit)") |" \
        "$(percent "$(number "$file" reduction)") | $(percent "$(number "$file" integration)") |"
    done
  done
} >"$out/table.md"
cat "$out/table.md"
