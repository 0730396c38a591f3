#!/usr/bin/env python3
"""error_against_r.py BIN ERROR.csv PAGE.html [PICTURE.png]: what a basis and what a step leave out, over r,
of what tests/bench/error_against_r.sh measured."""
import csv
import sys

import report

if len(sys.argv) not in (4, 5):
    sys.exit(__doc__)
bin_dir, table, page = sys.argv[1:4]
with open(table, encoding="utf-8") as file:
    rows = list(csv.DictReader(file))
models = list(dict.fromkeys(row["model"] for row in rows))


def points(chosen, column):
    kept = [row for row in chosen if row[column]]
    return [int(row["r"]) for row in kept], [float(row[column]) for row in kept]


charts = []
for load in ("impulse", "square", "sine"):
    reduction, integration = [], []
    for model, colour in zip(models, report.INKS):
        here = [row for row in rows if row["model"] == model and row["load"] == load]
        by_r = [row for row in here if row["basis"].isdigit()]
        reduction.append(report.curve(model, *points(by_r, "reduction"), colour=colour))
        aimed = [row for row in here if row not in by_r]
        reduction.append(report.curve("", *points(aimed, "reduction"), "points", colour))
        integration.append(report.curve(model, *points(by_r, "ep4"), colour=colour))
        integration.append(report.curve("", *points(by_r, "newmark"), "points", colour))
    for what, curves, least in (("reduction; alone: --target-error", reduction, 5e-4),
                                ("integration, ep4; alone: newmark", integration, 3e-7)):
        charts.append(report.chart(f"{load}, {what}", curves, x_label="coordinates r", log_y=True, x_range=[3, 62],
                                   y_range=[least, 2]))
report.write(page, "Error against r", "", charts, 2, 300, "", f"{bin_dir}/tremolo-lab",
             sys.argv[4] if len(sys.argv) == 5 else None, (1100, 1140))
