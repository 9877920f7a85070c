"""The punch on points without a mesh: ``python -m studies.punch_cloud``.

The same block, once as disordered hexahedra with H1 and once as nothing but their vertices and a
surface, with secondary particles from agglomerated Delaunay cells; self-adjoint SUPG, nu = 0.499,
the same smoothing length on both.  The package default, which has no secondary particles, runs on
the same bodies.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import sphsolid as sph
from sphsolid.geometry import Body, HexMesh, PointCloud, Surface
from sphsolid.geometry.body import AS_MESHED, Spacing
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.look.frame import Absent
from sphsolid.look.panels import Layout
from sphsolid.look.view import flat_view
from sphsolid.record import Snapshot
from sphsolid.record.recorders import Recorder
from sphsolid.scenes import Scene, punch
from sphsolid.scenes.punch import HEIGHT, block
from studies.engine.plotting import BLACK, BLUE, GREEN, SKY, VERMILION, outside_legend, panels
from studies.engine.study import Case, Claim, Results, Row, Study, Tables, run_study
from studies.measures import folding
from studies.measures.indicators import REACH, pressure_noise, pressure_range, scattered_noise
from studies.measures.run import run
from studies.measures.tables import select
from studies.methods import PACKAGE, SUPG, UNSTABILISED, Method
from studies.pictures.picture import Panel, Percentile, Picture, Plan, keeping
from studies.pictures.shots import SaveShots, ShotFolder

#: End of the runs and time between records [s].
END, EVERY = 0.015, 5.0e-4
#: Disorder: every particle is off its place by at most this half, in spacings and components.
JITTER = 0.4
SEEDS = (1, 2, 3)
#: How much noisier than H1 on the same points a cloud may be.
TOLERANCE = 0.2
#: Smooth: at most this share of the noise without stabilisation.  Ours.
SMOOTH = 0.5

#: The bodies by name, and their colours.  A mesh of hexahedra counts the edge of a mean cube, as
#: points do, and a grid its widest edge.
LATTICE, HEXAHEDRA, WIDEST, POINTS, FILLED = CLOUDS = (
    "lattice", "hexahedra", "hexahedra, widest edge", "points", "filled",
)  # fmt: skip
_COLOURS = dict(zip(CLOUDS, (BLACK, BLUE, SKY, VERMILION, GREEN), strict=True))
TETRAHEDRA = SUPG.but(secondary=sph.T1(), line="-.")
NO_TAU_P = SUPG.but(tau_p=sph.OfStep(0.0), line="--")
BARE = UNSTABILISED.but(name=UNSTABILISED.name, line=":")
#: What is run; the first two of ``points`` are compared with ``hexahedra``.
RUNS = (
    (LATTICE, SUPG), (HEXAHEDRA, SUPG), (WIDEST, SUPG), (POINTS, SUPG),
    (FILLED, SUPG), (POINTS, TETRAHEDRA), (HEXAHEDRA, NO_TAU_P), (POINTS, NO_TAU_P),
    (HEXAHEDRA, BARE), (POINTS, BARE),
    *((cloud, PACKAGE) for cloud in (LATTICE, HEXAHEDRA, POINTS, FILLED)),
)  # fmt: skip
PICTURED = (
    (LATTICE, SUPG), (HEXAHEDRA, SUPG), (POINTS, SUPG), (FILLED, SUPG), (POINTS, TETRAHEDRA),
    (POINTS, BARE), (HEXAHEDRA, PACKAGE), (POINTS, PACKAGE),
)  # fmt: skip
LEVELS = (20, 40)


@dataclass(frozen=True)
class Ungridded:
    """The hexahedra of a body as a file would bring them, without the planes of its grid.

    ``dx`` is then the edge of a cube of the mean volume, as it is for the same particles without a
    mesh: the same neighbours, and what differs are volumes and secondary points.  On cells of
    25 x 33 x 25 mm the widest edge is a fifth longer and sees two thirds more neighbours.
    """

    body: Body

    def mesh(self, spacing: Spacing) -> HexMesh:
        """The same vertices, cells and faces."""
        grid = self.body.mesh(spacing)
        edge = float(np.cbrt(np.sum(vertex_volumes(grid)) / len(grid.cells)))
        return HexMesh(grid.vertices, grid.cells, grid.faces, edge, is_lattice=False)

    @property
    def volume(self) -> float:
        """That of the body [m^3]."""
        return self.body.volume


def body_of(cloud: str, *, spacing: float, seed: int) -> tuple[Body, Spacing]:
    """A body by name and the spacing it is to be meshed with.

    Of points nothing but the positions of the particles of the disordered block and the triangles
    of its surface is taken; a filled one has a lattice of its own, disordered by another seed.
    """
    disordered = block(jitter=JITTER, seed=seed)
    meshed: dict[str, Body] = {
        LATTICE: block(), HEXAHEDRA: Ungridded(disordered), WIDEST: disordered
    }
    if cloud in meshed:
        return meshed[cloud], spacing
    mesh = disordered.mesh(spacing)
    surface = Surface.closed(vertices=mesh.vertices, faces=mesh.faces)
    inner = np.ones(len(mesh.vertices), dtype=bool)
    inner[mesh.boundary] = False
    points = PointCloud(mesh.vertices[inner], surface)
    if cloud == POINTS:
        return points, AS_MESHED
    filled = PointCloud.fill(
        surface=points.enclosed, spacing=spacing, jitter=JITTER, seed=seed + 1000
    )
    return filled, AS_MESHED


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """Both lattices of the paper and three seeds; the quick form has the smaller and one seed.

    On the larger one the runs for contrast have one seed too.
    """
    listed = []
    for cells in LEVELS[:1] if options.quick else LEVELS:
        for cloud, method in RUNS:
            once = options.quick or cloud == LATTICE or (
                cells > LEVELS[0] and method not in (SUPG, PACKAGE)
            )
            for seed in SEEDS[:1] if once else SEEDS:
                listed.append(_case(options.out / "shots", cloud, method, cells, seed, END))
    return listed


def warm_up(options: argparse.Namespace) -> Sequence[Case]:
    """One record of each, which compiles every kernel."""
    spare = options.out / "partial" / "shots"
    return [_case(spare, *each, LEVELS[0], SEEDS[0], EVERY) for each in RUNS]


def _case(shots: Path, cloud: str, method: Method, cells: int, seed: int, until: float) -> Case:
    key = f"{cloud}, {method.name}, 1/{cells}, seed {seed}"
    arguments = {
        "key": key, "cloud": cloud, "method": method, "cells": cells, "seed": seed, "until": until,
        "shots": str(shots),
    }  # fmt: skip
    return Case(key, run_case, arguments, cost=(cells / LEVELS[0]) ** 4)


@dataclass(frozen=True)
class Noise:
    """Noise and percentiles [Pa] of the pressure, heights of the top [m]."""

    spacing: float
    #: The solver is to keep its energy and momentum budget.
    needs_balance: bool = True

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Six columns; the noise in rows is nan without hexahedra."""
        low, high = pressure_range(snapshot)
        top = snapshot.x[np.isclose(snapshot.X[:, 2], HEIGHT), 2]
        has_rows = isinstance(snapshot.mesh, HexMesh)
        return {
            "noise": scattered_noise(snapshot, spacing=self.spacing),
            "noise_in_rows": pressure_noise(snapshot) if has_rows else math.nan,
            "p_low": low, "p_high": high, "top_low": float(top.min()), "top_high": float(top.max()),
        }  # fmt: skip


