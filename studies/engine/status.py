"""Which reports are older than the code: ``make reports-status``.

A report names in ``run.json`` the hash of the sources that its tables were made by, the solvers'
among them.  Where that has changed since, its numbers may have changed too.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import pandas as pd

from studies.engine.sources import ROOT

CURRENT, OLDER = "current", "older than the code"


def status(reports: Path = ROOT / "reports") -> pd.DataFrame:
    """A row a report: ``study, date, commit, modified, status``."""
    rows = []
    for path in sorted(reports.glob("*/run.json")):
        run = json.loads(path.read_text(encoding="utf-8"))
        rows.append(
            {
                "study": run["study"],
                "date": run["date_utc"],
                "commit": run["commit"][:10],
                "modified": bool(run["sources_modified"]),
                "status": _status(run),
            }
        )
    return pd.DataFrame(rows, columns=["study", "date", "commit", "modified", "status"])


def _status(run: dict[str, str]) -> str:
    return CURRENT if run.get("study_hash") == _hash_of_study(run["study"]) else OLDER


def _hash_of_study(name: str) -> str:
    return str(importlib.import_module(f"studies.{name}").STUDY.sources)


def main() -> int:
    """Print the list; the exit status is 1 where a report is older than the code."""
    found = status()
    print(found.to_string(index=False))
    return 0 if (found["status"] == CURRENT).all() else 1


if __name__ == "__main__":
    sys.exit(main())
