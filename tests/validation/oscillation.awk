# Of a column of run.csv, for every whole oscillation: mean = (max + min) / 2, amplitude =
# (max - min) / 2 and frequency. One begins where the value falls through the record's middle.
#
#   awk -F, -v column=8 -f oscillation.awk run.csv
NR == 1 { next }
{
  t[++n] = $1
  v[n] = $column
  if (n == 1 || v[n] > top) top = v[n]
  if (n == 1 || v[n] < bottom) bottom = v[n]
}
END {
  middle = (top + bottom) / 2
  for (i = 2; i <= n; i++) {
    if (v[i - 1] > middle && v[i] <= middle) {
      start[++count] = t[i - 1] + (t[i] - t[i - 1]) * (v[i - 1] - middle) / (v[i - 1] - v[i])
      if (count > 1)
        printf "%.8g %.8g %.8g\n", (high + low) / 2, (high - low) / 2,
               1 / (start[count] - start[count - 1])
      high = low = middle
    }
    if (v[i] > high) high = v[i]
    if (v[i] < low) low = v[i]
  }
  if (count < 2) exit 1
}
