"""``sphsolid sweep``: one case with many settings, one table, one figure; goes on after a kill.

    sweep.csv, sweep.md   a row for each member: settings, how it ended, the last record
    sweep.png             histories over each other, and the last value over the settings
    members/*.json        what each member gave: a sweep that was killed goes on from these
    runs/*/               the folders of the runs, with --keep

A member is known by a hash of the case, the files that it names, its settings and the sources, so
what is kept is never taken for another.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import pandas as pd

from sphsolid.errors import require
from sphsolid.look.columns import chosen, split
from sphsolid.look.doors import installed
from sphsolid.record.atomic import atomic
from sphsolid.record.display import duration
from sphsolid.shell.case import Setting, read_case
from sphsolid.shell.member import Member, Outcome, hash_of, load, store
from sphsolid.shell.workers import Finished, on_cluster, on_this_machine

#: Columns that say how long it took, which no two sweeps share.
WALL = "wall [s]"


def sweep(
    path: Path, combinations: Sequence[tuple[Setting, ...]], *, out: Path, jobs: int,
    scheduler: str = "", keep: bool = False, show: str = "", to: TextIO,
) -> pd.DataFrame:  # fmt: skip
    """Run all ``combinations`` of settings and write table and figure into ``out``.

    Raises ``InputError`` where the reading of a combination refuses it, before anything runs.  What
    only its set-up can see, such as a face that the body has not, is a row ``refused``.
    """
    cases = [read_case(path, settings=each) for each in combinations]
    members = [
        Member(case.text, path.name, str(path.parent.absolute()), case.settings,
               kept=str(out / "runs" / _folder(case.settings)) if keep else "",
               inputs=tuple(hash_of(file) for file in case.files))
        for case in cases
    ]  # fmt: skip
    outcomes: dict[str, Outcome] = {}
    for member in members:
        known = load(_file(out, member))
        if known is not None and _is_kept(member, known):
            outcomes[member.number] = known
    waiting = [member for member in members if member.number not in outcomes]
    if len(waiting) < len(members):
        print(f"{len(members) - len(waiting)} of {len(members)} are there already", file=to)
    finished: Finished = iter(())
    if waiting:
        out.mkdir(parents=True, exist_ok=True)
        finished = on_cluster(waiting, scheduler) if scheduler else on_this_machine(waiting, jobs)
    for member, outcome in finished:
        store(_file(out, member), outcome)
        outcomes[member.number] = outcome
        print(_line(len(outcomes), len(members), member, outcome), file=to, flush=True)
    pairs = [(member, outcomes[member.number]) for member in members]
    table = table_of(pairs)
    _write(out, table, pairs, show)
    return table


def table_of(pairs: Sequence[tuple[Member, Outcome]]) -> pd.DataFrame:
    """A row for each member."""
    return pd.DataFrame(
        [
            {**member.values, "status": outcome.status, **outcome.row, WALL: outcome.wall_s,
             "reason": outcome.reason}
            for member, outcome in pairs
        ]
    )  # fmt: skip


def _write(
    out: Path, table: pd.DataFrame, pairs: Sequence[tuple[Member, Outcome]], show: str
) -> None:
    with atomic(out / "sweep.csv") as part:
        table.to_csv(part, index=False, float_format="%.17g")
    with atomic(out / "sweep.md") as part:
        part.write_text(markdown(table), encoding="utf-8")
    done = [(member, outcome) for member, outcome in pairs if outcome.history]
    if done and installed("matplotlib"):
        from sphsolid.look.sweep import sweep_figure

        column = shown_column(done, show)
        figure = sweep_figure(
            [(member.values, outcome.history) for member, outcome in done], column
        )
        figure.save(out / "sweep.png")


def shown_column(done: Sequence[tuple[Member, Outcome]], show: str) -> str:
    """The column of the figure: the one asked for, else the probe that moves most, else energy."""
    names = list(done[0][1].history)
    if show:
        return chosen([show], names)[0]
    moved = [name for name in names if "_u_" in name and split(name)[1] == "m"]
    if moved:
        return max(moved, key=lambda name: max(map(abs, done[0][1].history[name])))
    others = [name for name in names if name not in ("time [s]", "step")]
    require(len(others) > 0, "sweep: nothing is recorded; give run.record in the case file")
    return others[0]


def markdown(table: pd.DataFrame) -> str:
    """The table with five digits, without columns that say nothing."""
    kept = [name for name in table if not (name == "reason" and not any(table[name]))]
    lines = ["| " + " | ".join(map(str, kept)) + " |", "|" + "---|" * len(kept)]
    for _, row in table[kept].iterrows():
        lines.append("| " + " | ".join(_cell(row[name]) for name in kept) + " |")
    return "\n".join(lines) + "\n"


def _cell(value: object) -> str:
    if isinstance(value, float):
        whole = value.is_integer() and abs(value) < 1e9
        return f"{value:.0f}" if whole else f"{value:.5g}"
    return str(value).replace("|", "/").replace("\n", " ")


def _file(out: Path, member: Member) -> Path:
    return out / "members" / f"{member.number}.json"


def _is_kept(member: Member, known: Outcome) -> bool:
    """Whether the run's folder is there, where it is asked for and was made."""
    return not member.kept or known.status == "refused" or Path(member.kept).is_dir()


def _folder(settings: tuple[Setting, ...]) -> str:
    words = [f"{each.name}={each.value}" for each in settings]
    return re.sub(r"[^A-Za-z0-9.=_-]+", "_", ",".join(words)) or "case"


def _line(done: int, count: int, member: Member, outcome: Outcome) -> str:
    end = f": {outcome.reason}" if outcome.reason else ""
    return f"{done}/{count}  {member.key}  {outcome.status}, {duration(outcome.wall_s)}{end}"
