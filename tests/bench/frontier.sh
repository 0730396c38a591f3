#!/usr/bin/env bash
# Time to a given total error: what mesh, basis and step leave out of a motion, against the processor time
# of the precompute and of a simulated second (docs/error.md, "Time to 1 % error").
#
#   tests/bench/frontier.sh BIN OUT [MODEL...]
#
# BIN: the folder of tremolo, tremolo-precompute and tremolo-lab; models: all six samples unless named.
# Each moves from rest under its square load for 0.45 s. An error is max |u - u'| / max |u'|, with |.| over
# PROBES vertices spread over the mesh, which keep their numbers when it is refined:
#   mesh   a basis of MESH_R coordinates of this mesh against the limit of the quadratic mesh and the same
#          refined once, u = u_{h/2} - (u_h - u_{h/2}) / (2^1.5 - 1) at each time (limits.sh has the order);
#   basis  the reduced model against its whole mesh, both by the same steps (avf), with quadratic elements;
#   step   a method and its step against ep4 at 0.2 ms, of the same basis.
# The total is their sum. Whole-mesh motions (own solver `reference`) are on the frontier as well, without a
# basis. OUT/sum.csv compares sums with distances measured at once, from the whole quadratic mesh and from the
# refined one.
#
# OUT/MODEL stores finished results, so a second start continues. OUT/errors.csv has every part,
# OUT/frontier.csv every combination, OUT/table.md the table; tremolo-lab makes OUT/frontier.html (.png, if
# Chromium is installed). Times are user time of one thread, the median of REPEAT runs; a precompute of
# more than LONG seconds is measured once.
#
# Environment: ORDERS (r: 10 15 20 30 60), MESHES (of elements-refined: 1-0 2-0 1-1 2-1), WHOLE (elements of
# the whole-mesh motions: 1 2; with 1 alone, basis errors are those of linear elements), METHODS, PROBES (800),
# MESH_R (30), WHOLE_STEP (0.005 s), REPEAT (3), LONG (20 s), MEMORY (10GB, of one precompute; heart and basket
# need 13GB). All six take two hours of processor time, with WHOLE=1 one and a half.
set -euo pipefail

bin=${1:?usage: frontier.sh BIN OUT [MODEL...]}
out=${2:?usage: frontier.sh BIN OUT [MODEL...]}
shift 2
samples="beam horse heart bridge basket tower"
models=${*:-$samples}
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/bench/readers.sh"
orders=${ORDERS:-10 15 20 30 60} meshes=${MESHES:-1-0 2-0 1-1 2-1} whole=${WHOLE:-1 2}
mesh_r=${MESH_R:-30} whole_step=${WHOLE_STEP:-0.005} repeat=${REPEAT:-3} long=${LONG:-20}
duration=0.45 fine_step=0.0002 row=0.006
methods=${METHODS:-ep4:0.006 ep4:0.003 ep4:0.001 newmark:0.003 newmark:0.001 imexv:0.003 imexv:0.001}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mkdir -p "$out"

median() { sort -g | awk '{ x[NR] = $1 } END { if (NR) print x[int((NR + 1) / 2)] }'; }

# probes MODEL: the options that record every vertex of the sample.
probes() {
  local count
  count=$(grep -a -m1 -A1 '^\$Nodes' "$root/assets/meshes/$1.msh" | tail -n 1)
  awk -v n="$count" -v p="${PROBES:-800}" 'BEGIN {
    for (i = 0; i < p; i++) printf "--probe vertex:%d ", int((i + 0.5) * n / p) }'
}

# move MODEL ELEMENTS STEP EVERY: OUT/MODEL/whole-ELEMENTS-STEP.csv, the whole mesh, and its user time.
move() {
  local work=$out/$1 name=$out/$1/whole-$2-$3
  [ -s "$name.csv" ] && return
  # shellcheck disable=SC2046
  { TIMEFORMAT=%U; time "$bin/tremolo-precompute" reference "$root/assets/meshes/$1.msh" \
    --config "$root/assets/models/$1.toml" --order "$2" --load square --step "$3" --every "$4" \
    --duration "$duration" --threads 1 $(probes "$1") --out "$name.run" --json >"$name.json" 2>"$name.log"; } 2>"$name.time" ||
    { tail -n 2 "$name.log" >&2; return 1; }
  mv "$name.run/run.csv" "$name.csv"
  rmdir "$name.run"
}

