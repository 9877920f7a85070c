"""Workers of a sweep: processes of this machine, or an existing Dask cluster.

A worker that is killed costs what it was running.  Of this machine's processes nobody knows which
one was to blame, so those that were under way run again one by one; the one that dies alone fails.
"""

from __future__ import annotations

import multiprocessing
import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager
from typing import Any

from sphsolid.errors import InputError, require
from sphsolid.look.doors import installed
from sphsolid.shell.member import Member, Outcome, run_member

#: Seconds to wait for a scheduler that does not answer.
PATIENCE = 10
#: The kernels' and linear algebra's threads of a process: one, since members run side by side.
_ONE_THREAD = ("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
Finished = Iterator[tuple[Member, Outcome]]


def on_this_machine(
    members: Sequence[Member], jobs: int, run: Callable[[Member], Outcome] = run_member
) -> Finished:
    """Members with their outcomes as they finish, ``jobs`` at once."""
    waiting, suspects = deque(members), deque[Member]()
    while waiting or suspects:
        alone = bool(suspects)
        queue = suspects if alone else waiting
        broken: list[Member] = []
        with _processes(1 if alone else jobs) as pool:
            yield from _drain(pool, queue, 1 if alone else jobs, run, broken)
        if broken and alone:
            yield broken[0], _died("the process was killed")
        else:
            suspects.extend(broken)


def on_cluster(members: Sequence[Member], address: str) -> Finished:
    """The same on the workers of the Dask scheduler at ``address``.

    Raises ``InputError`` where dask.distributed is not installed or no scheduler answers.
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
        threads = list(client.nthreads().values())
        require(
            set(threads) == {1},
            f"--scheduler {address}: {len(threads)} workers with {threads} threads; there must be "
            "some, started with `dask worker ADDRESS --nworkers N --nthreads 1`",
        )
        # Equal members are different work: pure=False keeps Dask from handing out an old result.
        with client.get_executor(pure=False) as pool:
            lost: list[Member] = []
            yield from _drain(pool, deque(members), len(threads), run_member, lost, KilledWorker)
            for member in lost:
                yield member, _died("its worker was killed")


def _drain(
    pool: Executor, queue: deque[Member], at_once: int, run: Callable[[Member], Outcome],
    broken: list[Member], killed: Any = BrokenExecutor,
) -> Finished:  # fmt: skip
    """Run what is in ``queue``; ``broken`` takes those whose worker died."""
    running: dict[Future[Outcome], Member] = {}
    while queue or running:
        # After a death nothing more is begun: the pool of a machine is of no use any more.
        while queue and len(running) < at_once and not (broken and killed is BrokenExecutor):
            member = queue.popleft()
            try:
                running[pool.submit(run, member)] = member
            except BrokenExecutor:
                broken.append(member)
        if not running:
            return
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            member = running.pop(future)
            try:
                outcome = future.result()
            except killed:
                broken.append(member)
                continue
            except Exception as error:
                outcome = Outcome("failed", reason=f"no worker ran it: {error}")
            yield member, outcome


@contextmanager
def _processes(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Fresh processes with one kernel thread; none is left behind when the sweep is interrupted."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn"))
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


def _died(why: str) -> Outcome:
    return Outcome("failed", reason=f"{why}, most likely for want of memory; use fewer --jobs")
