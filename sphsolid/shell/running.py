"""``sphsolid run``: one case, into its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphsolid.compiled import set_threads
from sphsolid.record import ProgressLine, RunFolder
from sphsolid.shell.case import Case


def run_case(
    case: Case, *, folder: str = "", resume: bool = False, replace: bool = False,
    quiet: bool = False,
) -> tuple[Any, Path]:  # fmt: skip
    """Run ``case`` into ``folder``, by default that of the file; the simulation and the folder.

    Raises ``InputError`` before the first step, and ``Diverged`` where the solution does.
    """
    if case.run.threads is not None:
        set_threads(case.run.threads)
    place = Path(folder or case.run.folder)
    simulation = case.simulation()
    output = RunFolder(
        place, resume=resume, replace=replace, frames=case.run.frames, vtkhdf=case.run.vtkhdf,
        checkpoints=case.run.checkpoints,
    )  # fmt: skip
    simulation.run(
        until=case.run.until, every=case.run.every, record=case.run.record, output=output,
        progress=None if quiet else ProgressLine(),
    )  # fmt: skip
    return simulation, place
