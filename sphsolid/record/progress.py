"""How far a run is, how fast it goes, and what has become of its energy."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from typing import TextIO

from sphsolid.record.display import Display, duration
from sphsolid.record.snapshot import Snapshot

#: Seconds of wall time between two reports, apart from those at records.
TICK = 0.5


@dataclass(frozen=True)
class Progress:
    """Where a run is, told to a callback at every record, twice a second and once at the end.

    ``start, time, until`` [s] of the run; the last ``dt`` [s]; ``wall`` [s] since ``run`` was
    called.  ``steps_per_second`` and ``eta`` [s] leave the first step out, which may have compiled;
    both are nan before the second.  ``start_energy`` and ``energy`` [J], kinetic and strain, are
    those of the first and of the last record.  ``driven`` says that loads or a prescribed motion
    work on the body: then their difference tells of that work, not of the method.  ``folded_since``
    [s] is when the positions were first found folded, nan while they are sound.  ``over`` is True
    in the last report, of a failed run too.
    """

    start: float
    time: float
    until: float
    step: int
    dt: float
    records: int
    wall: float
    steps_per_second: float
    eta: float
    start_energy: float
    energy: float
    driven: bool = False
    folded_since: float = math.nan
    over: bool = False

    @property
    def percent(self) -> float:
        """Of the simulated time, 0 to 100."""
        return 100.0 * (self.time - self.start) / (self.until - self.start)

    @property
    def energy_change(self) -> float:
        """``energy - start_energy`` [J]."""
        return self.energy - self.start_energy


class Pace:
    """Measures a run and tells ``told`` about it, if there is somebody to tell.

    ``driven`` is that of the scene; ``start_energy`` [J] of the first record of a run that goes on,
    nan if it is not known; ``now`` is the clock [s].
    """

    def __init__(
        self,
        told: Callable[[Progress], None] | None,
        *,
        start: float,
        until: float,
        driven: bool = False,
        start_energy: float = math.nan,
        now: Callable[[], float] = clock.perf_counter,
    ) -> None:
        self._told, self._now = told, now
        self._start, self._until, self._driven = start, until, driven
        self._began = self._last_told = now()
        self._paced_from: tuple[float, float, int] | None = None
        self._time, self._step, self._dt = start, 0, 0.0
        self._records = 0
        self._start_energy, self._energy = start_energy, math.nan
        self._folded_since = math.nan

    @property
    def is_told(self) -> bool:
        """False when nobody listens."""
        return self._told is not None

    def stepped(self, time: float, step: int, dt: float) -> None:
        """A step of ``dt`` [s] ended at ``time`` [s]; costs one look at the clock."""
        self._time, self._step, self._dt = time, step, dt
        if self._told is None:
            return
        now = self._now()
        if self._paced_from is None:
            self._paced_from = now, time, step
        if now - self._last_told >= TICK:
            self._tell(now)

    def looked(self, snapshot: Snapshot) -> None:
        """Take the energy; the first look is the start."""
        self._energy = snapshot.kinetic_energy + snapshot.strain_energy
        if math.isnan(self._start_energy):
            self._start_energy = self._energy

    def folded(self, time: float) -> None:
        """The positions were found folded at ``time`` [s]."""
        self._folded_since = time

    def recorded(self) -> None:
        """A record is complete."""
        self._records += 1
        self._tell(self._now(), over=self._time == self._until)

    def failed(self) -> None:
        """The run ends here."""
        self._tell(self._now(), over=True)

    def _tell(self, now: float, *, over: bool = False) -> None:
        if self._told is None:
            return
        speed = eta = math.nan
        if self._paced_from is not None:
            wall, time, step = self._paced_from
            if self._step > step and now > wall:
                speed = (self._step - step) / (now - wall)
                eta = (now - wall) * (self._until - self._time) / (self._time - time)
        self._last_told = now
        self._told(
            Progress(
                start=self._start,
                time=self._time,
                until=self._until,
                step=self._step,
                dt=self._dt,
                records=self._records,
                wall=now - self._began,
                steps_per_second=speed,
                eta=eta,
                start_energy=self._start_energy,
                energy=self._energy,
                driven=self._driven,
                folded_since=self._folded_since,
                over=over,
            )
        )


class ProgressLine:
    """Shows the progress of runs: a bar on a terminal, a line now and then elsewhere.

    ``stream`` is standard error unless given; ``every`` [s] of wall time apart are the lines that
    go to a file or a pipe (the last one always comes).
    """

    def __init__(self, *, stream: TextIO | None = None, every: float = 10.0) -> None:
        self._display = Display(stream=stream, every=every)

    def __call__(self, progress: Progress) -> None:
        """Show it if it is time to."""
        p = progress
        self._display.show(p.percent, state(p), at=p.wall, last=p.over)


def state(progress: Progress) -> str:
    """``t = 0.042 of 0.1 s, 310 steps, 95.1 steps/s, 4.2 s left, ...``."""
    p = progress
    parts = [f"t = {p.time:.5g} of {p.until:.5g} s", f"{p.step} steps", f"dt {p.dt:.3g} s"]
    if math.isfinite(p.steps_per_second):
        parts.append(f"{p.steps_per_second:.3g} steps/s")
        parts.append(f"{duration(p.wall)} taken" if p.over else f"{duration(p.eta)} left")
    if math.isfinite(p.energy):
        parts.append(_energy(p))
    if math.isfinite(p.folded_since):
        parts.append(f"positions folded since t = {p.folded_since:.4g} s")
    return ", ".join(parts)


def _energy(p: Progress) -> str:
    # A body that starts at rest has no energy to compare with, and what a load puts in is no change
    # of what there was.
    if not p.driven and p.start_energy > 0.0 and abs(p.energy) < 100.0 * p.start_energy:
        return f"energy change {100.0 * p.energy_change / p.start_energy:+.2g} %"
    return f"energy {p.energy:.3g} J"
