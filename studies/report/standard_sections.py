"""The two sections that every report ends with: what was run, and what failed."""

from __future__ import annotations

from typing import Any

import pandas as pd

from studies.harness.progress import duration
from studies.report.document import Paragraph, Section, Table


def what_was_run(run: dict[str, Any]) -> Section:
    """Command, sources, versions and machine of ``run.json``."""
    commit = run["commit"] or "not known (no checkout)"
    if run["sources_modified"]:
        commit += ", with changes not committed"
    facts = {
        "command": run["command"],
        "date (UTC)": run["date_utc"],
        "wall time": duration(run["wall_s"]),
        "cases": f"{run['cases']} ({run['cases_failed']} failed, {run['cases_resumed']} resumed)",
        "version": run["version"],
        "commit": commit,
        "hash of the sources": run["source_hash"],
        "Python": run["python"],
        "packages": ", ".join(f"{name} {version}" for name, version in run["packages"].items()),
        "processor": f"{run['cpu']}, {run['cores']} cores, {run['system']}",
        "workers": f"{run['jobs']}, each with {run['threads_per_job']} kernel thread(s)",
    }
    frame = pd.DataFrame({"what": list(facts), "value": list(facts.values())})
    return Section("What was run", [Table("How these results were made.", frame)])


def what_failed(failures: pd.DataFrame) -> Section:
    """Every case that stopped, with its reason; says so when there is none."""
    if len(failures) == 0:
        return Section("What failed", [Paragraph("No case failed.")])
    frame = failures[["key", "failure", "message"]]
    return Section(
        "What failed",
        [
            Paragraph(
                f"{len(frame)} case(s) stopped before their end. They have no rows in the tables "
                "above, and orders are not computed from families that lack a level."
            ),
            Table("Cases that stopped, and why.", frame),
        ],
    )


def subtitle(run: dict[str, Any]) -> str:
    """Version, form and date in one line."""
    commit = f", commit {run['commit'][:10]}" if run["commit"] else ""
    return f"sphsolid {run['version']}{commit} · {run['mode']} study · {run['date_utc']} UTC"