# make MODEL ELEMENTS REFINED NAME OPTIONS...: OUT/MODEL/ELEMENTS-REFINED-NAME.tremolo and .time.
make() {
  local name=$out/$1/$2-$3-$4 model=$1 elements=$2 refined=$3 solver=auto n
  # Multigrid would take hours on a refined mesh, so that one whose factor does not fit is left out.
  [ "$refined" = 0 ] || solver=cholmod
  shift 4
  [ -s "$name.tremolo" ] && [ -s "$name.time" ] && return
  rm -f "$name.times"
  for ((n = 0; n < repeat; n++)); do
    { TIMEFORMAT=%U; time "$bin/tremolo-precompute" "$root/assets/meshes/$model.msh" \
      --config "$root/assets/models/$model.toml" --order "$elements" --refine "$refined" "$@" \
      --threads 1 --solver "$solver" --memory "${MEMORY:-10GB}" -o "$name.part" 2>"$name.log"; } 2>>"$name.times" ||
      { tail -n 2 "$name.log" >&2; rm -f "$name.part"; return 1; }
    mv "$name.part" "$name.tremolo"
    awk -v s="$(tail -n 1 "$name.times")" -v l="$long" 'BEGIN { exit !(s > l) }' && break
  done
  median <"$name.times" >"$name.time"
}

basis() { # MODEL ELEMENTS REFINED NAME: of r coordinates, of the sample's own file, or of 20 modes (default)
  case $4 in
    own) make "$@" ;;
    default) make "$@" --linear-modes 20 --modes 30 --derivatives 3 ;;
    *)
      local k=$((($4 + 1) / 2))
      make "$@" --linear-modes $((k > 24 ? 24 : k)) --modes "$4" --derivatives 3 --keep-modes 0 ;;
  esac
}

# reduce MODEL BASIS METHOD STEP ROW TOLERANCE: OUT/MODEL/BASIS.METHOD-STEP-ROW.csv, rows every ROW seconds.
reduce() {
  local file=$out/$1/$2.tremolo name=$out/$1/$2.$3-$4-$5
  [ -s "$name.csv" ] && return
  # shellcheck disable=SC2046
  "$bin/tremolo" run "$file" --load square --integrator "$3" --step "$4" --tolerance "$6" --duration "$duration" \
    --every "$(awk -v r="$5" -v h="$4" 'BEGIN { printf "%d", r / h + 0.5 }')" $(probes "$1") --coordinate all \
    --out "$name.run" --json >"$name.json" 2>"$name.log" || { tail -n 1 "$name.log" >&2; return 0; }
  mv "$name.run/run.csv" "$name.csv"
  rm -r "$name.run"
}

# rate MODEL BASIS METHOD STEP: OUT/MODEL/BASIS.METHOD-STEP.rate, processor seconds a simulated second.
rate() {
  local name=$out/$1/$2.$3-$4 n
  [ -s "$name.rate" ] && return
  for ((n = 0; n < repeat; n++)); do
    "$bin/tremolo" run "$out/$1/$2.tremolo" --load square --integrator "$3" --step "$4" --duration 3 --json 2>/dev/null \
      >"$name.json" || return 0
    awk -v t="$(number "$name.json" microseconds_per_step)" -v h="$4" 'BEGIN { print 1e-6 * t / h }'
  done >"$name.rates"
  median <"$name.rates" >"$name.rate"
}

# limit COARSE FINE: run.csv of the limit of a mesh and the same refined once.
limit() {
  paste -d, "$1" "$2" | awk -F, -v OFS=, '
    { n = NF / 2
      if (NR > 1) for (i = 1; i <= n; i++) $i = $(i + n) + ($(i + n) - $i) / (2 ^ 1.5 - 1)
      for (i = 1; i <= n; i++) printf "%s%s", $i, i < n ? OFS : "\n" }'
}

