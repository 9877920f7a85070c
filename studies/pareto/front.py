"""Where a nodal method is asked to be cheaper than finite elements, and whether it is."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import pandas as pd

from studies.engine.claims import Claim
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE
from studies.pareto.iso_error import ASKED, DECIDED, ONLY_FEM, ONLY_SPH, OPEN
from studies.pareto.methods import LATTICES
from studies.pareto.problems import COLUMN, FAIR, LINEAR_FAIR, MEASURES, PROBLEMS

_LATTICES = tuple(method.name for method in LATTICES)
#: Asked of the median over all rows that can be compared.
MEDIAN = 1.5


@dataclass(frozen=True)
class Target:
    """The cost over that of the cheaper finite element is at most ``most`` at each error."""

    scene: str
    nu: float
    measures: tuple[str, ...]
    errors: tuple[float, ...]
    most: float

    @property
    def where(self) -> str:
        """Problem, Poisson's ratio and measure."""
        measure = f", {self.measures[0]}" if len(self.measures) == 1 else ""
        return f"{PROBLEMS[self.scene].title}, nu = {self.nu:g}{measure}"


TARGETS = (
    *(
        Target(cube, *rest)
        for cube in (FAIR, LINEAR_FAIR)
        for rest in (
            (0.495, ("momentum",), (0.01, 0.001), 0.5), (0.495, ("stress",), (0.01, 0.001), 0.15),
            (0.3, ("momentum",), (0.01, 0.001), 3.0), (0.3, ("stress",), (0.001,), 1.0),
        )
    ),
    *(Target(COLUMN, nu, MEASURES[COLUMN], ASKED, 3.0) for nu in PROBLEMS[COLUMN].nus),
)  # fmt: skip


def measured(rows: pd.DataFrame, most: float) -> dict[str, float]:
    """Ratio of each row that says whether the cost is at most ``most``, by measure and error.

    A bound that lies on the wrong side says nothing.  Where elements alone get there it is ``inf``.
    """
    found = {}
    for row in rows.itertuples():
        ratio = float(row.cpu_ratio)
        known = row.outcome in (*DECIDED, OPEN) and not math.isnan(ratio)
        # An exact ratio has no text there, which a file gives back as nan.
        silent = {"at most": ratio > most, "at least": ratio <= most, "both bounds": True}
        if row.outcome == ONLY_FEM or (known and not silent.get(row.bound, False)):
            name = f"{row.measure} {row.asked:.1%}"
            found[name] = math.inf if row.outcome == ONLY_FEM else ratio
    return found


def front_claims(compared: pd.DataFrame, medians: pd.DataFrame) -> Iterator[Claim]:
    """Every target, of the lattice method that comes nearest to it and of the package default."""
    for target in TARGETS:
        asked = select(compared, scene=target.scene, nu=target.nu)
        asked = asked[asked["measure"].isin(target.measures) & asked["asked"].isin(target.errors)]
        of = {name: select(asked, method=name) for name in _LATTICES}
        ratios = {name: measured(rows, target.most) for name, rows in of.items()}
        best = min(_LATTICES, key=lambda name: _rank(ratios[name], of[name], target.most))
        for name in dict.fromkeys((best, PACKAGE.name)):
            yield Claim(
                f"at equal error {name} costs so many times the cheaper finite element",
                ratios[name], "<=", target.most, where=target.where, format=".2g",
                said=_said(ratios[name], of[name]),
            )  # fmt: skip
    by_name = medians.set_index("method")["median"] if len(medians) else pd.Series(dtype=float)
    known = [name for name in _LATTICES if name in by_name.index]
    if known:
        best = min(known, key=lambda name: (math.isnan(by_name[name]), by_name[name]))
        for name in dict.fromkeys([best, *(name for name in known if name == PACKAGE.name)]):
            yield Claim(
                f"median over all comparable rows of the cost of {name} over the cheaper finite "
                "element", float(by_name[name]), "<=", MEDIAN,
            )  # fmt: skip


def slope_claims(table: pd.DataFrame) -> Iterator[Claim]:
    """Off lattices: slopes in the last refinement of the default, and of hexahedra beside it."""
    for (scene, nu), runs in table.groupby(["scene", "nu"], sort=False):
        if PROBLEMS[scene].on_lattice:
            continue
        for field in ("momentum", "stress"):
            slopes = {}
            for name in (PACKAGE.name, B_BAR.name):
                last = select(runs, method=name).sort_values("cells").tail(2)
                if len(last) == 2 and not last["folded"].any():
                    error, cells = last[field].to_numpy(), last["cells"].to_numpy()
                    slopes[name] = math.log(error[0] / error[1]) / math.log(cells[1] / cells[0])
            if len(slopes) == 2:
                yield Claim(
                    f"slope of the {field}, {PACKAGE.name} beside elements", slopes, format=".2f",
                    where=f"{PROBLEMS[scene].title}, nu = {nu:g}",
                )  # fmt: skip


def _rank(ratios: dict[str, float], rows: pd.DataFrame, most: float) -> tuple[float, ...]:
    """The fewest failures, then the most errors reached, then the smallest worst ratio."""
    reached = len(ratios) + int((rows["outcome"] == ONLY_SPH).sum())
    failures = sum(value > most for value in ratios.values())
    return reached == 0, failures, -reached, max(ratios.values(), default=math.inf)


def _said(ratios: dict[str, float], rows: pd.DataFrame) -> str:
    parts = [
        f"{name} {'is not reached' if math.isinf(value) else format(value, '.2g')}"
        for name, value in ratios.items()
    ]
    parts += [
        f"{row.measure} {row.asked:.1%}: only particles reach it"
        for row in rows[rows["outcome"] == ONLY_SPH].itertuples()
    ]
    return "; ".join(parts) or "nothing can be compared"
