"""Writes docs/python.md: its text is below, its API section is made of the docstrings.

usage: PYTHONPATH=build/python /usr/bin/python3 runtime/apps/python/page/make_page.py [OUT.md]
"""

import inspect
import pathlib
import re
import sys
import textwrap

import tremolo

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[3] / "docs" / "python.md"

GROUPS = [
    ("Making and loading models", ["load", "load_bytes", "precompute", "reference", "matrices", "box", "write_msh",
                                   "write_ply", "Mesh", "Reference"]),
    ("Model", ["Model"]),
    ("Body", ["Body", "integrators"]),
    ("World", ["world", "load_scene", "scene_text", "World"]),
    ("Tetrahedra and cloth", ["NodalBody", "NodalScene"]),
    ("Your own potential", ["own_body", "OwnBody", "own_integrators"]),
    ("Files of other programs", ["recorder", "Recorder"]),
    ("Programs", ["find_program", "run_program"]),
    ("Errors", ["Error", "FileError", "UsageError", "ContentError", "SolverError", "BoundError", "CriterionError"]),
]


def text_of(thing):
    """(signature, text) of a function's docstring; those of the module begin with a signature of C++."""
    doc = inspect.getdoc(thing) or ""
    name = getattr(thing, "__name__", "")
    found = re.match(rf"{re.escape(name)}\((.*)\) -> (.*)\n\n", doc) if name else None
    if not found:
        try:
            return plain(str(inspect.signature(thing))), doc
        except (TypeError, ValueError):
            return "", doc
    return plain("(" + found[1] + ")"), doc[found.end():]


def plain(signature):
    """Names and defaults alone: types are in the stubs and in the text."""
    signature = re.sub(r"\) ->.*$", ")", signature)
    depth, out, skipping = 0, "", False
    for c in signature:
        if c in "([{":
            depth += 1
        elif c in ")]}":
            depth -= 1
        if c == ":" and depth == 1 and not skipping:
            skipping = True
            continue
        if skipping:
            if (c == "," and depth == 1) or depth == 0 or (c == "=" and depth == 1):
                skipping = False
                out = out.rstrip()
            else:
                continue
        out += c
    out = re.sub(r"\s*=\s*", "=", out)
    out = re.sub(r"^\((self|self, )(, )?", "(", out)
    return out.replace("(, ", "(").replace("dtype('float64')", "float64")


def entry(head, text):
    """A definition: a line in bold code, then its text."""
    text = "\n".join(textwrap.fill(paragraph.replace("\n", " "), 120)
                     for paragraph in re.split(r"\n\n+", text.strip()))
    return f"**`{head}`**\n{text}\n"


def entries(name):
    """The lines of a function or a class with its members."""
    thing = getattr(tremolo, name)
    if not inspect.isclass(thing):
        signature, text = text_of(thing)
        yield entry(name + signature, text)
        return
    yield entry("class " + name, inspect.getdoc(thing) or "")
    if issubclass(thing, BaseException) or issubclass(thing, tuple):
        return
    for key, member in sorted(vars(thing).items(), key=lambda item: (not isinstance(item[1], property), item[0].lower())):
        if key.startswith("_"):
            continue
        variable = name.lower()
        if isinstance(member, property):
            yield entry(f"{variable}.{key}", inspect.getdoc(member) or "")
        else:
            signature, text = text_of(member)
            yield entry(f"{variable}.{key}{signature}", text)


def page():
    """The whole page."""
    parts = [(HERE / "page.md").read_text(encoding="utf-8").rstrip() + "\n"]
    parts.append("\n## All names\n\nThis section is made from the docstrings by `runtime/apps/python/page/make_page.py`.\n")
    for title, names in GROUPS:
        parts.append(f"\n### {title}\n\n" + "\n".join(line for name in names for line in entries(name)))
    return "".join(parts)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE
    target.write_text(page(), encoding="utf-8")
