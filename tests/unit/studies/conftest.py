"""A study that costs nothing, to try the machinery on."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import pandas as pd
import pytest

from studies.harness.cases import Case
from studies.harness.front import Results, Study
from studies.report.document import Document, Figure, Paragraph, Section, Table
from studies.measures.order import order_table
from studies.report.plotting import Curve, convergence_panel, outside_legend, panels, save_figure
from studies.report.standard_sections import subtitle, what_failed, what_was_run

HERE = str(Path(__file__).resolve().parent)


@pytest.fixture(autouse=True)
def _workers_find_the_cases(monkeypatch):
    """``fake_cases`` is imported by name here and in the workers, which inherit PYTHONPATH."""
    monkeypatch.syspath_prepend(HERE)
    inherited = [HERE, *filter(None, [os.environ.get("PYTHONPATH")]), *filter(None, sys.path)]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(inherited))


@pytest.fixture(autouse=True)
def _kernel_cache_of_its_own(monkeypatch, tmp_path):
    """Marks of finished warm-ups go to a folder of this test."""
    monkeypatch.setattr("studies.harness.warm_up.CACHE_DIR", tmp_path / "cache")


def tables(rows):
    table = pd.DataFrame(rows, columns=["method", "component", "h", "error"])
    return {"table": table, "orders": order_table(table)}


def report(results: Results) -> Document:
    table = results.tables["table"]
    figure, axes = panels(1, 2)
    for ax, (component, part) in zip(axes.flat, table.groupby("component"), strict=True):
        curves = [Curve(str(m), g["h"], g["error"]) for m, g in part.groupby("method")]
        convergence_panel(ax, curves, title=str(component))
    outside_legend(figure, axes.flat)
    save_figure(figure, results.out / "convergence")
    orders = results.tables["orders"]
    sections = [
        Section("Orders", [Figure("Errors.", results.out / "convergence"), Table("Fits.", orders)]),
        Section("Remarks", [Paragraph("Nothing was computed.")]),
        what_was_run(results.run),
        what_failed(results.failures),
    ]
    return Document("A study of powers", "Known.", sections, subtitle=subtitle(results.run))


@pytest.fixture
def fake_study():
    """Make a study of any cases, ``full`` with its warm-up and its figures."""

    def short_report(results: Results) -> Document:
        return Document("Short", "", [what_failed(results.failures)])

    def make(cases: list[Case], *, full: bool = False) -> Study:
        def chosen(options: argparse.Namespace) -> list[Case]:
            return cases

        def nothing(options: argparse.Namespace) -> list[Case]:
            return []

        if full:
            return Study(name="fake", cases=chosen, tables=tables, report=report)
        return Study(
            name="fake", cases=chosen, tables=tables, report=short_report, warm_up=nothing
        )

    return make
