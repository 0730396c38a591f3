"""Runs a notebook and writes it as one HTML page: text, code, what was printed, and the pictures it saved.

usage: PYTHONPATH=build/python /usr/bin/python3 runtime/apps/python/page/render_notebook.py NOTEBOOK.py OUT.html
"""

import base64
import contextlib
import html
import io
import os
import pathlib
import re
import sys
import tempfile

STYLE = """body { font: 16px/1.5 sans-serif; max-width: 56em; margin: 2em auto; padding: 0 1em; color: #222 }
pre { background: #f4f4f2; padding: .7em 1em; overflow-x: auto; font-size: 13px; line-height: 1.4 }
pre.out { background: none; border-left: 3px solid #bbb; color: #555 } img { max-width: 100% }"""


def cells_of(text):
    """(is text, lines) of each cell."""
    for cell in re.split(r"^# %%", text, flags=re.M)[1:]:
        head, _, body = cell.partition("\n")
        yield "[markdown]" in head, body.strip("\n")


def prose(body):
    """The few forms of Markdown that notebooks here use."""
    text = "\n".join(line[2:] if line.startswith("# ") else line[1:] for line in body.splitlines())
    out = []
    for paragraph in re.split(r"\n\n+", text.strip()):
        escaped = re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(paragraph))
        out.append(f"<h1>{escaped[2:]}</h1>" if escaped.startswith("# ") else f"<p>{escaped}</p>")
    return "\n".join(out)


def render(path):
    """The page of a notebook."""
    names = {"__name__": "__main__"}
    parts = []
    for is_text, body in cells_of(pathlib.Path(path).read_text(encoding="utf-8")):
        if is_text:
            parts.append(prose(body))
            continue
        before = set(os.listdir())
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(body, path, "exec"), names)  # pylint: disable=exec-used
        parts.append(f"<pre>{html.escape(body)}</pre>")
        if printed.getvalue():
            parts.append(f'<pre class="out">{html.escape(printed.getvalue())}</pre>')
        for picture in sorted(name for name in set(os.listdir()) - before if name.endswith(".png")):
            data = base64.b64encode(pathlib.Path(picture).read_bytes()).decode()
            parts.append(f'<p><img alt="{picture}" src="data:image/png;base64,{data}"></p>')
    title = pathlib.Path(path).stem.replace("_", " ")
    return (f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>\n' +
            "\n".join(parts) + "\n</html>\n")


def main():
    source, target = (os.path.abspath(each) for each in sys.argv[1:3])
    os.environ["MPLBACKEND"] = "Agg"
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        page = render(source)
        os.chdir("/")
    pathlib.Path(target).write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
