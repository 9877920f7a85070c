"""Workers of a sweep: processes of this machine, or an existing Dask cluster.

A worker that is killed costs what it was running.  Of this machine's processes nobody knows which
one was to blame, so those that were under way run again one by one; the one that dies alone fails.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from typing import Any

from sphsolid.shell.member import Member, Outcome, run_member
from sphsolid.shell.pools import cluster, processes

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
        with processes(1 if alone else jobs) as pool:
            yield from _drain(pool, queue, 1 if alone else jobs, run, broken)
        if broken and alone:
            yield broken[0], _died("the process was killed")
        else:
            suspects.extend(broken)


def on_cluster(members: Sequence[Member], address: str) -> Finished:
    """The same on the workers of the Dask scheduler at ``address``.

    Raises ``InputError`` as :func:`~sphsolid.shell.pools.cluster` does.
    """
    with cluster(address) as found:
        lost: list[Member] = []
        pool, at_once = found.executor, found.workers
        yield from _drain(pool, deque(members), at_once, run_member, lost, found.killed)
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


def _died(why: str) -> Outcome:
    return Outcome("failed", reason=f"{why}, most likely for want of memory; use fewer --jobs")