def run_case(
    *, key: str, cloud: str, method: Method, cells: int, seed: int, until: float, shots: str
) -> list[Row]:
    """A row ``kind = run`` and one ``instant`` every half millisecond; diverging is a result."""
    spacing = 1.0 / cells
    body, asked = body_of(cloud, spacing=spacing, seed=seed)
    sim = method.simulation(punch(body=body), spacing=asked)
    folder = ShotFolder(Path(shots))
    folder.clear(key)
    record: list[Recorder] = [Noise(spacing), SaveShots(folder, key, key, times=(until,))]
    sim.track_budget()
    ran = run(sim, until=until, every=EVERY, record=record)
    if ran.diverged is not None:
        folder.save_diverged(key, key, ran.diverged)
    # At the start there is no pressure yet.
    history = ran.history[ran.history["time [s]"] > 0.0].rename(columns={"time [s]": "time"})
    balance: Any = sim.snapshot().budget
    drift, start = (np.linalg.norm(part[0]) for part in (balance.drift, balance.start_momentum))
    ends = ("p_low", "p_high", "top_low", "top_high")
    row: Row = {
        "kind": "run",
        "settings": f"{sim.stabilisation.name}, {sim.operator.name}",
        "particles": sim.cloud.size,
        "secondary": 0 if sim.secondary is None else len(sim.secondary.V),
        **{name: history[name].mean() for name in ("noise", "noise_in_rows")},
        **{name: history[name].iloc[-1] if len(history) else math.nan for name in ends},
        "missed_momentum": drift / start,
        "setup_s": sim.setup_seconds,
    }
    instants = history[["time", "noise", "noise_in_rows", *ends]].to_dict("records")
    common = {"key": key, "cloud": cloud, "method": method.name, "cells": cells, "seed": seed}
    return [
        common | row | ran.columns(), *(common | {"kind": "instant"} | each for each in instants)
    ]


