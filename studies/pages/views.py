"""Tables and numbers of pages, as functions of the reports.

Each gives nothing (``None``) where a report is of an earlier form and lacks what it needs; the page
then says so and points to the report itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from studies.engine.results import read_table
from studies.measures.tables import select

if TYPE_CHECKING:
    from studies.pages.reports import Reports

#: Operators of the study of clouds, and the headings of the page.
_OPERATORS = {
    "Literal": "as printed", "Consistent": "`Consistent`", "SummationByParts": "`SummationByParts`",
}  # fmt: skip
#: Cells of the lattice whose passes are shown.
_LATTICE = 32
#: The spacing [m] at which clouds are compared.
_LEVEL = 1.0 / 16.0


def clouds(reports: Reports) -> pd.DataFrame | None:
    """Errors of ``p_x`` and ``P_xx`` in the linear limit, slopes at large strain, by cloud."""
    needed = ("cloud", "operator", "formulation", "scene", "family", "variant", "h", "p_x", "P_xx",
              "slope_p", "slope_P")  # fmt: skip
    levels = reports["clouds"].table("levels", *needed)
    if levels is None:
        return None
    usual = select(levels, formulation="{p,F}", family="A+B+C=0")
    usual = usual[usual["variant"].isna() & usual["operator"].isin(_OPERATORS)]
    rows = []
    for cloud in ("lattice", "jitter 0.2", "jitter 0.4", "tet"):
        row = {"cloud": cloud}
        for operator, heading in _OPERATORS.items():
            mine = select(usual, cloud=cloud, operator=operator)
            linear, large = select(mine, scene="linear"), select(mine, scene="manufactured")
            errors = linear[(linear["h"] - _LEVEL).abs() < 1e-9]
            if len(errors) == 0 or len(large) == 0:
                return None
            at, last = errors.iloc[0], large.sort_values("h").iloc[0]
            row[heading] = (
                f"{at['p_x']:.1e}, {at['P_xx']:.1e} "
                f"({last['slope_p']:.2f}, {last['slope_P']:.2f})"
            )
        rows.append(row)
    return pd.DataFrame(rows)


def hole(reports: Reports) -> dict[str, Any] | None:
    """Stress concentrations of the plate with a hole, by method and mesh, and what is known."""
    report = reports["plate_with_hole"]
    runs = report.table("table", "method", "mesh", "thickness", "edge_fit", "highest_particles")
    known = report.table("known", "what", "concentration")
    if runs is None or known is None:
        return None
    wanted = {"method": "method", "operator": "operator", "mesh": "mesh", "particles": "particles",
              "edge_fit": "concentration", "highest_particles": "highest particle"}  # fmt: skip
    shown = select(runs, thickness="plane_strain")
    there = [name for name in wanted if name in shown]
    return {"runs": shown[there].rename(columns=wanted), "known": known}


def pareto(reports: Reports) -> dict[str, Any] | None:
    """Stabilised particles against elements at equal error: how often, and by how much."""
    found = reports["pareto"].table("ratios_stabilised", "outcome", "cpu_ratio")
    if found is None:
        return None
    decided = found[found["outcome"].isin(["SPH cheaper", "SPH dearer", "equal"])]
    ratio = decided["cpu_ratio"]
    return {
        "decided": len(decided), "cheaper": int((decided["outcome"] == "SPH cheaper").sum()),
        "low": ratio.min(), "median": ratio.median(), "high": ratio.max(),
    }  # fmt: skip


def pareto_by_method(reports: Reports) -> pd.DataFrame | None:
    """CPU time at equal error over that of the cheaper element, method by method."""
    found = reports["pareto"].table("by_method", "method", "outcome", "cpu_ratio")
    if found is None:
        return None
    decided = found[found["outcome"].isin(["SPH cheaper", "SPH dearer", "equal"])]
    grouped = decided.groupby("method", sort=False)["cpu_ratio"]
    return grouped.agg(["size", "min", "median", "max"]).reset_index()


def punch_noise(reports: Reports) -> pd.DataFrame | None:
    """Pressure noise of the punch on points without a mesh, by cloud and method."""
    found = reports["punch_cloud"].table(
        "table", "cells", "cloud", "method", "particles", "seeds", "noise"
    )
    if found is None:
        return None
    return found[found["cells"] == found["cells"].max()]


def speed(reports: Reports) -> pd.DataFrame:
    """What was asked of a step, what was measured, and the verdict."""
    claims = reports["speed"].claims
    targets = reports["speed"].table("targets", "target", "asked", "measured", "met")
    if len(claims) or targets is None:
        return claims
    words = {"target": "claim"}
    return targets.assign(verdict=targets["met"].map({True: "met", False: "not met"})).rename(
        columns=words
    )


def passes(reports: Reports) -> pd.DataFrame | None:
    """Passes of the default and of SUPG on all threads, and their share of the machine's best."""
    from studies.speed import DEFAULT, OWN_SUPG

    found = reports["speed"].table(
        "passes", "method", "cloud", "cells", "threads", "pass", "ns_per_particle", "roofline_share"
    )
    if found is None:
        return None
    shown = found[found["method"].isin([DEFAULT.name, OWN_SUPG.name])]
    return select(shown, cloud="lattice", cells=_LATTICE, threads=shown["threads"].max())


def set_up(reports: Reports) -> pd.DataFrame | None:
    """How long ``SummationByParts`` takes to set up."""
    return reports["set_up"].table("table", "particles", "seconds", "seconds_again")


def hard_cases(reports: Reports) -> pd.DataFrame | None:
    """Who is sound in how many of the hard cases."""
    from studies.readme_table import judged

    found = reports["stability"].table("table", "method", "verdict", "why")
    if found is None:
        return None
    rows = [{"method": name} | judged(found, str(name)) for name in found["method"].unique()]
    return pd.DataFrame(rows)


def vibration(reports: Reports) -> pd.DataFrame | None:
    """Energy left and frequency of a vibrating block."""
    return reports["stability"].table(
        "vibration", "method", "nu", "cells", "energy_left", "frequency_error"
    )


def exhibits(reports: Reports) -> list[dict[str, Any]]:
    """Scenes of the gallery with the rows of their table."""
    from studies.gallery import EXHIBITS, OUT

    found = read_table(OUT, "numbers")
    return [
        {"name": each.name, "call": each.call, "says": each.says,
         "case": f"examples/cases/{each.name}.toml",
         "has_case": (reports.root / "examples" / "cases" / f"{each.name}.toml").exists(),
         "seen": each.shown, "rows": select(found, scene=each.name)}
        for each in EXHIBITS
    ]  # fmt: skip
