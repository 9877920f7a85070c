"""The picture of README: the twisting column, SUPG-SPH over time and B-bar FEM beside it.

``python -m studies.picture`` runs the column at nu = 0.495 with 8 cells across (9x49x9 particles)
and writes ``docs/twisting_column.png``.  Colour: pressure ``kappa (J - 1)``, positive in tension.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import fem_reference as fem
import sphsolid as sph
from sphsolid.scenes import twisting_column
from studies.cases import ROOT
from studies.surface import draw_surface, frame_axes, pressure_scale

TIMES = (0.03, 0.06, 0.1)
#: Ends of the colour bar [Pa].
LIMIT = 4.0e6


def main(argv: list[str] | None = None) -> int:
    """Run both solvers and draw; returns 0."""
    parser = argparse.ArgumentParser(prog="python -m studies.picture", description=__doc__)
    parser.add_argument("--cells", type=int, default=8, help="cells per metre (default 8)")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "twisting_column.png")
    options = parser.parse_args(argv)
    scene = twisting_column()
    spacing = 1.0 / options.cells
    particles = sph.Simulation(
        scene, spacing=spacing, formulation=sph.PFJ(), stabilisation=sph.SUPG(tau_p=0.2)
    )
    elements = fem.Simulation(scene, spacing=spacing)
    shots = [(f"{0:g} ms", particles.snapshot())]
    for time in TIMES:
        particles.run(until=time)
        shots.append((f"SUPG-SPH, {1e3 * time:g} ms", particles.snapshot()))
        print(particles.summary())
    elements.run(until=TIMES[-1])
    print(elements.summary())
    shots.append((f"B-bar FEM, {1e3 * TIMES[-1]:g} ms", elements.snapshot()))

    width, height = 10.0, 5.6
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    scale = pressure_scale(LIMIT)
    low, high = np.array([-0.75, 0.0, -0.75]), np.array([0.75, 6.2, 0.75])
    for k, (title, shot) in enumerate(shots):
        # A 3D drawing fills only a square: the squares overlap, the columns in them do not.
        centre, side = 0.1 + 0.185 * k, 1.0
        axes = figure.add_axes(
            (centre - 0.5 * side * height / width, -0.04, side * height / width, side),
            projection="3d",
        )
        axes.patch.set_alpha(0.0)
        draw_surface(axes, shot.mesh, shot.x, shot.at_vertices("pressure"), scale)
        frame_axes(axes, low, high)
        figure.text(centre, 0.94, title, ha="center", fontsize=11)
    bar = figure.add_axes((0.945, 0.14, 0.012, 0.66))
    figure.colorbar(scale, cax=bar, ticks=[-4e6, -2e6, 0.0, 2e6, 4e6])
    bar.set_yticklabels(["-4", "-2", "0", "2", "4"])
    bar.set_title("pressure\n[MPa]", fontsize=9)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.out, dpi=130, metadata={"Software": None})
    print(f"wrote {options.out.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