_RUN = [
    "key", "cloud", "method", "cells", "seed", "settings", "particles", "secondary", "noise",
    "noise_in_rows", "p_low", "p_high", "top_low", "top_high", "missed_momentum", "survived",
    "diverged_at", "where", "why", *folding.COLUMNS, "steps", "setup_s", "wall_s",
]  # fmt: skip
_MEANS = (
    "particles", "secondary", "noise", "noise_in_rows", "against_H1", "p_low", "p_high", "top_low",
    "top_high", "setup_s", "wall_s",
)  # fmt: skip


def tables(rows: list[Row]) -> Tables:
    """``table``: a mean over the seeds for each cloud; ``runs``: every run; ``history``."""
    runs = pd.DataFrame([row for row in rows if row["kind"] == "run"]).reindex(columns=_RUN)
    columns = ["key", "cloud", "method", "cells", "seed", "time", "noise"]
    history = pd.DataFrame([row for row in rows if row["kind"] == "instant"], columns=columns)
    runs["against_H1"] = [_against_h1(run, runs) for run in runs.to_dict("records")]
    grouped = runs.groupby(["cells", "cloud", "method"], sort=False)
    table = grouped.agg(
        settings=("settings", "first"),
        seeds=("seed", "count"),
        survived=("survived", "sum"),
        folded=("folded", "sum"),
        **{name: (name, "mean") for name in _MEANS},
        against_H1_low=("against_H1", "min"),
        against_H1_high=("against_H1", "max"),
        missed_momentum=("missed_momentum", "max"),
    ).reset_index()
    return {"table": table, "runs": runs, "history": history}


def _against_h1(run: Mapping[Any, Any], runs: pd.DataFrame) -> float:
    """Noise over that of H1 on hexahedra with the points of the same seed, less one.

    Of the package default and without stabilisation: over that of the same method there.
    """
    method = SUPG.name if run["method"] == TETRAHEDRA.name else run["method"]
    h1 = select(runs, method=method, cloud=HEXAHEDRA, cells=run["cells"], seed=run["seed"])
    if len(h1) != 1 or run["cloud"] not in (POINTS, FILLED):
        return math.nan
    return float(run["noise"] / h1["noise"].iloc[0] - 1.0)


def claims(tables: Tables) -> list[Claim]:
    """What was asked of the clouds of each lattice; what has not run has no claim."""
    found: list[Claim] = []
    for cells, runs in tables["runs"].groupby("cells", sort=False):

        def at_most(what: str, measured: float, limit: float, level: Any = cells) -> None:
            found.append(Claim(what, measured, "<=", limit, where=f"{level} cells a metre"))

        h1 = _noise(runs, HEXAHEDRA, SUPG)
        for cloud in (POINTS, FILLED):
            mine = select(runs, cloud=cloud, method=SUPG.name)
            if len(mine) == 0 or math.isnan(h1):
                continue
            more = float(mine["noise"].mean()) / h1 - 1.0
            at_most(f"{cloud}: noise above that of H1, mean", more, TOLERANCE)
            if cloud == POINTS:
                worst = float(mine["against_H1"].max())
                at_most(f"{cloud}: the same, worst seed", worst, TOLERANCE)
            diverged = float((~mine["survived"].astype(bool)).sum())
            at_most(f"{cloud}: runs that diverged", diverged, 0.0)
            at_most(f"{cloud}: runs that folded", float(folding.has_folded(mine).sum()), 0.0)
        found.extend(_of_the_default(runs, f"{cells} cells a metre, {PACKAGE.name}"))
        share = _noise(runs, POINTS, SUPG) / _noise(runs, POINTS, BARE)
        if not math.isnan(share):
            at_most("points: noise over that without stabilisation", share, SMOOTH)
    return found


