"""The cases of a study on an existing Dask cluster: ``--scheduler tcp://host:8786``."""

from __future__ import annotations

import hashlib
import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numba

from sphsolid.compiled import set_threads, source_hash
from sphsolid.errors import InputError, require
from studies.engine.case import Case, Outcome, execute
from studies.engine.pool import OnExecutor, Workers
from studies.engine.sources import ROOT

#: Seconds to wait for a scheduler that does not answer.
PATIENCE = 10


def _sources() -> str:
    digest = hashlib.sha256(source_hash().encode())
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
    require(
        importlib.util.find_spec("distributed") is not None,
        f"--scheduler {address} needs dask.distributed: pip install 'sphsolid[cluster]'",
    )
    from distributed import Client, KilledWorker

    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: no Dask scheduler answers within {PATIENCE} s ({error}); "
            "start one with `dask scheduler` and workers with `dask worker ADDRESS --nthreads 1`"
        ) from error
    with client:
        counts = list(client.nthreads().values())
        require(
            set(counts) == {1},
            f"--scheduler {address}: {len(counts)} workers with {counts} threads; there must be "
            "some, started with `dask worker ADDRESS --nworkers N --nthreads 1`",
        )
        # Equal cases are different work: pure=False keeps Dask from handing out an old result.
        with client.get_executor(pure=False) as executor:
            yield OnExecutor(executor, jobs or len(counts), KilledWorker, OnWorker(threads))


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
