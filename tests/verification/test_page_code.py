"""Every Python block of README and of the pages runs as it stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.pages.code import blocks, run_page

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    path
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if any(block.language == "python" for block in blocks(path.read_text(encoding="utf-8")))
]
#: Pages that compile laws of their own, or are the longest run.
SLOW = {"docs/laws.md"}


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.slow if name(path) in SLOW else ())
        for path in PAGES
    ],
    ids=name,
)
def test_a_page_runs(path, tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    run_page(path, tmp_path)


def test_the_slow_pages_are_there():
    assert {name(path) for path in PAGES} > SLOW
