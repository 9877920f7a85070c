"""Animations: the frames of one run, or of several methods beside each other, as a GIF.

``python -m studies.animation --shots <out>/shots --key <case> [--key <case>] --gif out/run.gif``
reads the frames of a study, ``python -m studies.animation --scene twisting_column`` runs a scene
first.  The same frames give the same bytes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from sphsolid import scenes
from sphsolid.errors import InputError, require
from sphsolid.look.animation import write_gif
from sphsolid.look.colours import LOOKS, limits
from sphsolid.look.view import angled_view, flat_view
from studies.measures.run import run
from studies.methods import B_BAR, METHODS, PACKAGE, Method, method
from studies.pictures.shots import CELL, Frame, SaveShots, ShotFolder

_VIEWS = {
    "y-up": angled_view(up="y"),
    "z-up": angled_view(up="z"),
    "flat-xz": flat_view(right="x", up="z"),
    "flat-xy": flat_view(right="x", up="y"),
}


def film(
    folder: ShotFolder, scene: scenes.Scene, methods: Sequence[Method], *, spacing: float,
    every: float, times: Sequence[float] = (),
) -> None:  # fmt: skip
    """Run ``methods`` to the end of ``scene`` and keep their frames by name.

    Records are ``every`` [s], and frames are kept of those at ``times`` [s], or of all.
    """
    for each in methods:
        folder.clear(each.name)
        solver = each.simulation(scene, spacing=spacing)
        record = [SaveShots(folder, each.name, each.name, times=times)]
        ran = run(solver, until=scene.end_time, every=every, record=record)
        if ran.diverged is not None:
            folder.save_diverged(each.name, each.name, ran.diverged)
        print(solver.summary(), flush=True)


def main(argv: Sequence[str] | None = None) -> int:
    """The command line; returns 0, or 2 for wrong input."""
    options = _parser().parse_args(argv)
    try:
        if options.shots is None:
            _run(options)
        rows = _stored(ShotFolder(options.shots), options.key)
        colours = limits(rows, field=options.field, percentile=options.percentile)
        path = write_gif(rows, options.gif, colours=colours, view=_VIEWS[options.view])
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"wrote {path.name}: {len(rows)} pictures, {path.stat().st_size / 1e6:.2f} MB")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m studies.animation", description=__doc__)
    parser.add_argument("--scene", default="twisting_column", help="scene to run (%(default)s)")
    parser.add_argument("--cells", type=float, default=5.0, help="cells per metre (%(default)g)")
    parser.add_argument("--frames", type=int, default=40, help="pictures (%(default)s)")
    parser.add_argument(
        "--method", action="append", choices=list(METHODS), help="to run (repeat for more)"
    )
    parser.add_argument("--shots", type=Path, help="read stored frames from this folder instead")
    parser.add_argument("--key", action="append", default=[], help="case to show (repeat for more)")
    parser.add_argument("--field", choices=list(LOOKS), default=CELL + "pressure")
    parser.add_argument("--percentile", type=float, default=99.0, help="of values, for the colours")
    parser.add_argument("--view", choices=list(_VIEWS), default="y-up")
    parser.add_argument("--gif", type=Path, default=Path("out", "animation.gif"))
    return parser


def _run(options: argparse.Namespace) -> None:
    """Run the scene that was asked for; its frames are then what is shown."""
    make = getattr(scenes, options.scene, None)
    require(callable(make), f"animation: sphsolid.scenes has no scene {options.scene!r}")
    require(options.frames > 0, f"animation: --frames {options.frames} must be positive")
    scene = make()  # type: ignore[misc]
    require(isinstance(scene, scenes.Scene), f"animation: {options.scene!r} is no scene")
    methods = [method(name) for name in options.method or (PACKAGE.name, B_BAR.name)]
    options.shots, options.key = Path("out", "animation"), [each.name for each in methods]
    film(
        ShotFolder(options.shots), scene, methods, spacing=1.0 / options.cells,
        every=scene.end_time / options.frames,
    )  # fmt: skip


def _stored(folder: ShotFolder, keys: Sequence[str]) -> list[list[Frame]]:
    require(len(keys) > 0, "animation: say which case to show with --key")
    # A method that diverged has fewer frames: the others go on without it.
    longest = max((folder.load_all(key) for key in keys), key=len)
    return [[folder.load(key, shot.time) for key in keys] for shot in longest]


if __name__ == "__main__":
    sys.exit(main())