# columns FILE: t and displacements alone, so that bases of different r, and whole meshes, have the same columns.
columns() {
  awk -F, -v OFS=, '
    NR == 1 { for (i = 1; i <= NF; i++) if ($i == "t" || $i ~ /^u[0-9]+[xyz]$/) keep[++n] = i }
    { for (i = 1; i <= n; i++) printf "%s%s", $keep[i], i < n ? OFS : "\n" }' "$1" >"$1.u"
}

# between A B: distance of the displacements of two run.csv, either may be missing.
between() {
  [ -s "$1" ] && [ -s "$2" ] || return 0
  columns "$1" && columns "$2"
  distance "$1.u" "$2.u" u
  rm -f "$1.u" "$2.u"
}

study() { # MODEL
  local model=$1 work=$out/$1 mesh r name entry elements
  mkdir -p "$work"
  for elements in $whole; do move "$model" "$elements" "$whole_step" 1; done
  for mesh in $meshes; do
    if [ "${mesh#*-}" = 0 ]; then
      for name in $orders own default; do basis "$model" "${mesh%-*}" 0 "$name"; done
    fi
    # A refined mesh that needs more memory is left out.
    basis "$model" "${mesh%-*}" "${mesh#*-}" "$mesh_r" || echo "$model: no mesh $mesh" >&2
  done
  parts "$model" >"$work/errors.csv"
  sums "$model" >"$work/sum.csv"
}

# The file of a mesh's error: ep4 at 1 ms in the basis of MESH_R coordinates.
mesh_motion() { echo "$out/$1/$2-$mesh_r.ep4-0.001-$row.csv"; }

