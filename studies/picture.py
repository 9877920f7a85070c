"""The picture of README: the twisting column, particles over time and B-bar FEM beside them.

``python -m studies.picture`` runs the column at nu = 0.495 with 8 cells across (9x49x9 particles)
and writes ``docs/twisting_column.png``, and its frames beside it as ``.npz``; ``--redraw`` draws it
again from these.  Colour: pressure ``U'(J)``, positive in tension, of particles and elements alike
as means over cells, carried to the vertices; half a per cent of the volume that is seen is beyond
the ends of the bar.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from sphsolid.errors import InputError
from sphsolid.look.panels import Layout
from sphsolid.scenes import twisting_column
from studies.animation import film
from studies.engine.sources import ROOT
from studies.methods import B_BAR, PACKAGE
from studies.pictures.frame_file import KeptFrames
from studies.pictures.picture import Panel, Percentile, Picture, keep_frames
from studies.pictures.shots import ShotFolder

TIMES = (0.0, 0.03, 0.06, 0.1)
SHOWN = [Panel("particles,\n" + PACKAGE.name, PACKAGE.name, time) for time in TIMES]
PICTURE = Picture(
    plan=lambda tables: [[*SHOWN, Panel("\n" + B_BAR.name, B_BAR.name, TIMES[-1])]],
    colours=Percentile(99.5),
    layout=Layout(width=9.5, height=6.4, dpi=140),
)


def main(argv: list[str] | None = None) -> int:
    """Run both solvers and draw; returns 0, or 2 for wrong input."""
    parser = argparse.ArgumentParser(prog="python -m studies.picture", description=__doc__)
    parser.add_argument("--cells", type=int, default=8, help="cells per metre (default 8)")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "twisting_column.png")
    parser.add_argument("--shots", type=Path, default=Path("out", "picture"), help="while it runs")
    parser.add_argument("--redraw", action="store_true", help="use the frames there are")
    options = parser.parse_args(argv)
    kept, folder = options.out.with_suffix(".npz"), ShotFolder(options.shots)
    try:
        if not options.redraw:
            scene = twisting_column(end_time=TIMES[-1])
            spacing = 1.0 / options.cells
            film(folder, scene, (PACKAGE, B_BAR), spacing=spacing, every=0.01, times=TIMES)
            keep_frames(kept, folder, [PICTURE], {})
        figure = PICTURE.figure(KeptFrames(kept), {})
        options.out.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(options.out, metadata={"Software": None})
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"wrote {options.out.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
