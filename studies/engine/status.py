"""Which reports are older than the code: ``make reports-status``.

A report names in ``run.json`` the hash of the sources that its tables were made by, the solvers'
among them.  Where that has changed since, its numbers may have changed too: ``python -m
studies.engine.carry`` runs some of its cases again and compares.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from studies.engine.sources import ROOT

CURRENT, OLDER = "current", "older than the code"


def status(reports: Path = ROOT / "reports") -> pd.DataFrame:
    """A row a report: ``study, date, commit, modified, again, status``.

    ``again``: how many of its cases later sources gave the same rows for.
    """
    rows = []
    for path in sorted(reports.glob("*/run.json")):
        run = json.loads(path.read_text(encoding="utf-8"))
        rows.append(
            {
                "study": run["study"],
                "date": run["date_utc"],
                "commit": run["commit"][:10],
                "modified": bool(run["sources_modified"]),
                "again": _again(run),
                "status": _status(run),
            }
        )
    return pd.DataFrame(rows, columns=["study", "date", "commit", "modified", "again", "status"])


def _status(run: dict[str, Any]) -> str:
    return CURRENT if run.get("study_hash") == _hash_of_study(run["study"]) else OLDER


def _again(run: dict[str, Any]) -> str:
    """How many cases were run again since, and gave the same rows."""
    carried = run.get("carried")
    if not carried:
        return ""
    within = carried.get("within", 0.0)
    to = f", to {within:g}" if within > 1.0e-6 else ""
    return f"{carried['cases']} of {run['cases']}{to}"


def _hash_of_study(name: str) -> str:
    return str(importlib.import_module(f"studies.{name}").STUDY.sources)


def main(argv: Sequence[str] | None = None) -> int:
    """Print the list; the exit status is 1 where a report is older than the code."""
    parser = argparse.ArgumentParser(prog="python -m studies.engine.status", description=__doc__)
    parser.parse_args(argv)
    found = status()
    print(found.to_string(index=False))
    return 0 if (found["status"] == CURRENT).all() else 1


if __name__ == "__main__":
    sys.exit(main())
