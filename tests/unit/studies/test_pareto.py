"""The pareto study: iso-errors, reference, verdicts, choice on tables made up for them; its end."""

from __future__ import annotations

import argparse
import math
from typing import Any

import numpy as np
import pandas as pd
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.compiled import threads
from sphsolid.defaults import default_stabilisation
from sphsolid.scenes import twisting_column
from studies.harness.results import read_results, write_csv
from studies.pareto import cases, cost, study
from studies.pareto.choice import SAME_COST, WITHIN, chosen, recommendation
from studies.pareto.figures import spread_out
from studies.pareto.iso_error import (
    BETWEEN,
    BEYOND,
    COARSEST,
    COSTS,
    NEVER,
    envelope,
    iso_error,
    iso_table,
)
from studies.pareto.methods import (
    B_BAR,
    CANDIDATES,
    COMPARED,
    FEM,
    METHODS,
    MIXED,
    OPTIONS,
    Elements,
    goes_finest,
)
from studies.pareto.reference import column_errors, limit, reference, spread
from studies.pareto.scenes import COLUMN, CUBE, MEASURES, stated, stress_size, timed
from studies.pareto.tables import COLUMNS, tables
from studies.pareto.verdicts import (
    CHEAPER,
    DEARER,
    NEITHER,
    ONLY_FEM,
    ONLY_SPH,
    OPEN,
    SAME,
    UNSURE,
    ratios,
    sentence,
)
from studies.report.document_pdf import write_pdf
from studies.report.plotting import style

LEVELS = np.array([4.0, 8.0, 16.0])
POWERS = {"particles": LEVELS**3, "cpu_s_per_s": 2.0 * LEVELS**4, "bytes": 100.0 * LEVELS**3}


# --- iso-errors ---------------------------------------------------------------------------------


def test_powers_are_interpolated_exactly():
    found = iso_error(list(10.0 / LEVELS**2), POWERS, 10.0 / 12.0**2)
    assert found.how == BETWEEN
    assert found.costs["particles"] == pytest.approx(12.0**3)
    assert found.costs["cpu_s_per_s"] == pytest.approx(2.0 * 12.0**4)
    assert found.costs["bytes"] == pytest.approx(100.0 * 12.0**3)


def test_an_error_of_a_lattice_itself_costs_that_lattice():
    found = iso_error(list(10.0 / LEVELS**2), POWERS, 10.0 / 64.0)
    assert found.how == BETWEEN
    assert found.costs["particles"] == pytest.approx(8.0**3)


def test_at_most_a_refinement_is_extrapolated():
    error = list(10.0 / LEVELS**2)
    found = iso_error(error, POWERS, 10.0 / 30.0**2)
    assert found.how == BEYOND
    assert found.costs["cpu_s_per_s"] == pytest.approx(2.0 * 30.0**4)
    beyond = iso_error(error, POWERS, 10.0 / 33.0**2)
    assert beyond.how == NEVER
    assert all(math.isnan(value) for value in beyond.costs.values())


def test_an_error_that_stalls_is_not_extrapolated():
    assert iso_error([0.1, 0.05, 0.05], POWERS, 0.04).how == NEVER
    assert iso_error([0.1], {"particles": [8.0]}, 0.05).how == NEVER


def test_a_zero_crossing_on_a_coarse_lattice_is_luck():
    assert envelope(np.array([1e-6, 0.04, 0.01])).tolist() == [0.04, 0.04, 0.01]
    found = iso_error([1e-6, 0.04, 0.01], POWERS, 0.02)
    assert found.how == BETWEEN
    assert 8.0**3 < found.costs["particles"] < 16.0**3
    assert found.costs["particles"] == pytest.approx(np.sqrt(8.0**3 * 16.0**3))


def test_the_coarsest_lattice_may_be_enough():
    found = iso_error([0.05, 0.02, 0.01], POWERS, 0.1)
    assert found.how == COARSEST
    assert found.costs == {name: values[0] for name, values in POWERS.items()}


def test_a_lost_run_reaches_nothing():
    assert iso_error([0.05, 0.02, float("nan")], POWERS, 0.1).how == NEVER
    found = iso_error([float("nan"), 0.02, 0.01], POWERS, 0.05)
    assert found.how == COARSEST
    assert found.costs["particles"] == 8.0**3


# --- reference ----------------------------------------------------------------------------------


