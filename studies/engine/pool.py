"""Runs the cases of a study: in processes of this machine, or on any executor.

Workers of this machine are started afresh (``spawn``) with one kernel thread each: independent
cases side by side use a machine better than threads inside one.  The parent must run no kernel
while workers are wanted, since the thread count is read when a process compiles its first one.
"""

from __future__ import annotations

import hashlib
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

import numba

from sphsolid.compiled import CACHE_DIR
from sphsolid.record.display import duration
from sphsolid.shell.pools import processes
from studies.engine.case import Case, Outcome, case_hash, execute
from studies.engine.provenance import cpu_model

#: How often [s] a caller without news is told that time passes.
TICK = 0.5
Finished = Generator[tuple[Case, Outcome], None, None]


class Watch:
    """Is told what becomes of the cases; this one does nothing with it."""

    def started(self, case: Case) -> None:
        """A worker took the case."""

    def tick(self) -> None:
        """Time passed."""


NOBODY = Watch()


class Workers(Protocol):
    """Something that runs cases, so many ``at_once``."""

    @property
    def at_once(self) -> int:
        """How many."""
        ...

    def run(self, cases: Sequence[Case], watch: Watch = NOBODY) -> Finished:
        """Yield cases with their outcome as they finish."""
        ...


def longest_first(cases: Sequence[Case]) -> list[Case]:
    """Most expensive first, so that no long case starts when the others are done."""
    return sorted(cases, key=lambda case: -case.cost)


@dataclass(frozen=True)
class OnExecutor:
    """Any ``concurrent.futures`` executor; ``at_once`` cases are handed to it at a time.

    What an executor raises in the place of a result is the failure of that case alone; ``death`` is
    what it raises where a worker was killed.  ``task(case)`` is what a worker does.
    """

    executor: Executor
    at_once: int
    death: type[Exception] = BrokenExecutor
    task: Callable[[Case], Outcome] = execute

    def run(self, cases: Sequence[Case], watch: Watch = NOBODY) -> Finished:
        """Yield cases with their outcome as they finish, begun in the given order."""
        waiting = deque(cases)
        running: dict[Future[Outcome], Case] = {}
        try:
            while waiting or running:
                while waiting and len(running) < self.at_once:
                    case = waiting.popleft()
                    watch.started(case)
                    running[self.executor.submit(self.task, case)] = case
                done, _ = wait(running, timeout=TICK, return_when=FIRST_COMPLETED)
                watch.tick()
                for future in done:
                    case = running.pop(future)
                    try:
                        outcome = future.result()
                    except self.death as error:
                        outcome = died(case, str(error))
                    except Exception as error:
                        outcome = unable(case, error)
                    yield case, outcome
        finally:
            for future in running:
                future.cancel()


@dataclass(frozen=True)
class Processes:
    """``at_once`` processes of this machine with ``threads`` kernel threads each.

    A worker that dies (most often: killed for want of memory) fails its own case only.  The cases
    that ran beside it are tried again, one at a time, to find out which it was.
    """

    at_once: int
    threads: int = 1

    def run(self, cases: Sequence[Case], watch: Watch = NOBODY) -> Finished:
        """Yield cases with their outcome as they finish."""
        waiting = deque(cases)
        suspects: deque[Case] = deque()
        while waiting or suspects:
            alone = bool(suspects)
            queue = suspects if alone else waiting
            broken: list[Case] = []
            with processes(1 if alone else self.at_once, threads=self.threads) as pool:
                running: dict[Future[Outcome], Case] = {}
                while (queue or running) and not broken:
                    while queue and len(running) < (1 if alone else self.at_once):
                        case = queue.popleft()
                        watch.started(case)
                        try:
                            running[pool.submit(execute, case)] = case
                        except BrokenProcessPool:
                            broken.append(case)
                            break
                    done, _ = wait(running, timeout=TICK, return_when=FIRST_COMPLETED)
                    watch.tick()
                    for future in done:
                        case = running.pop(future)
                        try:
                            outcome = future.result()
                        except BrokenProcessPool:
                            broken.append(case)
                            continue
                        except Exception as error:
                            outcome = unable(case, error)
                        yield case, outcome
                broken += running.values()
            if broken and alone:
                yield broken[0], died(broken[0], "the process was killed")
            else:
                suspects.extend(broken)


def died(case: Case, why: str) -> Outcome:
    """The outcome of a case whose worker was killed."""
    return Outcome(
        case.key,
        float("nan"),
        failure="WorkerDied",
        message=f"{why}, most likely for want of memory; run it with fewer --jobs or coarser",
    )


def unable(case: Case, error: Exception) -> Outcome:
    """The outcome of a case that could not be sent to a worker, or whose outcome not back."""
    return Outcome(
        case.key, float("nan"), failure=type(error).__name__, message=f"no worker ran it: {error}"
    )


def warm_up(cases: Sequence[Case], *, threads: int, say: Callable[[str], None]) -> None:
    """Run tiny ``cases`` one after the other for what they compile; their rows are dropped.

    Workers that start together would each compile the same kernels; afterwards all of them read
    numba's disk cache.  What has been compiled is remembered by a file beside that cache, so only
    the first run waits.  A case that fails here fails again, and visibly, in the study.
    """
    if not cases or CACHE_DIR is None:
        return
    parts = [numba.__version__, cpu_model(), str(threads > 1), *map(case_hash, cases)]
    mark = CACHE_DIR / f"warm-{hashlib.sha256('|'.join(parts).encode()).hexdigest()[:16]}"
    if mark.exists():
        return
    say("compiling kernels (first run only) ...")
    start = time.perf_counter()
    failed = [
        outcome.key
        for _, outcome in Processes(1, threads).run(cases)
        if outcome.failed
    ]
    say(f"compiled in {duration(time.perf_counter() - start)}")
    if not failed:
        # Without a place to remember it, the next run of the study looks again.
        with suppress(OSError):
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.touch()
