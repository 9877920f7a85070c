"""The command ``sphsolid`` and its parts.

Exit codes: 0 done; 1 the solution diverged, or members of a sweep did not end well; 2 wrong input;
130 interrupted.  Nobody sees a traceback: what is wrong is one message on the standard error
stream.
"""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

import sphsolid as sph
from sphsolid.errors import Diverged, FoldingWarning, InputError, require
from sphsolid.geometry.__main__ import main as check_mesh_file
from sphsolid.shell.case import read_case
from sphsolid.shell.explaining import explain
from sphsolid.shell.running import run_case
from sphsolid.shell.settings import one, product
from sphsolid.shell.sweeping import sweep
from sphsolid.shell.viewing import view

DIVERGED, WRONG, INTERRUPTED = 1, 2, 130
#: Set to anything, a fault of this package is shown with its traceback.
TRACEBACK = "SPHSOLID_TRACEBACK"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; returns the exit code."""
    given = _parser().parse_args(arguments)
    with warnings.catch_warnings():
        # A fold is said in the words of the warning; no line of ours helps the reader.
        warnings.showwarning = _say_warning
        return _done(given)


def _done(given: argparse.Namespace) -> int:
    """Do it, and say in one message what went wrong."""
    try:
        code: int = given.do(given)
    except InputError as wrong:
        print(f"error: {wrong}", file=sys.stderr)
        return WRONG
    except Diverged as stop:
        print(f"diverged: {stop}", file=sys.stderr)
        return DIVERGED
    except KeyboardInterrupt:
        print("interrupted; what was recorded is kept", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read has closed: the interpreter must not try to write to it at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (OSError, MemoryError) as failure:
        print(f"error: {_said(failure)}", file=sys.stderr)
        return WRONG
    except Exception as fault:
        if os.environ.get(TRACEBACK):
            raise
        print(
            f"internal error, please report it: {type(fault).__name__}: {fault} ({TRACEBACK}=1 "
            "shows where)",
            file=sys.stderr,
        )
        return WRONG
    return code


def _said(failure: BaseException) -> str:
    if isinstance(failure, MemoryError):
        return "the machine has too little memory for this; use a larger spacing"
    return str(failure)


def _say_warning(message: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
    head = "folded" if issubclass(category, FoldingWarning) else "warning"
    print(f"{head}: {message}", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="sphsolid",
        description="Large-strain solid dynamics from case files; docs/shell.md has them in full.",
    )
    parser.add_argument("--version", action="version", version=f"sphsolid {sph.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser("run", help="run a case into its folder")
    _case(run)
    run.add_argument("--folder", default="", help="of the run (default: that of the case)")
    run.add_argument("--resume", action="store_true", help="go on from the folder's checkpoint")
    run.add_argument("--replace", action="store_true", help="remove the folder's run first")
    run.add_argument("--quiet", action="store_true", help="show no progress")
    run.set_defaults(do=_run)

    many = commands.add_parser("sweep", help="run a case with many settings: a table, a figure")
    _case(many)
    many.add_argument("--out", default="", help="folder of the table (default: out/CASE-sweep)")
    many.add_argument("--jobs", type=int, default=0, help="runs at once (default: half the cores)")
    many.add_argument("--scheduler", default="", metavar="ADDRESS", help="of a Dask cluster")
    many.add_argument("--keep", action="store_true", help="keep the folder of every run")
    many.add_argument("--show", default="", metavar="COLUMN", help="what the figure shows")
    many.set_defaults(do=_sweep)

    check = commands.add_parser("check", help="say what a mesh file is worth")
    check.add_argument("file", help="Gmsh .msh, VTK .vtu or Abaqus .inp")
    check.add_argument("--unit", default="", help="m, cm, mm, um, in, ft, or metres to a unit")
    check.set_defaults(do=_check)

    plan = commands.add_parser("explain", help="say what a case will do and cost, and why")
    _case(plan)
    plan.add_argument("--no-time", action="store_true", help="do not time any step")
    plan.set_defaults(do=_explain)

    look = commands.add_parser("view", help="pictures, curves and an animation of a run's folder")
    look.add_argument("folder", help="of the run")
    look.add_argument("--field", default="pressure", help="what the colours show (%(default)s)")
    look.add_argument("--window", action="store_true", help="a window that turns, with pyvista")
    look.set_defaults(do=_view)
    return parser


def _case(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", help="case file (TOML)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="settings",
        help="in the place of what the file says; repeat for more",
    )  # fmt: skip


def _run(given: argparse.Namespace) -> int:
    case = read_case(given.case, settings=[one(text) for text in given.settings])
    simulation, folder = run_case(
        case, folder=given.folder, resume=given.resume, replace=given.replace, quiet=given.quiet
    )
    print(simulation.summary())
    print(f"wrote {folder}; look at it with: sphsolid view {folder}")
    return 0


def _sweep(given: argparse.Namespace) -> int:
    path = Path(given.case)
    require(given.jobs >= 0, f"--jobs {given.jobs} must be 1 or more")
    require(len(given.settings) > 0, "sweep: say what to vary, --set spacing=1/4,1/5,1/6")
    jobs = given.jobs or max(1, (os.cpu_count() or 2) // 2)
    out = Path(given.out or Path("out", f"{path.stem}-sweep"))
    table = sweep(
        path, product(given.settings), out=out, jobs=jobs, scheduler=given.scheduler,
        keep=given.keep, show=given.show, to=sys.stderr,
    )  # fmt: skip
    ends = table["status"][table["status"] != "complete"].value_counts()
    print((out / "sweep.md").read_text(encoding="utf-8"), end="")
    print(f"wrote {out}: sweep.csv, sweep.md" + (", sweep.png" if _drawn(out) else ""))
    for status, count in ends.items():
        more = "; the same command tries them again" if status == "failed" else ""
        print(f"{count} of {len(table)} {status}{more}")
    return DIVERGED if len(ends) else 0


def _drawn(out: Path) -> bool:
    return (out / "sweep.png").is_file()


def _check(given: argparse.Namespace) -> int:
    code = check_mesh_file([given.file, *(["--unit", given.unit] if given.unit else [])])
    return WRONG if code else 0


def _explain(given: argparse.Namespace) -> int:
    case = read_case(given.case, settings=[one(text) for text in given.settings])
    print(explain(case, timed=not given.no_time))
    return 0


def _view(given: argparse.Namespace) -> int:
    for line in view(Path(given.folder), field=given.field, window=given.window):
        print(line)
    return 0
