"""The picture of README: the twisting column, SUPG-SPH over time and B-bar FEM beside it.

``python -m studies.picture`` runs the column at nu = 0.495 with 8 cells across (9x49x9 particles)
and writes ``docs/twisting_column.png``; its frames stay in ``out/picture``, and ``--redraw`` uses
them again.  Colour: pressure ``U'(J)``, positive in tension, of particles and elements alike as
means over cells, carried to the vertices; half a per cent of the volume is beyond the ends of the
bar.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from matplotlib.figure import Figure

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.scenes import twisting_column
from studies.harness.cases import ROOT
from studies.pictures.colours import limits
from studies.pictures.panels import Layout, panel_figure
from studies.pictures.shots import CELL, Frame, SaveShots, ShotFolder

PAPER = Layout(width=9.5, height=6.4, dpi=140)
TIMES = (0.0, 0.03, 0.06, 0.1)
PARTICLES, ELEMENTS = "SUPG-SPH", "B-bar FEM"
#: A particle on the surface is half a cell further out than the centre of an element.
FIELD = CELL + "pressure"


def run(folder: ShotFolder, *, cells: int) -> None:
    """Both solvers on the column, ``cells`` a metre, frames at ``TIMES`` [s] into ``folder``."""
    scene, spacing = twisting_column(), 1.0 / cells
    solvers: dict[str, sph.Simulation | fem.Simulation] = {
        PARTICLES: sph.Simulation(scene, spacing=spacing, formulation=sph.PFJ()),
        ELEMENTS: fem.Simulation(scene, spacing=spacing),
    }
    for name, solver in solvers.items():
        folder.clear(name)
        frames = SaveShots(folder, name, name, times=TIMES)
        solver.run(until=TIMES[-1], every=0.01, record=[frames])
        print(solver.summary())


def draw(folder: ShotFolder) -> Figure:
    """The figure, from stored frames."""
    row: list[Frame] = [folder.load(PARTICLES, time) for time in TIMES]
    row.append(folder.load(ELEMENTS, TIMES[-1]))
    return panel_figure([row], colours=limits(row, field=FIELD, percentile=99.5), layout=PAPER)


def main(argv: list[str] | None = None) -> int:
    """Run both solvers and draw; returns 0, or 2 for wrong input."""
    parser = argparse.ArgumentParser(prog="python -m studies.picture", description=__doc__)
    parser.add_argument("--cells", type=int, default=8, help="cells per metre (default 8)")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "twisting_column.png")
    parser.add_argument("--shots", type=Path, default=Path("out", "picture"), help="the frames")
    parser.add_argument("--redraw", action="store_true", help="use the frames there are")
    options = parser.parse_args(argv)
    folder = ShotFolder(options.shots)
    try:
        if not options.redraw:
            run(folder, cells=options.cells)
        figure = draw(folder)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    options.out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.out, metadata={"Software": None})
    print(f"wrote {options.out.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
