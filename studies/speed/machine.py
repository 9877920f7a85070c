"""What the machine gives: memory bandwidth and multiply-add rate, measured in the same run."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from sphsolid.compiled import kernel, prange

#: Numbers in an array that no cache holds (256 MB), and in one that any holds.
_LARGE, _SMALL = 2**25, 2**10


@kernel
def _triad(a, b, c, out):  # type: ignore[no-untyped-def]
    for i in prange(len(out)):
        out[i] = a * b[i] + c[i]


@kernel
def _multiply_add(repeats, x, out):  # type: ignore[no-untyped-def]
    # Eight independent chains a number, so that nothing waits for the one before.
    for t in prange(len(out)):
        for i in range(x.shape[0]):
            s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = x[i]
            for _ in range(repeats):
                s0 = s0 * 0.999 + 0.1
                s1 = s1 * 0.998 + 0.1
                s2 = s2 * 0.997 + 0.1
                s3 = s3 * 0.996 + 0.1
                s4 = s4 * 0.995 + 0.1
                s5 = s5 * 0.994 + 0.1
                s6 = s6 * 0.993 + 0.1
                s7 = s7 * 0.992 + 0.1
            out[t, i] = ((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7))


@dataclass(frozen=True)
class Machine:
    """``bandwidth`` [byte/s] of a triad (reads, writes and the reads before writes) and ``flops``
    [1/s] of scalar multiply-adds times ``lanes``, the doubles a vector register holds.
    """

    bandwidth: float
    flops: float


def measure(threads: int, *, lanes: int = 4, repeats: int = 5) -> Machine:
    """Best of ``repeats`` with the threads that kernels use now."""
    b, c, out = np.ones(_LARGE), np.ones(_LARGE), np.zeros(_LARGE)
    triad = _best(lambda: _triad(0.5, b, c, out), repeats)
    # A store reads its line first: 32 bytes a number, not 24.
    bandwidth = 32.0 * _LARGE / triad
    x, sums = np.linspace(0.0, 1.0, _SMALL), np.zeros((threads, _SMALL))
    chain = _best(lambda: _multiply_add(200, x, sums), repeats)
    return Machine(bandwidth, lanes * 16.0 * 200 * _SMALL * threads / chain)


def _best(run, repeats: int) -> float:  # type: ignore[no-untyped-def]
    run()
    best = float("inf")
    for _ in range(repeats):
        started = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - started)
    return best
