#!/usr/bin/env bash
# Prints one HTML page, complete in itself, about three runs of the same scene.
# usage: assets/render/page.sh DIR > page.html
# Reads DIR/imexv/surface-*.png, DIR/energy.svg and DIR/{imexv,newmark,ep4}/report.json.
set -euo pipefail

[ $# -eq 1 ] || { echo "usage: $0 DIR" >&2; exit 2; }
dir=$1
for file in energy.svg imexv/report.json newmark/report.json ep4/report.json; do
  [ -f "$dir/$file" ] || { echo "$0: $dir/$file: no such file" >&2; exit 1; }
done

# The value of a key of the report; a dash where it is absent or null.
value() {
  local found
  found=$(sed -n "s/^  \"$2\": \(.*[^,]\),\{0,1\}\$/\1/p" "$dir/$1/report.json" | sed 1q)
  found=${found#\"}
  found=${found%\"}
  if [ -z "$found" ] || [ "$found" = null ]; then echo "&ndash;"; else echo "$found"; fi
}

# Four significant digits are enough to read; what is not a number stays as it is.
short() {
  local LC_ALL=C
  if [[ $1 =~ ^-?[0-9]+\.[0-9]+(e[-+]?[0-9]+)?$ ]]; then printf '%.4g' "$1"; else printf '%s' "$1"; fi
}

row() {
  printf '<tr><th>%s</th><td>%s</td><td>%s</td><td>%s</td></tr>\n' "$2" \
    "$(short "$(value imexv "$1")")" "$(short "$(value newmark "$1")")" "$(short "$(value ep4 "$1")")"
}

body=$(value imexv body)
cat <<END
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Tremolo: the $body</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
h1 { font-weight: 600 }
.shapes { display: grid; grid-template-columns: repeat(auto-fill, minmax(17rem, 1fr)); gap: .6rem }
.shapes img { width: 100%; border-radius: .3rem; display: block }
svg { max-width: 100%; height: auto }
table { border-collapse: collapse }
th, td { padding: .25rem .9rem; border-bottom: 1px solid #ddd; text-align: right }
th:first-child { text-align: left; font-weight: 400 }
</style>
</head>
<body>
<h1>The $body, $(short "$(value imexv duration)") s in steps of $(short "$(value imexv step)") s</h1>
<p>Pushed by a $(value imexv load) load, then left alone. The shapes are IMEXv's, in the order of time.</p>
<div class="shapes">
END
count=0
for picture in "$dir"/imexv/surface-*.png; do
  [ -f "$picture" ] || continue
  count=$((count + 1))
  printf '<img alt="shape %d" src="data:image/png;base64,' "$count"
  base64 "$picture" | sed -e :a -e N -e '$!ba' -e 's/\n//g'
  printf '">\n'
done
echo '</div>'
echo '<h2>Energy</h2>'
# An XML declaration is not allowed in the middle of a page.
sed -e '/^<?xml/d' -e '/^<!DOCTYPE/d' "$dir/energy.svg"
echo '<h2>Figures</h2>'
echo '<table>'
printf '<tr><th></th><td>%s</td><td>%s</td><td>%s</td></tr>\n' "$(value imexv integrator)" \
  "$(value newmark integrator)" "$(value ep4 integrator)"
row steps "steps"
row reached "reached, s"
row microseconds_per_step "time a step, &micro;s"
row real_time_factor "faster than real time, times"
row iterations_per_step "iterations a step"
row energy_reference "energy after the push, J"
row energy_final "energy at the end, J"
row energy_drift_max "largest relative drift of the energy"
row low_modes "modes stepped explicitly"
row high_modes "modes stepped implicitly"
echo '</table>'
echo '</body>'
echo '</html>'
