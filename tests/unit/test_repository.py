"""Facts that are written down in more than one place agree."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_version_is_the_same_everywhere():
    version = PROJECT["project"]["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {version}\n" in citation
    assert version in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_ci_runs_the_test_line():
    ci = ROOT / ".ci" / "run"
    assert os.access(ci, os.X_OK)
    assert re.search(r"^make test$", ci.read_text(encoding="utf-8"), re.M)
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in ("convergence", "quick", "test", "lint", "clean"):
        assert re.search(rf"^{target}:", makefile, re.M), target
    for tool in ("ruff check .", "mypy", 'pytest -m "not slow"'):
        assert tool in makefile


def test_results_name_no_folder_of_the_machine_they_were_made_on():
    for path in sorted((ROOT / "reports").rglob("*")):
        if path.suffix in (".csv", ".json", ".md") and "partial" not in path.parts:
            text = path.read_text(encoding="utf-8")
            for folder in ("/home/", "/root/", "/tmp/", "/Users/", "C:\\", str(ROOT)):
                assert folder not in text, f"{path.relative_to(ROOT)} names {folder}"
