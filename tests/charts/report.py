"""Reports as tremolo-lab makes pages of them (runtime/io/page/document.h), and pictures of those pages."""
import json
import os
import pathlib
import shutil
import subprocess

# For curves without a label, which get the colour of those that they belong to.
INKS = ["#0060a8", "#d95f02", "#1b9e77", "#7b3fa0", "#cc1166", "#806020", "#444444", "#2aa0c8"]


def curve(label, x, y, style="lines and points", colour=""):
    return {"label": label, "style": style, "colour": colour, "x": list(x), "y": list(y)}


def chart(title, curves, x_label="", y_label="", log_x=False, log_y=False, x_range=None, y_range=None):
    return {"title": title, "x_label": x_label, "y_label": y_label, "log_x": log_x, "log_y": log_y,
            "zero": False, "time": False, "x_range": x_range, "y_range": y_range, "curves": curves}


def write(path, title, subtitle, charts, columns, height, caption, lab, picture=None, size=(1100, 560)):
    """path: of the page; report.json stands beside it. picture: a .png of it, where Chromium is installed."""
    path = pathlib.Path(path)
    report = {"title": title, "subtitle": subtitle, "sections": [{"title": "", "parts": [
        {"kind": "charts", "charts": {"caption": caption, "columns": columns, "height": height, "charts": charts}}]}]}
    source = path.with_name("report.json")
    source.write_text(json.dumps(report, indent=1) + "\n")
    subprocess.run([lab, "page", str(source), "-o", str(path)], check=True)
    if picture:
        photograph(path, picture, size)


def photograph(page, picture, size):
    chromium = shutil.which("chromium") or shutil.which("chromium-headless-shell")
    if not chromium:
        print(f"no chromium: {page} is made, {picture} is not")
        return
    width, height = size
    subprocess.run([chromium, "--headless=new", "--no-sandbox", "--hide-scrollbars", "--force-color-profile=srgb",
                    "--virtual-time-budget=5000", f"--window-size={width},{height}",
                    f"--screenshot={os.path.abspath(picture)}", pathlib.Path(page).resolve().as_uri()],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
