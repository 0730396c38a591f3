# Readers that scripts of tests/bench share; to be sourced, with $bin set to the folder of the programs.

# distance A B [PREFIX]: max |a - b| / max |b| of two run.csv with rows at the same times, over the columns of
# PREFIX and a number (q: coordinates, the default; u: displacements); empty if one broke off.
distance() {
  [ -s "$1" ] && [ -s "$2" ] && [ "$(wc -l < "$1")" = "$(wc -l < "$2")" ] || return 0
  paste -d, "$1" "$2" | awk -F, -v name="^${3:-q}[0-9]+[xyz]?\$" '
    NR == 1 { for (i = 1; i <= NF; i++) if ($i ~ name) column[++count] = i; next }
    { off = 0; size = 0
      for (i = 1; i <= count / 2; i++) {
        a = $column[i]; b = $column[i + count / 2]; off += (a - b)^2; size += b * b }
      if (off > worst) worst = off
      if (size > largest) largest = size }
    END { if (largest > 0) printf "%.6g", sqrt(worst / largest) }'
}

field() { # FILE NAME: a number that inspect prints
  "$bin/tremolo" inspect "$1" --json | sed -n "s/^ *\"$2\": *\([0-9]*\).*/\1/p" | head -n 1
}

# number FILE NAME: the first number of that name in the JSON, or nothing.
number() { sed -n "s/^ *\"$2\": *\([-+0-9.e]*\).*/\1/p" "$1" | head -n 1; }

percent() { # X: as a table prints it, - for nothing
  [ -z "$1" ] && echo - || awk -v x="$1" 'BEGIN { printf "%.2g %%\n", 100 * x }'
}
