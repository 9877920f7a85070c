"""The cases of a study on an existing Dask cluster: ``--scheduler tcp://host:8786``."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numba

from sphsolid.compiled import SOURCE_HASH, set_threads
from sphsolid.shell.pools import cluster
from studies.engine.case import Case, Outcome, execute
from studies.engine.pool import OnExecutor, Workers
from studies.engine.sources import ROOT


def _sources() -> str:
    digest = hashlib.sha256(SOURCE_HASH.encode())
    for path in sorted((ROOT / "studies").rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


#: Sources as this process imported them.
SOURCES = _sources()


@contextmanager
def on_cluster(address: str, *, jobs: int | None = None, threads: int = 1) -> Iterator[Workers]:
    """Workers of the Dask scheduler at ``address``; raises ``InputError`` if none answers.

    Each worker has one thread of Dask's, because kernels of two cases cannot run in one process,
    and ``threads`` kernel threads.  ``jobs`` cases are under way at once, as many as there are
    workers if left out.  A case whose worker is killed is given to other workers as often as the
    scheduler allows (``distributed.scheduler.allowed-failures``), and then fails alone.
    """
    with cluster(address) as found:
        at_once = jobs or found.workers
        yield OnExecutor(found.executor, at_once, found.killed, OnWorker(threads))


@dataclass(frozen=True)
class OnWorker:
    """What a worker of a cluster does with a case, with ``threads`` kernel threads.

    A kept outcome is known by the sources of where the study was started, ``sources``.
    """

    threads: int
    sources: str = SOURCES

    def __call__(self, case: Case) -> Outcome:
        """Run the case, or fail where the worker has imported other sources."""
        if self.sources != SOURCES:
            return Outcome(
                case.key,
                float("nan"),
                failure="OtherSources",
                message="the worker has other sources than the study: restart the workers",
            )
        set_threads(min(self.threads, numba.config.NUMBA_NUM_THREADS))
        return execute(case)