def _of_the_default(runs: pd.DataFrame, where: str) -> Iterator[Claim]:
    """It runs on every body without folding, and on points as on hexahedra."""
    own = select(runs, method=PACKAGE.name)
    good = folding.sound(own)
    if len(own):
        yield Claim.counted(
            "runs that neither diverge nor fold", int(good.sum()), len(own), where=where,
            wanted="all",
        )  # fmt: skip
    meshed = _noise(runs, HEXAHEDRA, PACKAGE)
    for cloud in (POINTS, FILLED):
        more = _noise(runs, cloud, PACKAGE) / meshed - 1.0
        if not math.isnan(more):
            what = f"{cloud}: noise above that on hexahedra, mean"
            yield Claim(what, more, "<=", TOLERANCE, where=where)
    share = _noise(runs, POINTS, PACKAGE) / _noise(runs, POINTS, BARE)
    if not math.isnan(share):
        yield Claim(
            "points: noise over that without stabilisation", share, "<=", SMOOTH, where=where
        )


def _noise(runs: pd.DataFrame, cloud: str, method: Method) -> float:
    return float(select(runs, cloud=cloud, method=method.name)["noise"].mean())


def _heading(cloud: str, method: Method) -> str:
    return cloud if method == SUPG else f"{cloud},\n{method.name.split(', ')[-1]}"


def noise_figure(results: Results) -> Figure:
    """Noise over time for each lattice, mean over the seeds: colours are clouds, lines methods."""
    history = results.tables["history"]
    levels = sorted(history["cells"].unique())
    figure, axes = panels(1, len(levels), width=3.8, height=3.0)
    for ax, cells in zip(axes.flat, levels, strict=True):
        for cloud, method in RUNS:
            mine = select(history, cloud=cloud, method=method.name, cells=cells)
            if len(mine):
                mean = mine.groupby("time")["noise"].mean()
                label = _heading(cloud, method).replace("\n", " ")
                look: dict[str, Any] = {"color": _COLOURS[cloud], "linestyle": method.line}
                if method == PACKAGE:
                    look |= {"marker": PACKAGE.marker, "markersize": 2.8, "linewidth": 0.9}
                ax.plot(1e3 * mean.index, mean, label=label, **look)
        ax.set(title=f"{cells} cells a metre", xlabel="time [ms]", ylabel="pressure noise [-]")
        ax.set_ylim(bottom=0.0)
    outside_legend(figure, axes.flat, columns=1 + len(levels))
    return figure


def _plan(cells: int, tables: Tables) -> Plan:
    """Front of the block at the end for the first seed."""
    shown: list[Panel | Absent] = []
    for cloud, method in PICTURED:
        runs = select(
            tables["runs"], cloud=cloud, method=method.name, cells=cells, seed=SEEDS[0]
        )
        label = _heading(cloud, method)
        sets_colours = method == SUPG
        shown += [Panel(label, key, END, sets_colours) for key in runs["key"]] or [
            Absent(label, END)
        ]
    return [shown[:4], shown[4:]]


PICTURES = {
    f"pressure_{cells}": Picture(
        partial(_plan, cells), "pressure", Percentile(), flat_view(right="x", up="z"),
        layout=Layout(dpi=100),
    )
    for cells in LEVELS
}  # fmt: skip


def words(tables: Tables) -> Mapping[str, Any]:
    """Thresholds, and which pictures there are."""
    return {
        "levels": [n for n in LEVELS if PICTURES[f"pressure_{n}"].is_worth_drawing(tables)],
        "tolerance": TOLERANCE, "smooth": SMOOTH, "jitter": JITTER, "reach": REACH,
    }  # fmt: skip


STUDY = Study(
    name="punch_cloud",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={"noise": noise_figure} | {name: each.draw for name, each in PICTURES.items()},
    text=Path(__file__).with_suffix(".md"),
    words=words,
    keep=keeping(list(PICTURES.values())),
    warm_up=warm_up,
    description="The punch on points without a mesh against H1 on the same points.",
)

if __name__ == "__main__":
    run_study(STUDY)
