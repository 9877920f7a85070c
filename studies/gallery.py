"""The gallery: every scene on a coarse lattice by both solvers, its picture and its numbers.

``python -m studies.gallery`` runs all of them, some minutes, and writes small pictures and
``numbers.csv`` to ``docs/gallery``; ``--scene NAME`` one of them.  The page ``docs/gallery.md`` is
filled from that table by ``python -m studies.readme_table``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from sphsolid import scenes
from sphsolid.errors import InputError, require
from sphsolid.geometry import MeshFile, Spacing
from sphsolid.geometry.body import AS_MESHED
from sphsolid.look.panels import Layout
from sphsolid.look.view import View, angled_view, flat_view
from sphsolid.record import Energy, Probe, Recorder
from sphsolid.scenes import Scene
from studies.engine.results import read_table, write_table
from studies.engine.sources import ROOT
from studies.measures.run import run
from studies.methods import B_BAR, PACKAGE, Method
from studies.pictures.picture import Panel, Percentile, Picture
from studies.pictures.shots import SaveShots, ShotFolder

OUT = ROOT / "docs" / "gallery"
METHODS = (PACKAGE, B_BAR)
HEADINGS = {PACKAGE.name: "particles", B_BAR.name: "B-bar elements"}
LAYOUT = Layout(width=5.6, height=2.9, dpi=90)


@dataclass(frozen=True)
class Exhibit:
    """A scene as it is shown.

    ``call`` is what a reader types, ``make`` what it gives; ``says`` is one sentence of what
    happens.  ``spacing`` [m]; ``shown`` and ``until`` [s] are the time of the picture and of the
    numbers.  ``column`` is the number to expect, one of the ``probe``.
    """

    name: str
    call: str
    make: Callable[[], Scene]
    says: str
    spacing: Spacing
    until: float
    probe: str
    column: str
    view: View = field(default_factory=angled_view)
    shown: float = 0.0

    @property
    def seen_at(self) -> float:
        """Time of the picture [s]."""
        return self.shown or self.until


def _plate() -> Scene:
    body = MeshFile(ROOT / "studies" / "meshes" / "plate_with_hole_hex.msh")
    return scenes.plate_with_hole(body=body, rise=1.0, hold=0.25)


def _cube() -> Scene:
    amplitude = scenes.amplitude_of_gradient("A+B+C=0", 0.2)
    return scenes.swinging_cube(manufactured=True, amplitude=amplitude)


EXHIBITS = (
    Exhibit(
        "swinging_cube",
        'swinging_cube(manufactured=True, amplitude=amplitude_of_gradient("A+B+C=0", 0.2))',
        _cube, "A standing wave with a known solution, here at large strain.",
        1 / 8, 0.013, "", "", angled_view(up="z"),
    ),
    Exhibit(
        "twisting_column", "twisting_column()", scenes.twisting_column,
        "A clamped column of nearly incompressible rubber is set spinning and twists.",
        1 / 4, 0.1, "top_corner", "u_y [m]",
    ),
    Exhibit(
        "bending_column", "bending_column()", scenes.bending_column,
        "The same column bends sideways by half its length and swings back.",
        1 / 4, 0.45, "top_centre", "u_x [m]",
    ),
    Exhibit(
        "punch", "punch()", scenes.punch,
        "A block with rollers is pressed on half of its top by an initial velocity.",
        1 / 20, 0.015, "pressed_corner", "u_z [m]", angled_view(up="z", azimuth=-60.0),
    ),
    Exhibit(
        "punch_held", "punch(press=HeldVelocity())",
        lambda: scenes.punch(press=scenes.HeldVelocity()),
        "The same with a punch that keeps its velocity: the hardest case here.",
        1 / 20, 0.01, "free_corner", "u_z [m]", angled_view(up="z", azimuth=-60.0),
    ),
    Exhibit(
        "l_shaped_block", "l_shaped_block()", scenes.l_shaped_block,
        "A free block of disordered particles is kicked into a tumble; momenta must stay.",
        0.85, 10.0, "long_end", "u_x [m]", angled_view(up="y", azimuth=30.0),
    ),
    Exhibit(
        "spinning_cube", "spinning_cube(turns=1)", lambda: scenes.spinning_cube(turns=1.0),
        "A free cube turns, expands under its own inertia and pulsates.",
        1 / 6, 0.0598, "corner", "u_x [m]", angled_view(up="z"), 0.015,
    ),
    Exhibit(
        "cable", "cable()", scenes.cable,
        "A wave runs along a pulled bar; d'Alembert's solution is exact.",
        0.5, 0.003, "free_end", "u_x [m]", flat_view(right="x", up="y"),
    ),
    Exhibit(
        "csm3", "csm3(points=5)", lambda: scenes.csm3(points=5),
        "A thin beam swings under its own weight: a benchmark of Turek and Hron.",
        scenes.csm3_spacing(5), 0.5, "tip", "u_y [m]", flat_view(right="x", up="y"),
    ),
    Exhibit(
        "plate_with_hole",
        'plate_with_hole(body=MeshFile("plate_with_hole_hex.msh"), rise=1, hold=0.25)',
        _plate, "A quarter of a plate from a mesh file is pulled slowly: a static answer.",
        AS_MESHED, 0.0, "pulled_middle", "u_y [m]", flat_view(right="x", up="y"),
    ),
)  # fmt: skip


def show(exhibit: Exhibit, out: Path) -> list[dict[str, object]]:
    """Run both solvers, draw, and give a row a method."""
    scene = exhibit.make()
    until = exhibit.until or scene.end_time
    seen = exhibit.seen_at or until
    probe = exhibit.probe or next(iter(scene.probes), "")
    rows = []
    with tempfile.TemporaryDirectory() as kept:
        folder = ShotFolder(Path(kept))
        for method in METHODS:
            rows.append(_ran(exhibit, scene, method, folder, until, seen, probe))
        panels = [
            Panel("start", PACKAGE.name, 0.0, sets_colours=False),
            *(Panel(HEADINGS[each.name], each.name, seen) for each in METHODS),
        ]
        picture = Picture(
            plan=lambda tables: [panels], colours=Percentile(99.0), view=exhibit.view, layout=LAYOUT
        )
        figure = picture.figure(folder, {})
        out.mkdir(parents=True, exist_ok=True)
        figure.savefig(out / f"{exhibit.name}.png", metadata={"Software": None})
    return rows


def _ran(
    exhibit: Exhibit, scene: Scene, method: Method, folder: ShotFolder, until: float, seen: float,
    probe: str,
) -> dict[str, object]:  # fmt: skip
    solver = method.simulation(scene, spacing=exhibit.spacing)
    # Records fall on whole multiples: the picture's time is one of them.
    every = seen / max(1, round(seen / (until / 4.0)))
    records: list[Recorder] = [
        Energy(), *([Probe(probe)] if probe else []),
        SaveShots(folder, method.name, method.name, times=(0.0, seen)),
    ]  # fmt: skip
    ran = run(solver, until=until, every=every, record=records)
    print(solver.summary(), flush=True)
    require(ran.diverged is None, f"gallery: {exhibit.name} diverged with {method.name}")
    history, column = ran.history, f"{probe}_{exhibit.column}"
    return {
        "scene": exhibit.name, "method": HEADINGS[method.name],
        "points": len(solver.snapshot().X), "steps": ran.steps, "time [s]": until,
        "what": column if column in history else "kinetic_energy [J]",
        "value": float(history[column if column in history else "kinetic_energy [J]"].iloc[-1]),
        "energy at start [J]": float(history["total_energy [J]"].iloc[0]),
        "energy [J]": float(history["total_energy [J]"].iloc[-1]),
        "folded": ran.folded,
    }  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    """Run what is asked for and keep its rows; returns 0, or 2 for wrong input."""
    parser = argparse.ArgumentParser(prog="python -m studies.gallery", description=__doc__)
    names = [each.name for each in EXHIBITS]
    parser.add_argument("--scene", action="append", choices=names, help="only this (repeatable)")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    wanted = options.scene or names
    try:
        rows = [row for each in EXHIBITS if each.name in wanted for row in show(each, options.out)]
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    made = pd.DataFrame(rows)
    if (options.out / "numbers.csv").exists():
        before = read_table(options.out, "numbers")
        made = pd.concat([before[~before["scene"].isin(wanted)], made])
    order = made["scene"].map({name: place for place, name in enumerate(names)})
    write_table(made.iloc[order.argsort(kind="stable")], options.out, "numbers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
