#!/usr/bin/env python3
"""orders.py BIN OUT PAGE.html [PICTURE.png] [orders]: how far linear and quadratic elements are off, over unknowns
and over the seconds of the whole program, of what tests/validation's shapes.sh, or orders.sh, left in OUT."""
import pathlib
import sys

import report

words = sys.argv[1:]
case = "orders" if words[-1:] == ["orders"] else "shapes"
if case == "orders":
    words.pop()
if len(words) not in (3, 4):
    sys.exit(__doc__)
bin_dir, out, page = words[:3]
table = pathlib.Path(out) / case / "points.tsv"
rows = [line.split("\t") for line in table.read_text(encoding="utf-8").splitlines()]
bodies = list(dict.fromkeys(row[0] for row in rows))
error = "off what is published" if case == "orders" else "error of the lowest frequency"
charts = []
for column, x_label in ((3, "unknowns"), (4, "s, the whole program")):
    curves = []
    for body, ink in zip(bodies, report.INKS):
        for order, style, label in (("2", "lines and points", body), ("1", "dashes", "")):
            here = sorted((float(row[column]), 100 * abs(float(row[5]))) for row in rows if row[:2] == [body, order])
            curves.append(report.curve(label, [x for x, _ in here], [y for _, y in here], style, ink))
    charts.append(report.chart(f"{error}; dashed: linear elements", curves, x_label=x_label, y_label="%", log_x=True, log_y=True))
report.write(page, "Linear and quadratic elements", "", charts, 2, 420, "", f"{bin_dir}/tremolo-lab",
             words[3] if len(words) == 4 else None, (1100, 640))
