#!/usr/bin/env bash
# table.sh ROWS.tsv...: the rows as a table. Exit code 6 if one was missed, 1 if there are none.
cat "$@" | awk -F '\t' '
BEGIN { split("case|what|measured|expected|off|criterion|", cell, "|"); keep() }
{ for (c = 1; c <= 7; c++) cell[c] = $c; keep(); if ($7 == "MISSED") missed++ }
function keep(    c) {
  n++
  for (c = 1; c <= 7; c++) {
    text[n, c] = cell[c]
    if (length(cell[c]) > wide[c]) wide[c] = length(cell[c])
  }
}
END {
  for (i = 1; i <= n; i++) {
    line = ""
    for (c = 1; c <= 7; c++)
      line = line sprintf(c == 3 || c == 4 || c == 5 ? "%*s  " : "%-*s  ", wide[c], text[i, c])
    sub(/ +$/, "", line)
    print line
  }
  if (n == 1) exit 1
  if (missed) { print missed " missed"; exit 6 }
}'
