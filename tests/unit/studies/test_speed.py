"""The speed study: rows, the machine's share, and every verdict on made-up tables."""

from __future__ import annotations

import argparse

import pandas as pd
import pytest

import sphsolid as sph
from sphsolid.compiled import set_threads, threads
from studies.methods import B_BAR
from studies.speed import (
    COLUMNS,
    DEFAULT,
    OVER_ELEMENTS,
    OWN_SUPG,
    PAPERS,
    cases,
    claims,
    counting,
    options,
    tables,
    words,
)
from studies.speed.passes import passes
from studies.speed.timings import in_turns, step


@pytest.fixture(autouse=True)
def _as_many_threads_after_as_before():
    before = threads()
    yield
    set_threads(before)


def test_a_timing_makes_rows_and_tables():
    rows = [{"kind": "machine", "threads": 1, "bandwidth": 8.0e9, "flops": 1.0e10}]
    for method in (OWN_SUPG.but(tau_p=sph.OfStep(0.1)), B_BAR):
        rows += step(method=method, jitter=0.0, cells=3, threads=1, work=30.0)
    made = tables(rows)
    assert {name: list(table) for name, table in made.items()} == COLUMNS
    first, elements = made["table"].itertuples()
    assert first.ns_per_particle_step > 0.0
    assert first.bytes_per_particle > 100.0
    needs = max(first.traffic_per_particle / 8.0, first.flops_per_particle / 10.0)
    assert first.roofline_share == pytest.approx(needs / first.ns_per_particle_step)
    assert elements.particles == 3**3
    assert made["passes"]["pass"].tolist() == [
        "gradient, projection, stress", "secondary points", "adjoint of the interpolation", "R_p",
        "D(J)", "D(p)", "divergence", "time step",
    ]  # fmt: skip
    assert words(made)["asked"] == 0, "nothing was aimed at for three cells"
    assert list(tables([])["table"]) == COLUMNS["table"]


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_a_step_of_the_default_is_timed_as_a_whole(jitter):
    (row,) = step(method=DEFAULT, jitter=jitter, cells=3, threads=1, work=30.0)
    assert row["kind"] == "step"
    assert row["storage"] == ("CSR" if jitter else "lattice lines")
    assert row["flops_per_particle"] > 100.0
    # Two sweeps over positions, and over velocities in four steps of fifteen; a stress is written
    # and read; two fields are read and written; off a lattice the operator is read.
    least = 8.0 * (2 * 3 * (1 + 4 / 15) + 2 * 9 + 2 * 2 * 3)
    assert row["traffic_per_particle"] > 0.999 * least
    assert (row["traffic_per_particle"] > 1.01 * least) == bool(jitter)


def test_methods_and_threads_take_turns():
    rows = in_turns(methods=(DEFAULT, B_BAR), cells=3, threads=(1, 2))
    told = [(row["method"], row["threads"], row["particles"]) for row in rows]
    assert told == [
        (DEFAULT.name, 1, 4**3), (DEFAULT.name, 2, 4**3), (B_BAR.name, 1, 3**3),
        (B_BAR.name, 2, 3**3),
    ]  # fmt: skip
    assert all(row["ns_per_particle_step"] > 0.0 and row["spread"] >= 0.0 for row in rows)
    assert list(tables(rows)["turns"]) == COLUMNS["turns"]


def test_passes_that_are_absent_are_not_listed():
    bare = options()[0].simulation(sph.scenes.swinging_cube(), spacing=1 / 3)
    names = [each.name for each in passes(bare)]
    assert names == ["gradient, projection, stress", "divergence", "time step"]


def test_operations_are_counted_by_doing_them():
    material = sph.NeoHookean.from_young(young_modulus=1.0, poisson_ratio=0.3, density=1.0)
    # 9 products of F, 9 additions of products of H, the contraction's 17, and the scalars.
    both = counting.stress_operations(material, has_H=True, has_J=True)
    assert 27 + 17 < both < 100
    with_H = counting.stress_operations(material, has_H=False, has_J=True)
    assert with_H == both + 27, "nine times two products and a difference"
    assert counting.contraction_operations() == 17


