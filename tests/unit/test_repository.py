"""Facts that are written down in more than one place agree."""

from __future__ import annotations

import datetime
import os
import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_version_is_the_same_everywhere():
    version = PROJECT["project"]["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {version}\n" in citation
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    dated = re.search(rf"^## \[{re.escape(version)}\] - (\d{{4}}-\d{{2}}-\d{{2}})$", changes, re.M)
    assert dated, "the changelog has no section of this version with its date"
    assert f"\ndate-released: {dated[1]}\n" in citation


def test_the_citation_has_what_the_format_asks_for():
    """As `cffconvert --validate` does for the parts that are used here (schema 1.2.0)."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert set(cited) == {
        "cff-version", "message", "type", "title", "abstract", "version", "date-released",
        "license", "authors", "keywords", "references",
    }  # fmt: skip
    assert cited["cff-version"] == "1.2.0"
    assert cited["type"] in ("software", "dataset")
    assert cited["license"] == PROJECT["project"]["license"]
    assert cited["authors"] == PROJECT["project"]["authors"]
    (paper,) = cited["references"]
    assert {"type", "title", "authors", "journal", "doi", "volume", "year"} <= set(paper)
    assert re.fullmatch(r"10\.\d{4,9}(\.\d+)?/\S+", paper["doi"])
    for person in paper["authors"]:
        assert set(person) == {"family-names", "given-names"}
    assert isinstance(paper["year"], int)
    assert isinstance(cited["date-released"], datetime.date)


def test_ci_runs_the_test_line():
    ci = ROOT / ".ci" / "run"
    assert os.access(ci, os.X_OK)
    assert re.search(r"^make test$", ci.read_text(encoding="utf-8"), re.M)
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in ("convergence", "quick", "docs", "test", "lint", "clean"):
        assert re.search(rf"^{target}:", makefile, re.M), target
    for tool in ("ruff check .", "mypy", 'pytest -m "not slow"'):
        assert tool in makefile


def test_results_name_no_folder_of_the_machine_they_were_made_on():
    for path in sorted((ROOT / "reports").rglob("*")):
        if path.suffix in (".csv", ".json", ".md") and "partial" not in path.parts:
            text = path.read_text(encoding="utf-8")
            for folder in ("/home/", "/root/", "/tmp/", "/Users/", "C:\\", str(ROOT)):
                assert folder not in text, f"{path.relative_to(ROOT)} names {folder}"
