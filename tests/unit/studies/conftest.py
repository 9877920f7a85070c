"""What tests of studies share."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _warm_ups_are_remembered_here(monkeypatch, tmp_path):
    """Marks of finished warm-ups go to a folder of this test."""
    monkeypatch.setattr("studies.engine.pool.CACHE_DIR", tmp_path / "cache")
