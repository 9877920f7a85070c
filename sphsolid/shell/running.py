"""``sphsolid run``: one case, into its folder."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

from sphsolid.compiled import set_threads
from sphsolid.errors import InputError
from sphsolid.paths import path_of
from sphsolid.record import ProgressLine, RunFolder
from sphsolid.record.atomic import atomic
from sphsolid.shell.case import Case
from sphsolid.shell.settings import shown


def run_case(
    case: Case, *, folder: str = "", resume: bool = False, replace: bool = False,
    quiet: bool = False,
) -> tuple[Any, Path]:  # fmt: skip
    """Run ``case`` into ``folder``, by default that of the file; the simulation and the folder.

    Raises ``InputError`` before the first step, and ``Diverged`` where the solution does.
    """
    if case.run.threads is not None:
        set_threads(case.run.threads)
    place = path_of(folder or case.run.folder)
    simulation = case.simulation()
    output = RunFolder(
        place, resume=resume, replace=replace, frames=case.run.frames, vtkhdf=case.run.vtkhdf,
        checkpoints=case.run.checkpoints,
    )  # fmt: skip
    try:
        _run(simulation, case, output, quiet=quiet)
    except InputError as error:
        # Nothing was run: what is in the folder is of another case.
        raise InputError(_of_the_shell(str(error))) from None
    except BaseException:
        _keep(case, place)
        raise
    _keep(case, place)
    return simulation, place


def _of_the_shell(text: str) -> str:
    """A message about keywords of :class:`RunFolder` in the words of the command line."""
    for python, shell in (
        ("RunFolder(..., replace=True)", "--replace"), ("replace=True", "--replace"),
        ("resume=True", "--resume"),
    ):  # fmt: skip
        text = text.replace(python, shell)
    return text


def _run(simulation: Any, case: Case, output: RunFolder, *, quiet: bool) -> None:
    simulation.run(
        until=case.run.until, every=case.run.every, record=case.run.record, output=output,
        progress=None if quiet else ProgressLine(),
    )  # fmt: skip


def _keep(case: Case, folder: Path) -> None:
    """The case beside its run, under the command that runs it again.

    Files that it names are beside the original, so that is what the command has.
    """
    if not folder.is_dir():
        return
    settings = [f"--set {shlex.quote(f'{e.name}={shown(e.value)}')}" for e in case.settings]
    words = ["sphsolid run", shlex.quote(str(case.path.absolute())), *settings]
    changed = f"# {' '.join(words)}\n".replace("\n", " ").rstrip() + "\n"
    with atomic(folder / "case.toml") as part:
        part.write_text(changed + case.text, encoding="utf-8")