def test_a_limit_of_second_order_is_exact():
    values = [5.9 + 2.0 / n**2 for n in (5, 10, 16)]
    assert limit(values, [5, 10, 16]) == pytest.approx(5.9)
    assert spread(values, [5, 10, 16]) == pytest.approx(0.0, abs=1e-12)
    assert spread(values[1:], [10, 16]) == pytest.approx(2.0 / 16**2)


def made_up_history(limits: dict[str, float], cubic: float = 0.0) -> pd.DataFrame:
    """Twists ``t (a + 2 / n^2 + cubic / n^3)`` on three lattices; energy falls by a tenth."""
    rows = [
        {"scene": COLUMN, "nu": 0.495, "method": method, "cells": cells, "time [s]": time,
         "twist [rad]": 10.0 * time * (a + 2.0 / cells**2 + cubic / cells**3),
         "energy [J]": 100.0 * (1.0 - time)}
        for method, a in limits.items() for cells in (5, 10, 16) for time in (0.0, 0.05, 0.1)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def test_the_reference_is_between_the_kinds_and_says_how_sure_it_is():
    known = reference(made_up_history({"A": 5.9, "B": 5.92}), kinds=("A", "B"))
    end = known.iloc[-1]
    assert end["twist [rad]"] == pytest.approx(5.91)
    assert end["uncertainty [rad]"] == pytest.approx(0.01)
    assert (end["kinds"], end["finest"]) == (2, 16)
    # Limits that agree but move: the mean of how far they do.
    moving = reference(made_up_history({"A": 5.9, "B": 5.9}, cubic=3.0), kinds=("A", "B"))
    values = [5.9 + 2.0 / n**2 + 3.0 / n**3 for n in (5, 10, 16)]
    expected = abs(limit(values, [5, 10, 16]) - limit(values[:2], [5, 10]))
    assert expected > 1e-3
    assert moving.iloc[-1]["uncertainty [rad]"] == pytest.approx(expected)


def test_no_kind_is_favoured():
    one = reference(made_up_history({"A": 5.9, "B": 6.0}), kinds=("A", "B"))
    other = reference(made_up_history({"A": 6.0, "B": 5.9}), kinds=("A", "B"))
    pd.testing.assert_frame_equal(one, other)


def test_errors_of_the_column_are_shares_of_the_twist():
    history = made_up_history({"A": 5.9, "B": 5.9})
    errors = column_errors(history, reference(history, kinds=("A", "B")))
    row = errors.set_index(["method", "cells"]).loc[("A", 5)]
    assert row["twist_end"] == pytest.approx(2.0 / 25 / 5.9)
    # The error grows with time from nothing: rms over 0, 1/2 and 1.
    assert row["twist_rms"] == pytest.approx(2.0 / 25 / 5.9 * np.sqrt((0.25 + 1.0) / 3.0))
    assert row["energy"] == pytest.approx(0.1)
    assert row["energy_kept"] == pytest.approx(0.9)


def test_a_run_that_ended_early_has_no_errors():
    history = made_up_history({"A": 5.9, "B": 5.9})
    early = history[~((history["cells"] == 5) & (history["time [s]"] == 0.1))]
    errors = column_errors(early, reference(history, kinds=("A", "B")))
    assert set(errors["cells"]) == {10, 16}


# --- verdicts -----------------------------------------------------------------------------------


def made_up_iso(sph_cost: float, fem_cost: float, how: tuple[str, str] = (BETWEEN, BETWEEN),
                share: float = 0.0) -> pd.DataFrame:  # fmt: skip
    rows = [
        {"scene": CUBE, "nu": 0.3, "measure": "momentum", "asked": 0.01, "method": method,
         "family": family, "how": kind, "reference_share": share}
        | {name: value if kind != NEVER else float("nan") for name in COSTS}
        for method, family, value, kind in (
            ("{p,F} H1", MIXED, sph_cost, how[0]), ("{p,F} H6", MIXED, 3.0 * sph_cost, how[0]),
            (B_BAR, FEM, fem_cost, how[1]),
        )
    ]  # fmt: skip
    return pd.DataFrame(rows)


@pytest.mark.parametrize(
    ("sph_cost", "fem_cost", "how", "share", "outcome"),
    [
        (1.0, 2.0, (BETWEEN, BETWEEN), 0.0, CHEAPER),
        (2.0, 1.0, (BETWEEN, BEYOND), 0.0, DEARER),
        (1.05, 1.0, (BETWEEN, BETWEEN), 0.0, SAME),
        (1.0, 2.0, (COARSEST, BETWEEN), 0.0, CHEAPER),
        (2.0, 1.0, (COARSEST, BETWEEN), 0.0, OPEN),
        (2.0, 1.0, (BETWEEN, COARSEST), 0.0, DEARER),
        (1.0, 2.0, (BETWEEN, COARSEST), 0.0, OPEN),
        (1.0, 2.0, (COARSEST, COARSEST), 0.0, OPEN),
        (1.0, 2.0, (BETWEEN, NEVER), 0.0, ONLY_SPH),
        (1.0, 2.0, (NEVER, BETWEEN), 0.0, ONLY_FEM),
        (1.0, 2.0, (NEVER, NEVER), 0.0, NEITHER),
        (1.0, 2.0, (BETWEEN, BETWEEN), 0.6, UNSURE),
    ],
)
def test_every_outcome_is_reached(sph_cost, fem_cost, how, share, outcome):
    compared = ratios(made_up_iso(sph_cost, fem_cost, how, share))
    assert compared["outcome"].tolist() == [outcome]
    if outcome in (CHEAPER, DEARER, SAME):
        assert compared["cpu_ratio"].item() == pytest.approx(sph_cost / fem_cost)
        assert compared["sph"].item() == "{p,F} H1", "the cheapest is compared"


@pytest.mark.parametrize(
    ("pairs", "said"),
    [
        ([(2.0, 1.0), (3.0, 1.0)], "2 to 3 (median 2.5) times the CPU time of FEM, more in all 2"),
        ([(1.0, 2.0), (1.0, 4.0)], "SPH is the cheaper method"),
        ([(2.0, 1.0), (1.0, 2.0), (1.0, 1.0)], "cheaper than FEM in 1, dearer in 1 and within 10%"),
    ],
)
def test_the_sentence_follows_from_the_table(pairs, said):
    assert said in sentence(pd.concat([ratios(made_up_iso(*pair)) for pair in pairs]))


def test_errors_that_one_method_alone_reaches_are_said():
    both = [made_up_iso(2.0, 1.0), made_up_iso(1.0, 1.0, (NEVER, BETWEEN))]
    assert "1 error only FEM reaches" in sentence(pd.concat([ratios(one) for one in both]))
    nothing = ratios(made_up_iso(1.0, 1.0, (NEVER, NEVER)))
    assert sentence(nothing).startswith("No error is reached by both")


# --- choice -------------------------------------------------------------------------------------


def candidates(**changes: Any) -> pd.DataFrame:
    """Three candidates: the second 5 % less accurate at half the cost, the third cheap and bad."""
    frame = pd.DataFrame(
        {
            "method": ["a", "b", "c"], "error_ratio": [1.0, 1.05, 2.0],
            "cpu_s_per_s": [2.0, 1.0, 0.1], "bytes": [3.0, 2.0, 1.0],
        }
    )
    return frame.assign(**changes)


def taken(frame: pd.DataFrame) -> str:
    row = chosen(frame)
    assert row is not None
    return str(row["method"])


def test_the_cheapest_of_those_near_the_best_is_taken():
    assert taken(candidates()) == "b"
    assert taken(candidates(error_ratio=[1.0, 1.0 + 1.01 * WITHIN, 2.0])) == "a"


def test_equal_costs_are_told_apart_by_memory():
    near = 1.0 + 0.9 * SAME_COST
    assert taken(candidates(error_ratio=1.0, cpu_s_per_s=[1.0, near, 2.0])) == "b"
    assert taken(candidates(error_ratio=1.0, cpu_s_per_s=[1.0, 1.3, 2.0])) == "a"


def test_where_none_is_near_in_all_measures_the_smallest_worst_ratio_is_taken():
    assert taken(candidates(error_ratio=[1.5, 1.3, 2.0])) == "b"
    assert chosen(candidates(error_ratio=np.inf)) is None


def made_up_table() -> pd.DataFrame:
    """Every candidate on two lattices of both scenes, {p,F,J} the better, {p,F} none cheap, bad."""
    rows = []
    for scene in (CUBE, COLUMN):
        for label in CANDIDATES:
            method = METHODS[label]
            for particles in (100, 800):
                error = 0.1 if label.startswith("{p,F,J} H1") else 0.13
                row = dict.fromkeys(COLUMNS, float("nan")) | dict(method.setting)
                row |= {"scene": scene, "nu": 0.3, "method": label, "family": method.family,
                        "particles": particles, "survived": True, "cpu_s_per_s": 1.0,
                        "bytes": 1e5, "energy_kept": 0.99, "folded": False}  # fmt: skip
                row |= dict.fromkeys(MEASURES[scene], error) | {"twist_rms_uncertainty": 0.0}
                rows.append(row)
    return pd.DataFrame(rows)


def test_a_recommendation_is_made_for_each_scene_and_for_all():
    found = recommendation(made_up_table()).set_index("scene")
    assert found["formulation"].tolist() == ["{p,F,J}"] * 3
    assert found["stabilisation"].tolist() == ["SUPG-H1"] * 3
    assert found.loc["all", "error_ratio"] == pytest.approx(1.0)


def test_all_scenes_must_agree_on_the_error():
    table = made_up_table()
    # On the column alone {p,F} without stabilisation is the best, and cheap.
    rows = (table["scene"] == COLUMN) & (table["method"] == "{p,F} none")
    table.loc[rows, ["twist_rms", "cpu_s_per_s"]] = [0.1, 0.5]
    found = recommendation(table).set_index("scene")
    assert found.loc[COLUMN, "stabilisation"] == "none"
    assert found.loc["all", "formulation"] == "{p,F,J}"


def test_energy_that_is_made_and_lost_and_folded_runs_are_no_choice():
    for column, value in (("energy_kept", 1.2), ("survived", False), ("folded", True)):
        table = made_up_table()
        table.loc[table["method"].str.startswith("{p,F,J} H1"), column] = value
        assert "{p,F,J}" not in set(
            recommendation(table).query("stabilisation == 'SUPG-H1'")["formulation"]
        )


def test_differences_below_the_uncertainty_of_the_reference_do_not_count():
    table = made_up_table()
    cheap = table["method"] == "{p,F} H1"
    table.loc[cheap, "cpu_s_per_s"] = 0.5
    on_column = table[table["scene"] == COLUMN]
    assert recommendation(on_column)["formulation"].iloc[0] == "{p,F,J}"
    unsure = on_column.assign(twist_rms_uncertainty=0.5)
    assert recommendation(unsure)["formulation"].iloc[0] == "{p,F}"


# --- methods and costs --------------------------------------------------------------------------


def test_labels_tell_methods_apart_and_defaults_are_the_package_s():
    assert len({method.label for method in COMPARED}) == len(COMPARED)
    assert len({method.label for method in OPTIONS}) == len(OPTIONS) == 19
    scene = twisting_column()
    sim = METHODS["{p,F,J} H1"].simulation(scene, 2)
    assert sim.stabilisation == default_stabilisation(sph.PFJ(), scene.material)
    assert sim.integrator == sph.PositionVerlet()
    paper = METHODS["{p,F,J} H1 TVD-RK2"].simulation(scene, 2)
    assert paper.stabilisation == sph.SUPG(tau_F=1.0, xi_F=0.0, tau_p=0.1)
    plain = METHODS["{p,F} none no projection"].simulation(scene, 2)
    assert plain.secondary is None
    assert plain.angular_momentum == sph.NoProjection()


def test_elements_that_span_two_spacings_get_an_even_lattice():
    two = Elements("two", fem.TaylorHoodHex(), edge=2)
    assert [two.lattice(cells) for cells in (3, 4, 5, 10)] == [4, 4, 6, 10]
    sim = two.simulation(timed(CUBE, 0.3), 4)
    assert sim.elements == 2**3
    assert goes_finest(two, 0.495)
    assert [m.label for m in COMPARED if goes_finest(m, 0.3)] == [
        "{p,F} H1", "{p,F,J} H1", B_BAR, "Taylor-Hood FEM"
    ]  # fmt: skip


def test_memory_is_counted_once_and_by_one_rule():
    shared = np.zeros(1000)

    class Owner:
        def __init__(self) -> None:
            self.whole, self.view, self.deep = shared, shared[::2], shared.reshape(10, 100)[1:, 3:]
            self.inside = {"list": [shared, np.zeros((5, 5), np.float32)]}
            self.me = self

    Owner.__module__ = "sphsolid.made_up"
    assert cost.held_bytes(Owner()) == 8000 + 100
    sim = METHODS["{p,F,J} H1"].simulation(timed(CUBE, 0.3), 8)
    # What the simulation says of itself, and the mesh.
    assert 1.0 <= cost.held_bytes(sim) / sim.memory_bytes() < 1.2
    elements = METHODS[B_BAR].simulation(timed(CUBE, 0.3), 8)
    assert cost.held_bytes(elements) > elements._elements.nbytes


def test_the_least_of_the_windows_counts(monkeypatch):
    """A clock that runs slowly in the third window of four."""
    ticks = iter([0.0, 2.0, *(t for k, s in enumerate((9.0, 6.0, 5.0, 8.0)) for t in (k, k + s))])
    monkeypatch.setattr(cost.time, "process_time", lambda: next(ticks))
    sim = METHODS[B_BAR].simulation(timed(CUBE, 0.3), 2)
    found = cost.step_cost(sim, window_s=5.0, repeats=4)
    assert (found.window, found.repeats) == (5, 4)
    assert found.seconds == pytest.approx(1.0)
    assert found.spread == pytest.approx(0.8)
    assert sim.step == 1 + 2 + 4 * 5


def test_counted_work_grows_with_terms_and_fields():
    scene = timed(CUBE, 0.495)
    work = {
        label: cost.counted_work(METHODS[label].simulation(scene, 4))
        for label in ("{p,F} none no projection", "{p,F} none", "{p,F} H1", "{p,F,J} H1",
                      "{p,F} H6", "displacement", B_BAR)
    }  # fmt: skip
    gathered = {label: one.gathered for label, one in work.items()}
    pairs = work["{p,F} none no projection"].pairs / 2
    assert gathered["{p,F} none no projection"] == pytest.approx(8 * 12 * pairs)
    assert gathered["{p,F} none"] == pytest.approx(8 * 15 * pairs)
    assert gathered["{p,F} none"] < gathered["{p,F} H1"] < gathered["{p,F,J} H1"]
    assert gathered["{p,F} H6"] > 3.0 * gathered["{p,F} H1"]
    # One gather of positions, one of forces and their way back, at eight nodes of 64 elements.
    assert gathered[B_BAR] == 8 * 9 * 8 * 64
    streamed = {label: one.streamed / (8 * 5**3) for label, one in work.items()}
    assert streamed["{p,F} H1"] == 3 * (3 + 3 + 9) + 9
    assert streamed["{p,F,J} H1"] == streamed["{p,F} H1"] + 3
    assert streamed[B_BAR] == 9


def test_the_timed_scene_is_the_stated_one_without_loads():
    for scene in (CUBE, COLUMN):
        full, bare = stated(scene, 0.495), timed(scene, 0.495)
        assert bare.material == full.material
        assert bare.constraints == full.constraints
        assert not bare.tractions
        sims = [METHODS[B_BAR].simulation(one, 2) for one in (full, bare)]
        assert np.array_equal(sims[0].snapshot().X, sims[1].snapshot().X)


def test_the_stress_of_the_cube_near_incompressibility_is_many_times_its_scale():
    assert stress_size(stated(CUBE, 0.3)) == pytest.approx(1.47, abs=0.02)
    assert stress_size(stated(CUBE, 0.495)) == pytest.approx(8.3, abs=0.2)


def test_names_are_spread_out_in_order():
    placed = spread_out([0.5, 0.5, 0.9, 0.1], 0.1, 0.0, 1.0)
    assert sorted(placed) == [placed[3], placed[0], placed[1], placed[2]]
    assert np.diff(sorted(placed)).min() >= 0.1 - 1e-12
    crowded = spread_out([0.5] * 21, 0.1, 0.0, 1.0)
    assert sorted(crowded) == pytest.approx(np.linspace(0.0, 1.0, 21))
    assert spread_out([0.3], 0.1, 0.0, 1.0) == [0.3]


# --- the whole ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """Two methods on small lattices of both scenes, through the tables and their files."""
    out = tmp_path_factory.mktemp("pareto")
    before, rows = threads(), []
    for scene, levels, until in ((CUBE, (2, 3), 0.1), (COLUMN, (2, 3), 4e-3)):
        for label in ("{p,F,J} H1", B_BAR):
            for cells in levels:
                rows += cases.run_case(
                    scene=scene, nu=0.3, method=label, cells=cells, until=until,
                    window_s=1e-3, repeats=3,
                )  # fmt: skip
    rows += cases.run_case(scene=COLUMN, nu=0.3, method=B_BAR, cells=4, until=4e-3, window_s=0.0,
                           repeats=0)  # fmt: skip
    assert threads() == before, "the threads are given back"
    made = tables(rows)
    for name, frame in made.items():
        write_csv(frame, out / f"{name}.csv")
    write_csv(pd.DataFrame(columns=["key", "failure", "message", "wall_s"]), out / "failures.csv")
    packages: dict[str, str] = {}
    run = {"tables": list(made), "commit": "", "sources_modified": False, "command": "made up",
           "date_utc": "2000-01-01", "wall_s": 1.0, "cases": 9, "cases_failed": 0,
           "cases_resumed": 0, "version": "0", "source_hash": "0", "python": "3",
           "packages": packages, "cpu": "one", "cores": 1, "system": "none", "jobs": 1,
           "threads_per_job": 1, "mode": "quick"}  # fmt: skip
    (out / "run.json").write_text(pd.Series(run).to_json(), encoding="utf-8")
    return read_results("pareto", out)


def test_a_run_is_a_row_with_errors_costs_and_counts(tiny):
    table = tiny.tables["table"]
    assert list(table.columns) == COLUMNS
    timed_runs = table[table["cpu_s_per_s"].notna()]
    assert len(timed_runs) == 8
    assert (timed_runs["cpu_s_per_s"] > 0.0).all()
    assert (timed_runs["step_cpu_spread"] >= 0.0).all()
    own = table[(table["method"] == "{p,F,J} H1") & (table["scene"] == CUBE)]
    assert (own["evaluations"] == own["steps"]).all()
    # Two cells an edge resolve nothing; three are better.
    assert own["momentum"].tolist() == sorted(own["momentum"], reverse=True)
    assert own["stress_size"].iloc[0] == pytest.approx(1.47, abs=0.02)
    reference_only = table[table["cpu_s_per_s"].isna()]
    assert reference_only["cells"].tolist() == [4]
    on_column = table[table["scene"] == COLUMN]
    kept = (on_column["energy_kept"] - 1.0).abs()
    assert on_column["energy"].tolist() == pytest.approx(kept.tolist(), abs=1e-9)
    assert on_column["twist_rms"].notna().all()


def test_the_iso_table_names_every_method_at_every_error(tiny):
    iso = tiny.tables["iso_error"]
    expected = 2 * 3 * (len(MEASURES[CUBE]) + len(MEASURES[COLUMN]))
    assert len(iso) == expected
    reached = iso[iso["how"] != NEVER]
    assert reached[list(COSTS)].notna().all().all()
    assert iso[iso["how"] == NEVER][list(COSTS)].isna().all().all()


def test_the_report_is_made_from_the_tables(tiny):
    with style():
        document = study.report(tiny)
    assert sentence(tiny.tables["ratios"]) in document.abstract
    write_pdf(document, tiny.out / "report.pdf")
    assert (tiny.out / "report.pdf").stat().st_size > 30_000
    for name in ("pareto", "cube_time", "cube_memory", "column_time", "column_memory"):
        assert (tiny.out / f"{name}.png").stat().st_size > 10_000, name


def test_tables_of_nothing_have_their_columns():
    made = tables([])
    assert list(made["table"].columns) == COLUMNS
    assert len(made["iso_error"]) == len(made["recommendation"]) == 0
    assert len(iso_table(made["table"])) == 0


def test_a_lost_solution_is_a_row(monkeypatch):
    def lost(sim: Any) -> dict[str, float]:
        raise sph.Diverged("negative Jacobian", 0.01, 7, 3, (0.0, 0.0, 0.0), "less")

    monkeypatch.setattr(cases, "cube_errors", lost)
    row = cases.run_case(scene=CUBE, nu=0.3, method=B_BAR, cells=2, until=0.1, window_s=1e-3,
                         repeats=3)[0]  # fmt: skip
    assert row["survived"] is False
    assert "step 7" in row["reason"]
    assert row["step_cpu_s"] > 0.0


@pytest.mark.parametrize("quick", [True, False])
def test_the_study_lists_each_case_once_one_at_a_time(quick):
    listed = study.cases(argparse.Namespace(quick=quick))
    keys = [case.key for case in listed]
    assert len(keys) == len(set(keys))
    runs = pd.DataFrame([dict(case.arguments) for case in listed])
    assert (runs["repeats"][runs["repeats"] > 0] >= 3).all()
    assert set(runs[runs["repeats"] == 0]["scene"]) == {COLUMN}
    finest = runs[(runs["scene"] == CUBE) & (runs["cells"] == runs["cells"].max())]
    if not quick:
        assert set(finest["method"]) == {"{p,F} H1", "{p,F,J} H1", B_BAR, "Taylor-Hood FEM"}
        assert set(runs["method"]) == set(METHODS)