parts() { # MODEL: rows of errors.csv
  local model=$1 work=$out/$1 mesh name entry elements method step base
  for mesh in $meshes; do
    [ -s "$work/$mesh-$mesh_r.tremolo" ] && reduce "$model" "$mesh-$mesh_r" ep4 0.001 "$row" 1e-6
  done
  if [ -s "$(mesh_motion "$model" 2-1)" ]; then
    limit "$(mesh_motion "$model" 2-0)" "$(mesh_motion "$model" 2-1)" >"$work/limit.csv"
  fi
  for mesh in $meshes; do
    echo "$model,mesh,$mesh,,$(between "$(mesh_motion "$model" "$mesh")" "$work/limit.csv"),"
  done
  for mesh in $meshes; do
    for name in $orders own default; do
      [ -s "$work/$mesh-$name.time" ] || continue
      echo "$model,precompute,$mesh,$name,,$(cat "$work/$mesh-$name.time")"
    done
  done
  for name in $orders own default; do
    for elements in 1 2; do
      base=$elements-0-$name
      [ -s "$work/whole-$elements-$whole_step.csv" ] && [ -s "$work/$base.tremolo" ] || continue
      reduce "$model" "$base" avf "$whole_step" "$whole_step" 1e-9
      echo "$model,basis,$elements-0,$name,$(between "$work/$base.avf-$whole_step-$whole_step.csv" \
        "$work/whole-$elements-$whole_step.csv"),"
    done
    base=2-0-$name
    [ -s "$work/$base.tremolo" ] || base=1-0-$name
    reduce "$model" "$base" ep4 "$fine_step" "$row" 1e-9
    for entry in $methods; do
      method=${entry%:*} step=${entry#*:}
      reduce "$model" "$base" "$method" "$step" "$row" 1e-6
      rate "$model" "$base" "$method" "$step"
      echo "$model,step,$entry,$name,$(between "$work/$base.$method-$step-$row.csv" \
        "$work/$base.ep4-$fine_step-$row.csv"),$(cat "$work/$base.$method-$step.rate" 2>/dev/null || true)"
    done
  done
  # A whole mesh has no error of the basis; that of its step is avf's in the largest basis.
  base=2-0-${orders##* }
  [ -s "$work/$base.tremolo" ] || base=1-0-${orders##* }
  reduce "$model" "$base" avf "$whole_step" 0.015 1e-9
  reduce "$model" "$base" ep4 "$fine_step" 0.015 1e-9
  for elements in $whole; do
    [ -s "$work/whole-$elements-$whole_step.csv" ] || continue
    echo "$model,whole,$elements-0,$whole_step,$(between "$work/$base.avf-$whole_step-0.015.csv" \
      "$work/$base.ep4-$fine_step-0.015.csv"),$(awk -v d="$duration" '{ print $1 / d }' \
      "$work/whole-$elements-$whole_step.time")"
  done
}

part() { # MODEL PART WHERE NAME: an error of errors.csv
  awk -F, -v p="$2" -v w="$3" -v n="$4" '$2 == p && $3 == w && $4 == n { print $5 }' "$out/$1/errors.csv"
}

# sums MODEL: rows of sum.csv, settings whose distance from a reference is measured at once. The reference is the
# whole quadratic mesh, for mesh and basis (both by the same steps), and the basis of MESH_R coordinates of the refined
# quadratic mesh, ep4 at 1 ms, for all three: then the basis error is the distance from MESH_R coordinates.
sums() {
  local model=$1 work=$out/$1 mesh name entry truth apart
  # The distance of both orders' meshes, by their bases and directly.
  truth=$work/whole-2-$whole_step.csv
  [ ! -s "$truth" ] || [ ! -s "$work/whole-1-$whole_step.csv" ] ||
    echo "$model,whole mesh,1-0,whole,same,$(between "$(mesh_motion "$model" 1-0)" "$(mesh_motion "$model" 2-0)"),0,0,$(
      between "$work/whole-1-$whole_step.csv" "$truth")"
  for mesh in 1-0 2-0; do
    for name in $orders; do
      [ -s "$work/$mesh-$name.tremolo" ] && [ -s "$work/2-0-$name.tremolo" ] || continue
      truth=$work/whole-2-$whole_step.csv
      if [ "$mesh" = 1-0 ] && [ -s "$truth" ]; then
        reduce "$model" "$mesh-$name" avf "$whole_step" "$whole_step" 1e-9
        apart=$(between "$(mesh_motion "$model" $mesh)" "$(mesh_motion "$model" 2-0)")
        echo "$model,whole mesh,$mesh,$name,same,$apart,$(part "$model" basis 2-0 "$name"),0,$(
          between "$work/$mesh-$name.avf-$whole_step-$whole_step.csv" "$truth")"
      fi
      truth=$(mesh_motion "$model" 2-1)
      [ "$name" != "$mesh_r" ] && [ -s "$truth" ] || continue
      apart=$(between "$(mesh_motion "$model" $mesh)" "$truth")
      reduce "$model" "2-0-$name" ep4 0.001 "$row" 1e-6
      for entry in ep4:0.003 newmark:0.003; do
        reduce "$model" "$mesh-$name" "${entry%:*}" "${entry#*:}" "$row" 1e-6
        echo "$model,refined,$mesh,$name,$entry,$apart,$(
          between "$work/2-0-$name.ep4-0.001-$row.csv" "$(mesh_motion "$model" 2-0)"),$(
          part "$model" step "$entry" "$name"),$(
          between "$work/$mesh-$name.${entry%:*}-${entry#*:}-$row.csv" "$truth")"
      done
    done
  done
}

for model in $models; do study "$model"; done

{ echo "model,part,where,name,error,seconds"
  for model in $samples; do cat "$out/$model/errors.csv" 2>/dev/null || true; done; } >"$out/errors.csv"
{ echo "model,reference,mesh,basis,step,mesh_error,basis_error,step_error,direct"
  for model in $samples; do cat "$out/$model/sum.csv" 2>/dev/null || true; done; } >"$out/sum.csv"
"$root/tests/charts/frontier.py" "$bin" "$out" "$out/frontier.html" "$out/frontier.png"
cat "$out/table.md"
