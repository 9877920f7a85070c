"""Executors of independent runs: processes of this machine, or an existing Dask cluster.

The shell's sweeps and the studies run on them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from sphsolid.errors import InputError, require
from sphsolid.look.doors import installed

#: Seconds to wait for a scheduler that does not answer.
PATIENCE = 10


@contextmanager
def processes(jobs: int, *, threads: int = 1) -> Iterator[ProcessPoolExecutor]:
    """``jobs`` fresh processes with ``threads`` kernel threads each.

    None is left behind, whether the caller is interrupted or killed.
    """
    # Linear algebra too: several processes whose threads wait for each other by spinning took
    # thirty times as long for the dense spectra.
    counts = ("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    environment = dict.fromkeys(counts, str(threads)) | {"OMP_PROC_BIND": "false"}
    before = {name: os.environ.get(name) for name in environment}
    os.environ.update(environment)
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        jobs, mp_context=multiprocessing.get_context("spawn"), initializer=_prepare_worker
    )
    try:
        yield pool
        pool.shutdown()
    except BaseException:
        for worker in set(multiprocessing.active_children()) - others:
            worker.terminate()
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _prepare_worker() -> None:
    """Leave Ctrl-C to the parent, and do not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow_parent, daemon=True).start()


def _follow_parent() -> None:
    parent = multiprocessing.parent_process()
    while parent is not None and parent.is_alive():
        time.sleep(1.0)
    os._exit(1)


@dataclass(frozen=True)
class Cluster:
    """An ``executor`` on so many ``workers``; ``killed`` is raised for work whose worker died."""

    executor: Executor
    workers: int
    killed: type[Exception]


@contextmanager
def cluster(address: str) -> Iterator[Cluster]:
    """The workers of the Dask scheduler at ``address``, with one thread of Dask's each.

    Raises ``InputError`` where dask.distributed is not installed, no scheduler answers, or a worker
    has more threads: kernels of two runs cannot run in one process.
    """
    require(
        installed("distributed"),
        f"--scheduler {address} needs dask.distributed, which is not installed: pip install "
        "'sphsolid[cluster]'",
    )
    from distributed import Client, KilledWorker

    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: no Dask scheduler answers within {PATIENCE} s ({error}); "
            "start one with `dask scheduler` and workers with `dask worker ADDRESS --nthreads 1`"
        ) from None
    with client:
        counts = list(client.nthreads().values())
        require(
            set(counts) == {1},
            f"--scheduler {address}: {len(counts)} workers with {counts} threads; there must be "
            "some, started with `dask worker ADDRESS --nworkers N --nthreads 1`",
        )
        yield Cluster(_OnClient(client), len(counts), KilledWorker)


class _OnClient(Executor):
    """Work for a Dask ``client``; what a lost worker had done is done again.

    Dask's own executor looks twice at a task that ended, at its result and at its state.  Where the
    worker that holds the result dies between, it takes the result for an error.
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand out the call ``fn(*args, **kwargs)``."""
        # Equal runs are different work: pure=False keeps Dask from handing out an old result.
        task = self._client.submit(fn, *args, pure=False, **kwargs)
        handed: Future[Any] = Future()

        def hand_over(_: Any) -> None:
            if not handed.set_running_or_notify_cancel():
                return
            try:
                handed.set_result(task.result())
            except BaseException as error:
                handed.set_exception(error)

        def give_up(_: Future[Any]) -> None:
            if handed.cancelled():
                task.cancel()

        handed.add_done_callback(give_up)
        task.add_done_callback(hand_over)
        return handed
