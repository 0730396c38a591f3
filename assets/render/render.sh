#!/usr/bin/env bash
# Renders a surface of a sample model with POV-Ray.
# usage: assets/render/render.sh NAME SURFACE.inc OUT.png [WIDTH HEIGHT]
# SURFACE.inc comes from `tremolo-mesh --surface` or `tremolo run` (surface format inc).
set -euo pipefail

if [ $# -ne 3 ] && [ $# -ne 5 ]; then
  echo "usage: $0 NAME SURFACE.inc OUT.png [WIDTH HEIGHT]" >&2
  exit 2
fi
name=$1 surface=$2 picture=$3 width=${4:-640} height=${5:-480}
here=$(cd "$(dirname "$0")" && pwd)
if [ ! -f "$here/$name.inc" ]; then
  echo "$0: no view for '$name'; there are: $(cd "$here" && echo *.inc | sed 's/\.inc//g')" >&2
  exit 2
fi
[ -f "$surface" ] || { echo "$0: $surface: no such file" >&2; exit 1; }
command -v povray > /dev/null || { echo "$0: povray is not installed" >&2; exit 1; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# One file, so that POV-Ray's rules about what it may read do not matter.
cat "$surface" "$here/$name.inc" "$here/scene.pov" > "$work/scene.pov"
if ! (cd "$work" && povray +Iscene.pov +Oout.png +FN8 "+W$width" "+H$height" +Q9 +A0.2 +AM2 +R3 \
      -D -V > povray.log 2>&1); then
  tail -n 20 "$work/povray.log" >&2
  exit 1
fi
mv "$work/out.png" "$picture"
