#!/usr/bin/env bash
# How time and memory of the precompute split over MPI ranks, and what a model of that says of more.
#
#   tests/bench/ranks.sh BIN/tremolo-precompute [--solver mumps|iterative] [--modes K]
#
# A beam on 1, 2 and 4 ranks (one thread each; more ranks than cores wait for each other, so processor
# time is printed, of the rank that took most), and one of an eighth of its size on one rank. Then a
# MODEL, not a measurement: a stage of n dofs on p ranks takes
#     t(n, p) = t(n1, 1) (n / n1)^e (s + (1 - s) / p)
# with e from the two sizes and s from one and two ranks. It knows nothing of networks.
set -euo pipefail

program=$(realpath "${1:?usage: ranks.sh BIN/tremolo-precompute [--solver mumps|iterative] [--modes K]}")
shift
solver=mumps modes=10
while [ $# -gt 0 ]; do
  case $1 in
    --solver) solver=$2; shift ;;
    --modes) modes=$2; shift ;;
    *) echo "ranks.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift
done
here=$(dirname "$(realpath "$0")")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# As root, Open MPI needs explicit permission.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
unset OPENBLAS_CORETYPE
echo "load before: $(cut -d' ' -f1 /proc/loadavg)"
awk -v cells="88 18 17 5.2 1.0 1.01" -f "$here/beam.awk" > "$folder/large.veg"
awk -v cells="44 9 8 5.2 1.0 1.01" -f "$here/beam.awk" > "$folder/small.veg"

# run MESH RANKS: lines "stage seconds megabytes", of the rank that took most.
run() {
  mpiexec --oversubscribe -n "$2" "$program" "$folder/$1.veg" -o "$folder/out.tremolo" \
    --fix 'x<0.001' --linear-modes "$modes" --threads 1 --solver "$solver" --json \
    > "$folder/json" 2> "$folder/log" || { cat "$folder/log" >&2; exit 1; }
  awk '/"stages_of_ranks"/ { inside = 1 }
       inside && /"stage":/ { gsub(/[",]/, ""); stage = $2 }
       inside && /"cpu_seconds"|"peak_bytes"/ { key = $1; most = 0; next }
       inside && key && /\]/ { value[key] = most; if (key ~ /peak/)
           print stage, value["\"cpu_seconds\":"], value["\"peak_bytes\":"] / 1e6; key = "" }
       inside && key && /[0-9]/ { gsub(/,/, ""); if ($1 > most) most = $1 }' "$folder/json"
}
dofs() { sed -n 's/.* \([0-9]*\) dofs,.*/\1/p' "$folder/log"; }

run small 1 > "$folder/s1"; small=$(dofs)
for ranks in 1 2 4; do run large $ranks > "$folder/l$ranks"; done; large=$(dofs)
echo "$large dofs ($small in the small one), $modes modes, $solver; processor seconds and peak MB of the rank with most"
paste -d' ' "$folder/l1" "$folder/l2" "$folder/l4" "$folder/s1" |
  awk -v n1="$large" -v n0="$small" '
  BEGIN { printf "%-13s %17s %17s %17s   %s\n", "stage", "1 rank", "2 ranks", "4 ranks", "model: e, s" }
  { s = $2 > 0 ? 2 * $5 / $2 - 1 : 1; if (s < 0) s = 0; if (s > 1) s = 1
    e = $11 > 0 && $2 > 0 ? log($2 / $11) / log(n1 / n0) : 1
    printf "%-13s %8.2f s %4.0f MB %8.2f s %4.0f MB %8.2f s %4.0f MB   %.2f, %.2f\n",
           $1, $2, $3, $5, $6, $8, $9, e, s
    t1 += $2; t2 += $5; t4 += $8
    for (p = 1; p <= 64; p *= 2) {
      strong[p] += $2 * (s + (1 - s) / p); weak[p] += $2 * p ^ e * (s + (1 - s) / p) } }
  END { printf "%-13s %8.2f s %17.2f s %15.2f s\n", "all", t1, t2, t4
    print "MODEL, not measured:"
    printf "%-38s", "ranks"; for (p = 1; p <= 64; p *= 2) printf " %7d", p
    printf "\n%-38s", "the same mesh, s (strong scaling)"; for (p = 1; p <= 64; p *= 2) printf " %7.1f", strong[p]
    printf "\n%-38s", "a mesh of that size a rank, s (weak)"; for (p = 1; p <= 64; p *= 2) printf " %7.0f", weak[p]
    print "" }'
