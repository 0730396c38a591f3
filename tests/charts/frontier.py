#!/usr/bin/env python3
"""frontier.py BIN OUT PAGE.html [PICTURE.png]: total error over time of every setting that OUT/errors.csv of
tests/bench/frontier.sh combines. Writes OUT/frontier.csv and OUT/table.md as well."""
import csv
import pathlib
import sys

import report

if len(sys.argv) not in (4, 5):
    sys.exit(__doc__)
bin_dir, out, page = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
SPAN = 30  # s, simulated after the precompute: what `tremolo run` does unless told otherwise
GOAL = 0.01
MESHES = {"1-0": "linear", "1-1": "linear, refined", "2-0": "quadratic", "2-1": "quadratic, refined"}
with open(out / "errors.csv", encoding="utf-8") as file:
    rows = list(csv.DictReader(file))
models = list(dict.fromkeys(row["model"] for row in rows))


def table_of(model, part, value):
    return {(row["where"], row["name"]): float(row[value]) for row in rows
            if row["model"] == model and row["part"] == part and row[value]}


def basis_error(errors, name):
    """Of the quadratic mesh, or of the linear one where the quadratic mesh was not moved."""
    for mesh in ("2-0", "1-0"):
        if (mesh, name) in errors:
            return errors[mesh, name], mesh[0]
    return None, ""


def settings(model):
    """Every combination of mesh, basis and step whose three errors and two times were measured."""
    mesh_errors = {where: error for (where, _), error in table_of(model, "mesh", "error").items()}
    basis_errors = table_of(model, "basis", "error")
    step_errors, rates = table_of(model, "step", "error"), table_of(model, "step", "seconds")
    for (mesh, name), seconds in table_of(model, "precompute", "seconds").items():
        basis, elements = basis_error(basis_errors, name)
        for (step, step_name), error in step_errors.items():
            if step_name != name or mesh not in mesh_errors or basis is None or (step, name) not in rates:
                continue
            yield {"model": model, "mesh": mesh, "basis": name, "step": step, "mesh_error": mesh_errors[mesh],
                   "basis_error": basis, "basis_of_elements": elements, "step_error": error,
                   "precompute": seconds, "run": rates[step, name]}
    whole_rates = table_of(model, "whole", "seconds")
    for (mesh, step), error in table_of(model, "whole", "error").items():
        if mesh in mesh_errors:
            yield {"model": model, "mesh": mesh, "basis": "whole", "step": f"avf:{step}",
                   "mesh_error": mesh_errors[mesh], "basis_error": 0.0, "basis_of_elements": mesh[0],
                   "step_error": error, "precompute": 0.0, "run": whole_rates[mesh, step]}


def frontier(points):
    """Those that no other beats in both error and time, by time."""
    best, kept = float("inf"), []
    for point in sorted(points, key=lambda p: (p["time"], p["total"])):
        if point["total"] < best:
            best = point["total"]
            kept.append(point)
    return kept


def percent(x):
    return f"{100 * x:.2g} %"


def seconds(x):
    if x == 0:
        return "–"
    if x < 0.1:
        return f"{1000 * x:.2g} ms"
    return f"{x:.2g} s" if x < 100 else f"{x:.0f} s"


def named(point):
    basis = {"own": "own file", "default": "20 modes"}.get(point["basis"], f"r = {point['basis']}")
    method, step = point["step"].split(":")
    what = "whole mesh" if point["basis"] == "whole" else f"{basis}, {method} {1000 * float(step):g} ms"
    return f"{MESHES[point['mesh']]}, {what}"


def parts(point):
    return " + ".join(f"{100 * point[part]:.2g}" for part in ("mesh_error", "basis_error", "step_error"))


everything, lines, notes, charts = [], [], [], []
for model in models:
    points = list(settings(model))
    for point in points:
        point["total"] = point["mesh_error"] + point["basis_error"] + point["step_error"]
        point["time"] = point["precompute"] + SPAN * point["run"]
    everything += points
    if not points:
        continue
    edge = frontier(points)
    met = [point for point in edge if point["total"] <= GOAL]
    goal = met[0] if met else edge[-1]
    lines.append(f"| {model}: {'to 1 %' if met else 'smallest'} | {named(goal)} | {parts(goal)} | {percent(goal['total'])} | "
                 f"{seconds(goal['precompute'])} | {seconds(goal['run'])} | | |")
    for name in ("own", "default"):
        for point in points:
            if (point["mesh"], point["basis"], point["step"]) != ("2-0", name, "ep4:0.003"):
                continue
            beside = next(p for p in edge if p["total"] <= point["total"])
            nearer = [p for p in edge if p["time"] <= point["time"]][-1]
            lines.append(f"| | {named(point)} | {parts(point)} | {percent(point['total'])} | "
                         f"{seconds(point['precompute'])} | {seconds(point['run'])} | "
                         f"{seconds(beside['time'])} | {percent(nearer['total'])} |")
            notes.append(f"{model}, {named(point)}: {seconds(point['time'])}, {percent(point['total'])}; as accurate: "
                         f"{named(beside)}, {seconds(beside['time'])}; in as much time: {named(nearer)}, "
                         f"{percent(nearer['total'])}")

    def curve(label, chosen, style, colour):
        return report.curve(label, [p["time"] for p in chosen], [100 * p["total"] for p in chosen], style, colour)

    curves = []
    for (mesh, label), ink in zip(MESHES.items(), report.INKS):
        reduced = [p for p in points if p["mesh"] == mesh and p["basis"] not in ("whole", "own", "default")]
        if reduced:
            curves.append(curve(label, frontier(reduced), "lines and points", ink))
    curves.append(curve("whole meshes", [p for p in points if p["basis"] == "whole"], "points", report.INKS[4]))
    curves.append(curve("own file and 20 modes", [p for p in points if p["basis"] in ("own", "default")
                                                  and (p["mesh"], p["step"]) == ("2-0", "ep4:0.003")], "points", "#000000"))
    curves.append(curve("frontier", edge, "dashes", report.INKS[6]))
    charts.append(report.chart(model, curves, x_label=f"s: precompute and {SPAN} simulated seconds", y_label="total error, %",
                               log_x=True, log_y=True, x_range=[0.1, 20000], y_range=[1, 100]))

fields = ["model", "mesh", "basis", "step", "mesh_error", "basis_error", "basis_of_elements", "step_error", "total",
          "precompute", "run", "time"]
with open(out / "frontier.csv", "w", encoding="utf-8", newline="") as file:
    writer = csv.DictWriter(file, fields)
    writer.writeheader()
    writer.writerows(everything)
(out / "table.md").write_text("\n".join([
    "| | setting | mesh + basis + step, % | total | precompute | a simulated second | as accurate | in as much time |",
    "|---|---|---:|---:|---:|---:|---:|---:|", *lines, "", *notes]) + "\n", encoding="utf-8")
report.write(page, "Time to a total error", "", charts, 3, 300, "", f"{bin_dir}/tremolo-lab",
             sys.argv[4] if len(sys.argv) == 5 else None, (1300, 860))
