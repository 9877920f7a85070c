"""Tests share the cores between workers, not between the threads of one."""

from __future__ import annotations

import pytest

from sphsolid.compiled import set_threads


def pytest_configure(config: pytest.Config) -> None:
    """One kernel thread in a worker of pytest-xdist; tests of threads ask for theirs."""
    if hasattr(config, "workerinput"):
        set_threads(1)
