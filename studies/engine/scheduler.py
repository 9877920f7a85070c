"""The cases of a study on an existing Dask cluster: ``--scheduler tcp://host:8786``."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager

from sphsolid.errors import InputError, require
from studies.engine.pool import OnExecutor, Workers

#: Seconds to wait for a scheduler that does not answer.
PATIENCE = 10


@contextmanager
def on_cluster(address: str, *, jobs: int | None = None) -> Iterator[Workers]:
    """Workers of the Dask scheduler at ``address``; raises ``InputError`` if none answers.

    The workers need this checkout and, for studies with pictures, the same folder of results.
    ``jobs`` cases are under way at once: all threads of the cluster if left out.  A case whose
    worker is killed is given to other workers as often as the scheduler allows
    (``distributed.scheduler.allowed-failures``), and then fails alone.
    """
    require(
        importlib.util.find_spec("distributed") is not None,
        f"--scheduler {address} needs dask.distributed: pip install 'sphsolid[cluster]'",
    )
    from distributed import Client

    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: no Dask scheduler answers within {PATIENCE} s ({error}); "
            "start one with `dask scheduler` and workers with `dask worker ADDRESS`"
        ) from error
    with client:
        threads = sum(client.nthreads().values())
        require(threads > 0, f"--scheduler {address}: the cluster has no workers yet")
        # Equal cases are different work: pure=False keeps Dask from handing out an old result.
        with client.get_executor(pure=False) as executor:
            yield OnExecutor(executor, jobs or threads)
