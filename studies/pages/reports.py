"""What is under ``reports/``, as pages ask for it: tables, claims and how they were made."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid.errors import InputError, require
from studies.engine.claims import FIRST
from studies.engine.results import read_table
from studies.measures.tables import select
from studies.methods import LATTICE, PACKAGE, SUPG
from studies.pages import theory, views

#: Columns of claims, and what reports called them before they had an engine in common.
_CLAIMS = ["claim", "where", "measured", "asked", "verdict"]
_EARLIER = {"wanted": "asked", "decided by": "measured"}
_VERDICTS = {"in part": "reproduced in part"}


def in_order(claims: pd.DataFrame) -> pd.DataFrame:
    """What does not hold first."""
    order = {verdict: place for place, verdict in enumerate(FIRST)}
    return claims.sort_values("verdict", key=lambda v: v.map(order), kind="stable")


@dataclass(frozen=True)
class Report:
    """One study's results."""

    name: str
    folder: Path

    @property
    def run(self) -> dict[str, Any]:
        """``run.json``."""
        found: dict[str, Any] = json.loads((self.folder / "run.json").read_text(encoding="utf-8"))
        return found

    def table(self, name: str, *columns: str) -> pd.DataFrame | None:
        """A table, or nothing where the report has no such table or lacks one of ``columns``."""
        try:
            found = read_table(self.folder, name)
        except InputError:
            return None
        return found if set(columns) <= set(found.columns) else None

    @property
    def claims(self) -> pd.DataFrame:
        """What was claimed or asked, measured and judged, in the order of a report."""
        found = self.table("claims", "claim")
        if found is None:
            found = self.table("verdicts", "claim")
        if found is None:
            return pd.DataFrame(columns=[*_CLAIMS, "source"])
        found = found.rename(columns=_EARLIER).replace({"verdict": _VERDICTS})
        if "source" not in found:
            found["source"] = "paper"
        found = found.reindex(columns=[*_CLAIMS, "source"])
        return in_order(found)


@dataclass(frozen=True)
class Reports:
    """The reports of a checkout; ``reports["convergence"]`` is one of them."""

    root: Path

    def __getitem__(self, name: str) -> Report:
        folder = self.root / "reports" / name
        require(
            (folder / "run.json").exists(),
            f"reports/{name} is missing: run python -m studies.{name} first",
        )
        return Report(name, folder)

    @property
    def names(self) -> list[str]:
        """Every study with a report."""
        return sorted(path.parent.name for path in self.root.glob("reports/*/run.json"))

    @property
    def paper(self) -> pd.DataFrame:
        """Every claim of the paper with the study that judged it."""
        found = [self[name].claims.assign(study=name) for name in self.names]
        every = pd.concat([each for each in found if len(each)], ignore_index=True)
        return in_order(select(every, source="paper"))

    @property
    def targets(self) -> pd.DataFrame:
        """What was asked of the package default and its lattice differences, with the study."""
        every = [PACKAGE.name, "the default", *(method.name for method in LATTICE.values())]
        names = "|".join(every)
        found = []
        for name in self.names:
            claims = select(self[name].claims, source="asked")
            said = claims["claim"].astype(str) + " " + claims["where"].astype(str)
            # A table without a SUPG row is older than the default: its name meant another method.
            if self.knows_default(name):
                found.append(claims[said.str.contains(names)].assign(study=f"`{name}`"))
        empty = pd.DataFrame(columns=[*_CLAIMS, "study"])
        return in_order(pd.concat([empty, *found], ignore_index=True))

    def knows_default(self, name: str) -> bool:
        """True where "package default" is what it is now in the report of that study."""
        table = self[name].table("table", "method")
        if table is not None:
            return bool(table["method"].str.startswith(SUPG.name).any())
        # Clouds name their operators; the default is one of these rows where it was run so.
        table = self[name].table("table", "operator")
        return table is not None and bool(table["operator"].str.startswith(PACKAGE.name).any())

    @property
    def counts(self) -> pd.DataFrame:
        """How each study was run, and how many of its claims got which verdict."""
        rows = []
        for name in self.names:
            run, claims = self[name].run, self[name].claims
            counted = claims["verdict"].value_counts()
            kinds = {
                "hold": ("met", "reproduced"),
                "in part": ("met in part", "reproduced in part"),
                "do not": ("not met", "not reproduced"),
            }
            row: dict[str, Any] = {"study": f"`{name}`", "made": str(run.get("date_utc", ""))[:10]}
            row["commit"] = f"`{str(run.get('commit') or '')[:8]}`"
            row["cases"] = run.get("cases")
            row["failed"] = run.get("cases_failed")
            row["minutes"] = f"{float(run.get('wall_s') or 0.0) / 60.0:.0f}"
            row |= {kind: sum(int(counted.get(v, 0)) for v in of) for kind, of in kinds.items()}
            rows.append(row)
        return pd.DataFrame(rows)

    def view(self, name: str) -> Any:
        """What ``studies.pages.views`` or ``.theory`` makes of the reports: a function there."""
        return getattr(views if hasattr(views, name) else theory, name)(self)
