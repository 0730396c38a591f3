#!/usr/bin/env bash
# Makes the picture of the six sample models at rest with `tremolo view`, three beside each other.
# usage: assets/render/models.sh OUT.png [BUILD]   (ffmpeg puts them together)
set -euo pipefail
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
  echo "usage: $0 OUT.png [BUILD]" >&2
  exit 2
fi
here=$(cd "$(dirname "$0")" && pwd)
picture=$1 build=${2:-$here/../../build}
command -v ffmpeg >/dev/null || { echo "$0: ffmpeg is not installed" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

count=0
# show NAME CAMERA COLOUR: the camera as of --camera.
show() {
  "$build/bin/tremolo" view "$build/models/$1.tremolo" --load none --offscreen --frames 1 --size 480x360 \
    --camera "$2" --paint "$3" --lights 64 --out "$work/$1"
  mv "$work/$1/frame-000000.png" "$work/model-$count.png"
  count=$((count + 1))
}
show beam 22,22,0.9 '#cc3820'
show basket 18,21,0.9 '#c78c47'
show bridge 28,19,0.9 '#4d6b80'
show horse 12,9,0.9 '#a86638'
show tower 25,11,0.9 '#6b5442'
show heart 9,9,0.9 '#b82624'
ffmpeg -v error -y -i "$work/model-%d.png" -frames:v 1 -filter_complex \
  "tile=3x2:padding=6:color=white,split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=floyd_steinberg" \
  "$work/models.png"
mv "$work/models.png" "$picture"