def made_up(paper=300.0, own=250.0, one=600.0, jitter=700.0, fem=400.0, column=0.5):
    def row(method, cells, ns, cloud="lattice", count=2):
        return {"method": method.name, "cells": cells, "particles": (cells + 1) ** 3,
                "cloud": cloud, "threads": count, "ns_per_particle_step": ns,
                "bytes_per_particle": 1200.0}  # fmt: skip

    sizes = ((22, 1.0), (32, 1.0), (64, 1.1), (100, 1.2))
    steps = [
        row(PAPERS, 32, paper), row(PAPERS, 32, one, count=1), row(B_BAR, 32, fem),
        row(PAPERS, 32, jitter, "jitter 0.2"),
        *(row(OWN_SUPG, cells, own * factor) for cells, factor in sizes),
    ]  # fmt: skip
    return {
        "table": pd.DataFrame(steps),
        "turns": pd.DataFrame(steps),
        "column": pd.DataFrame([{"integrator": "V", "cpu_ms_per_particle": column}]),
        "start": pd.DataFrame([{"cold_s": 30.0, "warm_s": 2.0}]),
    }


def test_targets_are_met_or_not_by_their_figures():
    judged = {claim.what: claim.verdict for claim in claims(made_up())}
    assert set(judged.values()) == {"met", "reported"}
    assert not any("65^3" in what and "paper" in what for what in judged), "what was not run"
    slow = made_up(paper=450.0, jitter=900.0, fem=600.0, column=2.0)
    assert {claim.what for claim in claims(slow) if claim.verdict == "not met"} == {
        "a particle-step of the paper's, lattice 33^3", "an element-step, B-bar 32^3",
        "a particle-step of the paper's, jitter 0.2", "2 threads over one, the paper's step",
        "CPU time a particle of the column, V",
    }  # fmt: skip


def of_default(over=0.5, one=0.55, disorder=250.0, share=0.6, gain=1.9, held=350.0):
    """Rows of the default and of elements on every lattice, with one thread and two."""
    rows = []
    for cells in OVER_ELEMENTS:
        common = {"cells": cells, "particles": (cells + 1) ** 3, "cloud": "lattice",
                  "bytes_per_particle": held, "roofline_share": share}  # fmt: skip
        for count, ratio, elements in ((2, over, 100.0), (1, one, 100.0 * gain * over / one)):
            times = ((DEFAULT, ratio * elements), (B_BAR, elements))
            rows += [
                common | {"method": m.name, "threads": count, "ns_per_particle_step": ns}
                for m, ns in times
            ]
    rows.append(rows[0] | {"cloud": "jitter 0.4", "ns_per_particle_step": disorder})
    nothing = {"column": pd.DataFrame(), "start": pd.DataFrame()}
    return {"table": pd.DataFrame(rows), "turns": pd.DataFrame(rows[:-1])} | nothing


@pytest.mark.parametrize(
    ("change", "missed"),
    [
        ({}, set()),
        ({"over": 0.7}, {f"particle-step of the default over element-step, {n}^3, 2 thread(s)"
                         for n in (33, 65)}),
        ({"one": 0.9}, {f"particle-step of the default over element-step, {n}^3, 1 thread(s)"
                        for n in (17, 33, 65)}),
        ({"disorder": 310.0}, {"a particle-step of the default, jitter 0.4"}),
        ({"share": 0.4}, {"share of what the machine can do, the default step, 33^3"}),
        ({"gain": 1.7}, {"2 threads over one, the default step"}),
        ({"held": 410.0}, {"bytes a particle of the default, lattice"}),
    ],
)  # fmt: skip
def test_each_target_of_the_default_can_be_missed(change, missed):
    found = claims(of_default(**change))
    own = {claim.what: claim.verdict for claim in found if "default" in claim.what}
    assert len(own) == 8 + 4 + 2
    assert {what for what, verdict in own.items() if verdict == "not met"} == missed


def test_every_timing_is_listed_once():
    for quick in (True, False):
        listed = cases(argparse.Namespace(quick=quick, threads=2))
        assert len({case.key for case in listed}) == len(listed) == (11 if quick else 70)
