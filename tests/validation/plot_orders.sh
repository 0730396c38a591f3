#!/usr/bin/env bash
# plot_orders.sh OUT_DIR PICTURE.png [orders|shapes]: how far linear and quadratic elements are off, over
# unknowns and over the seconds of the whole program, from the points that orders.sh or shapes.sh (unless
# told otherwise) left in OUT_DIR.
set -euo pipefail
{ [ $# = 2 ] || [ $# = 3 ]; } ||
  { echo "usage: plot_orders.sh OUT_DIR PICTURE.png [orders|shapes]" >&2; exit 2; }
case_name=${3:-shapes}
points=$1/$case_name/points.tsv
[ -s "$points" ] || { echo "plot_orders.sh: no $points; $case_name.sh makes it" >&2; exit 1; }
what='error of the lowest frequency'
[ "$case_name" = orders ] && what='off what is published'
command -v gnuplot >/dev/null || { echo "plot_orders.sh: no gnuplot" >&2; exit 1; }
{
  echo "set terminal pngcairo size 1000,460 font 'sans,10' background 'white'"
  echo "set output '$2'"
  echo "set linetype 5 lc rgb '#8b6914'"
  echo "set datafile separator '\t'; set logscale xy; set grid lc rgb '#dddddd'"
  echo "set multiplot layout 1,2 margins 0.07,0.98,0.24,0.92 spacing 0.07,0"
  echo "set format y '%g %%'; set format x '10^{%L}'"
  for panel in "4:unknowns" "5:seconds"; do
    echo "set title '$what; linear dashed, quadratic solid'; set xlabel '${panel#*:}'"
    [ "${panel%%:*}" = 4 ] && echo "set key at screen 0.5,0.02 center bottom horizontal maxrows 1 samplen 2 width 2"
    [ "${panel%%:*}" = 5 ] && echo "set key off"
    plots=() color=0
    while read -r body; do
      color=$((color + 1))
      for order in 1 2; do
        pick="\"<awk -F'\\\\t' '\$1 == \\\"$body\\\" && \$2 == $order' '$points'\""
        style="with linespoints lw 2 lt $color pt $([ $order = 1 ] && echo "6 dt 2" || echo 7)"
        plots+=("$pick using ${panel%%:*}:(100 * abs(\$6)) $style $([ $order = 1 ] && echo notitle || echo "title '$body'")")
      done
    done < <(cut -f1 "$points" | awk '!seen[$0]++')
    (IFS=,; echo "plot ${plots[*]}")
  done
} | gnuplot
