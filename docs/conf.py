"""Sphinx: ``make docs``.  Pages are Markdown; the API is read from docstrings."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
_PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = "sphsolid"
author = _PROJECT["authors"][0]["name"]
version = release = _PROJECT["version"]
copyright = f"2026, {author}"

extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = f"sphsolid {version}"
html_show_sourcelink = False
nitpicky = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True, "show-inheritance": False}

_INDENTED = re.compile(r"^( *)\S")


def _equations(
    app: object, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Set blocks that stand in as code: equations and file layouts of docstrings."""
    made: list[str] = []
    base, inside = 0, False
    for number, line in enumerate(lines):
        found = _INDENTED.match(line)
        indent = len(found[1]) if found else None
        after_blank = number > 0 and not lines[number - 1].strip()
        if inside and indent is not None and indent <= base:
            inside = False
        if not inside and indent is not None:
            listed = _in_list(lines, number)
            if after_blank and indent >= 4 and not listed:
                inside, base = True, 0
                made += [".. code-block:: text", ""]
            else:
                base = 0
        made.append(line)
    lines[:] = made


def _in_list(lines: list[str], number: int) -> bool:
    """Whether an indented line goes on with an item of a list or a directive above it."""
    for line in reversed(lines[:number]):
        if line.strip() and not line.startswith(" "):
            return bool(re.match(r"(\* |- |\.\. |:)", line)) or line.rstrip().endswith("::")
    return False


#: Files beside ``docs/`` that pages link to, and the page of the site that stands for each.
_PAGES = {
    "README.md": "index.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md",
}  # fmt: skip
_LINK = re.compile(r"\[([^\]]*)\]\(((?:\.\./)*)([\w/]+\.md)\)")


def _links(text: str, depth: int) -> str:
    """Links to files of the repository as links of the site; ``depth`` is that of its root."""

    def of_the_site(found: re.Match[str]) -> str:
        words, up, name = found.groups()
        if up.count("../") != depth:
            return found[0]
        if name in _PAGES:
            return f"[{words}](/{_PAGES[name]})"
        return words if name.startswith("examples/") else found[0]

    return _LINK.sub(of_the_site, text)


def _source(app: object, name: str, source: list[str]) -> None:
    source[0] = _links(source[0], name.count("/") + 1)


def _included(app: object, path: Path, name: str, source: list[str]) -> None:
    source[0] = _links(source[0], 0)


def setup(app: Any) -> None:
    """Connect what changes docstrings and links."""
    app.connect("autodoc-process-docstring", _equations)
    app.connect("source-read", _source)
    app.connect("include-read", _included)
