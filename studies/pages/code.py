"""The code of Markdown pages: every Python block of a page, run in order as a reader would.

``python -m studies.pages.code docs/tutorial.md`` runs a page in an empty folder and keeps the
pictures that it makes in ``docs/pictures``.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies.engine.sources import ROOT

_FENCE = re.compile(r"^( *)```(\S*)\n(.*?)^\1```$", re.DOTALL | re.MULTILINE)
PICTURES = ROOT / "docs" / "pictures"


@dataclass(frozen=True)
class Block:
    """A block of code: its language, its text, and the line of the page that it begins after."""

    language: str
    text: str
    line: int


def blocks(page: str) -> list[Block]:
    """Every fenced block of a Markdown text."""
    return [
        Block(found[2], found[3], page.count("\n", 0, found.start()) + 1)
        for found in _FENCE.finditer(page)
    ]


def run_page(path: Path, folder: Path) -> dict[str, Any]:
    """Run the Python blocks of a page in ``folder``, one after the other; gives their names."""
    names: dict[str, Any] = {"__name__": path.stem}
    with _inside(folder):
        for block in blocks(path.read_text(encoding="utf-8")):
            if block.language == "python":
                # Lines of an error are those of the page.
                padded = "\n" * block.line + block.text
                exec(compile(padded, str(path), "exec"), names)
    return names


@contextmanager
def _inside(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def main(argv: list[str] | None = None) -> int:
    """Run pages and keep their pictures."""
    parser = argparse.ArgumentParser(prog="python -m studies.pages.code", description=__doc__)
    parser.add_argument("pages", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, default=PICTURES)
    options = parser.parse_args(argv)
    options.out.mkdir(parents=True, exist_ok=True)
    for page in options.pages:
        with tempfile.TemporaryDirectory() as folder:
            run_page(page.resolve(), Path(folder))
            for made in sorted(Path(folder).iterdir()):
                if made.suffix in (".png", ".gif"):
                    shutil.copy(made, options.out / made.name)
                    print(f"{page.name}: {made.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
