"""The notebook of the examples: it runs from top to bottom, and its results show themselves."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def test_the_notebook_runs_and_shows_pictures_and_tables(tmp_path, monkeypatch):
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setenv("PYTHONPATH", path)
    # The kernel of this environment, whatever else is registered on the machine.
    monkeypatch.setenv("JUPYTER_PREFER_ENV_PATH", "1")
    monkeypatch.setenv("JUPYTER_PATH", str(Path(sys.prefix) / "share" / "jupyter"))
    notebook = nbformat.read(ROOT / "examples" / "first_run.ipynb", as_version=4)
    nbformat.validate(notebook)
    assert all(not cell.get("outputs") for cell in notebook.cells), "kept without its outputs"
    nbclient.NotebookClient(
        notebook, timeout=900, kernel_name="python3", resources={"metadata": {"path": tmp_path}}
    ).execute()
    shown = [
        set(output["data"]) for cell in notebook.cells for output in cell.get("outputs", [])
        if output["output_type"] == "execute_result"
    ]  # fmt: skip
    assert len(shown) == 4
    curves, body, comparison, film = shown
    assert "image/png" in curves
    assert "image/png" in body
    assert "text/html" in comparison
    assert "text/html" in film
