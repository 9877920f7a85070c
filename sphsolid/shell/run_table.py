"""``[run]``: how long, how often, what is recorded and where it goes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sphsolid.errors import nearest
from sphsolid.record import Every, Never, Probe
from sphsolid.scenes import Scene
from sphsolid.shell.names import RECORDERS
from sphsolid.shell.objects import Builder
from sphsolid.shell.problems import MISSING

KEYS = ("until", "every", "record", "folder", "frames", "vtkhdf", "checkpoints", "threads")
#: Records of a run that does not say how often.
RECORDS = 20


@dataclass(frozen=True)
class RunTable:
    """``until``, ``every`` [s]; recorders; the run's folder and what goes into it."""

    until: float
    every: float
    record: tuple[Any, ...]
    folder: str
    frames: Every | Never
    vtkhdf: Every | Never
    checkpoints: Every | Never
    threads: int | None


def read_run_table(values: dict[str, Any], builder: Builder, scene: Any, name: str) -> Any:
    """The table with its defaults: the scene's end time, twenty records, energy and all probes."""
    problems, before = builder.problems, len(builder.problems.found)
    table = values.get("run", {})
    if not isinstance(table, dict):
        problems.add(("run",), f"{table!r} is no table; write [run]")
        return MISSING
    for key in table:
        if key not in KEYS:
            problems.unknown(("run",), key, KEYS)
    times = {
        key: builder.number(table[key], ("run", key), "s")
        for key in ("until", "every") if key in table
    }  # fmt: skip
    for key, value in times.items():
        if value is not MISSING and not 0.0 < value < float("inf"):
            problems.add(("run", key), f"{value} s must be positive and finite")
    record = _recorders(table, builder, scene)
    folder = table.get("folder", f"out/{name}")
    if not isinstance(folder, str) or not folder:
        problems.add(("run", "folder"), f"{folder!r} is not the name of a folder")
    files = {key: _often(table, key, builder) for key in ("frames", "vtkhdf", "checkpoints")}
    threads = table.get("threads")
    if threads is not None and (
        isinstance(threads, bool) or not isinstance(threads, int) or threads < 1
    ):
        problems.add(("run", "threads"), f"{threads!r} is not a number of threads, 1 or more")
    if len(problems.found) > before or not isinstance(scene, Scene):
        return MISSING
    until = float(times.get("until", scene.end_time))
    every = float(times.get("every", until / RECORDS))
    return RunTable(until, every, record, folder, **files, threads=threads)


def _recorders(table: dict[str, Any], builder: Builder, scene: Any) -> tuple[Any, ...]:
    if "record" not in table:
        probes = scene.probes if isinstance(scene, Scene) else {}
        return (RECORDERS["Energy"](), *(Probe(name) for name in probes))
    given = table["record"]
    if not isinstance(given, list):
        builder.problems.add(("run", "record"), 'recorders are a list: ["Energy()"]')
        return ()
    made = []
    for k, each in enumerate(given):
        place = ("run", "record", k)
        recorder = builder.make(each, place, RECORDERS, "recorder")
        known = scene.probes if isinstance(scene, Scene) else None
        # A text may hold anything in the place of a name.
        point: Any = recorder.point if isinstance(recorder, Probe) else None
        if point is not None and not isinstance(point, str):
            builder.problems.add(place, f"{point!r} is not the name of a probe")
        elif point is not None and known is not None and point not in known:
            builder.problems.add(
                place,
                f"the scene has no probe {point!r}{nearest(point, known)}; "
                f"it has {', '.join(known) or 'none'}",
            )
        made.append(recorder)
    return tuple(made)


def _often(table: dict[str, Any], key: str, builder: Builder) -> Any:
    """``n``: at every n-th record; 0 or false: at none."""
    value = table.get(key, 1)
    if value is False or (value == 0 and not isinstance(value, bool)):
        return Never()
    if value is True:
        return Every()
    if not isinstance(value, int) or value < 0:
        builder.problems.add(
            ("run", key), f"{value!r} is not a number of records; 1 is every record, 0 is none"
        )
        return Never()
    return Every(value)
