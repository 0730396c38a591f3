#!/usr/bin/env python3
"""validation.py BIN OUT PAGE.html [PICTURE.png]: of what tests/validation/run.sh left in OUT, how the error falls with
the cell, and CSM3's motion by the full and the reduced model."""
import csv
import json
import pathlib
import re
import subprocess
import sys

import report

if len(sys.argv) not in (4, 5):
    sys.exit(__doc__)
bin_dir, out, page = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
cases = pathlib.Path(__file__).resolve().parent.parent / "validation"
with open(cases / "published.csv", encoding="utf-8") as file:
    published = {(row[0], row[1]): float(row[2]) for row in csv.reader(line for line in file if not line.startswith("#"))
                 if re.match(r"[-+.0-9]", row[2])}


def displacement(found):
    """The first displacement in a file of the reference."""
    if isinstance(found, dict):
        if isinstance(found.get("displacement"), list):
            return found["displacement"]
        found = list(found.values())
    for inner in found if isinstance(found, list) else []:
        if (moved := displacement(inner)) is not None:
            return moved
    return None


def errors(case, ending, component, expected):
    """Cells across, and how far off in per cent, of CASE/full_N..ENDING.json."""
    found = []
    for file in (out / case).glob(f"full_*{ending}.json"):
        cells = re.match(r"full_(\d+)", file.name)
        moved = displacement(json.loads(file.read_text(encoding="utf-8")))
        if cells and moved:
            found.append((int(cells[1]), 100 * abs(moved[component] / expected - 1)))
    return zip(*sorted(found))


strip = float(subprocess.run(["awk", "-f", str(cases / "closed_forms.awk"), "-f", "/dev/stdin"], text=True, check=True,
                             input="BEGIN { print -0.02 * built_in_strip(64) }", capture_output=True).stdout)
curves = [report.curve(label, *errors(case, ending, component, expected))
          for label, case, ending, component, expected in (
              ("CSM1, u_x", "csm1", "", 0, published["csm1", "u_x"]),
              ("CSM1, u_y", "csm1", "", 1, published["csm1", "u_y"]),
              ("elastica, P = 2, w", "elastica", "_2", 1, published["elastica", "w 2"]),
              ("built-in strip, load 64", "built_in", "_64", 1, strip))]
curves.append(report.curve("order 2", [4, 24], [90 / 16, 90 / 576], "dashes", "#888888"))
charts = [report.chart("off what is published", curves, x_label="cells across the thickness", y_label="%", log_x=True,
                       log_y=True)]

with open(out / "csm3" / "both" / "run.csv", encoding="utf-8") as file:
    moved = [row for row in csv.DictReader(file) if float(row["t"]) <= 4]
names = {kind: next(name for name in moved[0] if re.fullmatch(rf"{kind}\d*y", name)) for kind in "ur"}
times = [float(row["t"]) for row in moved]
mean, amplitude = published["csm3", "u_y mean"], published["csm3", "u_y amplitude"]
bounds = [report.curve("Turek and Hron", [0, 4], [mean + sign * amplitude] * 2, "dashes", "#cc3311") for sign in (1, -1)]
charts.append(report.chart("CSM3: u_y of A", [
    report.curve("full", times, [float(row[names["u"]]) for row in moved], "lines", "#66aadd"),
    report.curve("15 coordinates", times, [float(row[names["r"]]) for row in moved], "dashes", "#111111"), *bounds],
    x_label="t (s)", y_label="m", x_range=[0, 4]))
report.write(page, "Against what others published", "", charts, 2, 360, "", f"{bin_dir}/tremolo-lab",
             sys.argv[4] if len(sys.argv) == 5 else None, (1100, 620))
