#!/usr/bin/env bash
# What the last build of each file took, by target and by file: seconds of one core, where as many files are
# compiled at once as there are cores. usage: build_times.sh [BUILD [FILES]]
set -eu
log=${1:-build}/.ninja_log
[ -r "$log" ] || { echo "build_times.sh: $log: cannot read it: build with ninja first" >&2; exit 1; }
# start, end (ms), time stamp, output, hash; the last line of an output counts.
awk -F'\t' -v files="${2:-12}" '
  /^#/ { next }
  $4 ~ /\.(o|gch)$/ { seconds[$4] = ($2 - $1) / 1000 }
  END {
    sort = "sort -k1,1nr"
    for (name in seconds) {
      target = name
      sub(/.*CMakeFiles\//, "", target)
      sub(/\.dir.*/, "", target)
      sum[target] += seconds[name]
      ++count[target]
      all += seconds[name]
    }
    printf "%8.1f s in all\n\n", all
    for (target in sum) printf "%8.1f s %4d files  %s\n", sum[target], count[target], target | sort
    close(sort)
    print ""
    sort = sort " | head -n " files
    for (name in seconds) printf "%8.1f s  %s\n", seconds[name], name | sort
    close(sort)
  }' "$log"
