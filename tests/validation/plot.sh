#!/usr/bin/env bash
# plot.sh OUT_DIR PNG: of what run.sh left in OUT_DIR, how the error falls with the cell, and CSM3's
# motion by the full and the reduced model.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=${1:?usage: plot.sh OUT_DIR PNG} png=${2:?usage: plot.sh OUT_DIR PNG}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# errors CASE LOG COMPONENT EXPECTED: cells, error in percent, of CASE/full_*LOG.json.
errors() {
  local file n
  for file in "$out/$1"/full_*"$2".json; do
    n=${file##*/full_}
    tr -d '\n ' <"$file" | grep -o '"displacement":\[[^]]*' | sed 's/.*\[//' |
      awk -F, -v n="${n%%[_.]*}" -v c="$3" -v e="$4" \
        '{ off = $c / e - 1; print n, 100 * (off < 0 ? -off : off) }'
  done | sort -n
}
value() { awk -F, -v c="$1" -v q="$2" '$1 == c && $2 == q { print $3 }' "$here/published.csv"; }
errors csm1 '' 2 "$(value csm1 u_y)" >"$work/csm1_y"
errors csm1 '' 1 "$(value csm1 u_x)" >"$work/csm1_x"
errors elastica _2 2 "$(value elastica 'w 2')" >"$work/elastica"
strip=$(awk -f "$here/closed_forms.awk" -f <(echo 'BEGIN { print -0.02 * built_in_strip(64) }'))
errors built_in _64 2 "$strip" >"$work/built_in"

run=$out/csm3/both/run.csv
column() { head -n 1 "$run" | tr ',' '\n' | grep -n "^$1[0-9]*y\$" | cut -d: -f1; }
mean=$(value csm3 'u_y mean') amplitude=$(value csm3 'u_y amplitude')
gnuplot <<PLOT
set terminal pngcairo size 1100,400 font 'Sans,10'
set output '$work/plot.png'
set multiplot layout 1,2
set logscale xy
set xlabel 'cells across the thickness'
set ylabel 'off what is published, %'
set xrange [3.5:30]
set xtics (4, 6, 8, 12, 16, 24)
set key bottom left
plot '$work/csm1_x' with linespoints pt 7 title 'CSM1, u_x', \
     '$work/csm1_y' with linespoints pt 5 title 'CSM1, u_y', \
     '$work/elastica' with linespoints pt 9 title 'elastica, P = 2, w', \
     '$work/built_in' with linespoints pt 13 title 'built-in strip, load 64', \
     90/x**2 with lines dt 2 lc 'grey50' title 'order 2'
unset logscale
set datafile separator ','
set xlabel 't, s'
set ylabel 'CSM3: u_y of A, m'
set xrange [0:4]
set yrange [-0.14:0.035]
set xtics auto
set key top right horizontal
plot '$run' skip 1 using 1:$(column u) with lines lw 2 lc 'skyblue' title 'full', \
     '$run' skip 1 using 1:$(column r) with lines dt 2 lc 'black' title '15 coordinates', \
     $mean + $amplitude with lines dt 3 lc 'red' title 'Turek and Hron', \
     $mean - $amplitude with lines dt 3 lc 'red' notitle
PLOT
mv "$work/plot.png" "$png"
