"""Compiles every kernel of a study once, in one process, before the workers start.

Workers that start together would each compile the same kernels; afterwards all of them read
numba's disk cache.  What has been compiled is remembered by a file beside that cache, so only the
first run waits.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

import numba

from sphsolid.compiled import CACHE_DIR
from sphsolid.record.display import duration
from studies.engine.case import Case, case_hash
from studies.engine.pool import Processes
from studies.engine.provenance import cpu_model


def warm_up(cases: Sequence[Case], *, threads: int, say: Callable[[str], None]) -> None:
    """Run tiny ``cases`` one after the other for what they compile; their rows are dropped.

    A case that fails here fails again, and visibly, in the study.
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
