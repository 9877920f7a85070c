"""The stability study: its criteria, its accounts of energy, its verdicts and one tiny run."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import Diverged
from sphsolid.record import History
from sphsolid.scenes import twisting_column
from studies.harness.results import Results
from studies.report.document import Document
from studies.stability import study as stability
from studies.stability import verdicts as stability_verdicts
from studies.stability.hard_case_figures import overview
from studies.stability.hard_case_judgement import (
    ABSENT,
    LOST,
    SOUND,
    USELESS,
    cell_text,
    judge,
    judged,
)
from studies.stability.hard_case_methods import BASE, DEFAULTS, FEM, METHODS, REFERENCE, VARIANTS
from studies.stability.hard_case_runs import energy_balance, run
from studies.stability.hard_case_scenes import Seed, alternating, block, pulled_block, seeded_block
from studies.stability.hard_case_watch import COLLAPSED, Watched
from studies.stability.hard_cases import CASES, KEY_CASES, hard_case_table, hard_cases
from studies.stability.verdicts import NO, PARTLY, STABILISED, UNKNOWN, YES
from studies.stability.vibration_mode import LEVELS, lowest_mode
from studies.stability.wave_runs import Pulse, pulse, vibration
from studies.stability.waves import WAVE_CLAIMS, wave_tables, wave_verdicts

GOOD = {
    "case": "column", "method": BASE.name, "cfl": 0.7, "applicable": None,
    "survived": True, "reason": "", "lost_time": math.nan, "end_time": 0.1, "energy_kept": 0.98,
    "energy_gain": 0.0, "J_min": 0.99, "J_max": 1.02, "unseen_rms": 0.05, "unseen_max": 0.3,
    "inside_out": 0.0, "smallest_det": 0.9, "noise_end": 0.1, "dissipated_p": 0.01,
    "answer": 6.0, "answer_is": "largest twist [rad]", "clumping": math.nan,
}  # fmt: skip
SEEDED = GOOD | {"answer": 0.1, "answer_is": "seed left [-]", "energy_kept": 0.04}
TENSION = GOOD | {"answer": 1.0, "answer_is": "noise growth [-]", "clumping": 0.01}


@pytest.mark.parametrize(
    ("row", "reference", "verdict", "why"),
    [
        (GOOD, 6.1, SOUND, ""),
        (GOOD, math.nan, SOUND, ""),
        (GOOD | {"survived": False, "reason": "negative Jacobian", "lost_time": 0.04}, 6.0, LOST,
         "negative Jacobian at 0.04 s"),
        (GOOD | {"applicable": False, "reason": "none"}, 6.0, ABSENT, "none"),
        (GOOD | {"energy_gain": 0.11}, 6.0, USELESS, "made 0.11 of the energy"),
        (GOOD | {"energy_gain": math.nan}, 6.0, USELESS, "made nan of the energy"),
        (GOOD | {"energy_kept": 0.4}, 6.0, USELESS, "kept 40% of the energy"),
        (GOOD | {"unseen_rms": 0.8}, 6.0, USELESS,
         "folded (unseen motion 0.8, 0.0% inside out)"),
        (GOOD | {"unseen_max": 3.5}, 6.0, USELESS,
         "folded (unseen motion 0.05, 0.0% inside out)"),
        (SEEDED | {"inside_out": 0.01}, math.nan, USELESS,
         "folded (unseen motion 0.05, 1.0% inside out)"),
        (GOOD | {"J_min": 0.3}, 6.0, USELESS, "J 0.30 to 1.02"),
        (GOOD | {"J_max": 1.6}, 6.0, USELESS, "J 0.99 to 1.60"),
        (GOOD, 5.0, USELESS, "answer off by +20%"),
        (GOOD, 7.5, USELESS, "answer off by -20%"),
        (SEEDED, math.nan, SOUND, ""),
        (SEEDED | {"energy_gain": 0.4}, math.nan, SOUND, ""),
        (SEEDED | {"energy_gain": 3.0}, math.nan, USELESS, "made 3 of the energy"),
        (SEEDED | {"answer": 1.5}, math.nan, USELESS, "seed grew 1.5-fold"),
        (TENSION, math.nan, SOUND, ""),
        (TENSION | {"answer": 30.0}, math.nan, USELESS, "noise grew 30-fold, edges by 1%"),
        (TENSION | {"clumping": 0.2}, math.nan, USELESS, "noise grew 1-fold, edges by 20%"),
    ],
)  # fmt: skip
def test_every_criterion_decides(row, reference, verdict, why):
    assert judge(row, reference) == (verdict, why)


def test_the_reference_is_that_of_the_case_it_is_shared_with():
    table = pd.DataFrame(
        [GOOD, GOOD | {"case": "jittered", "answer": 9.0},
         GOOD | {"method": REFERENCE.name, "answer": 6.2}]
    )  # fmt: skip
    references = {"column": "column", "jittered": "column"}
    found = judged(table, references, REFERENCE.name, FEM.name)
    assert found["reference"].tolist() == [6.2, 6.2, 6.2]
    assert found["deviation"].to_numpy() == pytest.approx([6.0 / 6.2 - 1, 9.0 / 6.2 - 1, 0.0])
    assert found["verdict"].tolist() == [SOUND, USELESS, SOUND]


def test_without_a_fine_reference_the_coarse_one_judges():
    coarse = GOOD | {"method": FEM.name, "answer": 5.0}
    for fine, right in (([], 5.0), ([GOOD | {"method": REFERENCE.name, "answer": 6.1}], 6.1)):
        table = pd.DataFrame([GOOD, coarse, *fine])
        found = judged(table, {"column": "column"}, REFERENCE.name, FEM.name)
        assert found["reference"][0] == right
    assert judged(table, {}, REFERENCE.name, FEM.name)["reference"].isna().all()


def test_a_lost_reference_judges_nothing():
    lost = GOOD | {"method": REFERENCE.name, "survived": False, "lost_time": 0.01}
    found = judged(pd.DataFrame([GOOD, lost]), {"column": "column"}, REFERENCE.name, FEM.name)
    assert found["reference"].isna().all()
    assert found["verdict"].tolist() == [SOUND, LOST]


@pytest.mark.parametrize(
    ("row", "text"),
    [
        (GOOD | {"verdict": SOUND}, "98 %"),
        (GOOD | {"verdict": USELESS, "unseen_rms": 0.83}, "98 % fold 0.83"),
        (SEEDED | {"verdict": SOUND}, "x 0.2"),
        (SEEDED | {"verdict": USELESS, "energy_kept": 4.0e10}, "x 2e5"),
        (TENSION | {"verdict": USELESS, "answer": 101.7}, "x 102"),
        (GOOD | {"verdict": LOST, "lost_time": 0.034}, "lost 34 %"),
        (GOOD | {"verdict": ABSENT}, "–"),
    ],
)
def test_cells_say_the_telling_number(row, text):
    assert cell_text(row) == text


def ledger(**columns):
    names = ["total_energy", "work_traction", "work_body_force", "work_constraint",
             "work_projection", "work_adjoint_defect", "dissipation_p", "dissipation_J",
             "energy_rest"]  # fmt: skip
    size = len(next(iter(columns.values())))
    return History(
        pd.DataFrame({f"{name} [J]": columns.get(name, np.zeros(size)) for name in names})
    )


def test_shares_are_of_what_was_put_in():
    found = energy_balance(
        ledger(
            total_energy=np.array([10.0, 26.0, 27.0]), work_constraint=np.array([0.0, 10.0, 20.0]),
            dissipation_p=np.array([0.0, 0.0, -6.0]), dissipation_J=np.array([0.0, 0.0, 1.5]),
            energy_rest=np.array([0.0, 6.0, 1.5]),
        )
    )  # fmt: skip
    assert found["energy_kept"] == pytest.approx(27.0 / 30.0)
    assert found["energy_gain"] == pytest.approx(6.0 / 20.0)
    assert found["dissipated_p"] == pytest.approx(0.2)
    assert found["dissipated_J"] == pytest.approx(-0.05)
    assert found["energy_rest"] == pytest.approx(0.05)
    assert found["energy_projection"] == found["energy_defect"] == 0.0


def test_work_taken_out_again_does_not_make_the_scale_small():
    found = energy_balance(
        ledger(total_energy=np.array([0.0, 9.0, 1.5]), work_constraint=np.array([0.0, 10.0, 1.0]))
    )
    assert found["energy_kept"] == pytest.approx(0.15)
    assert found["energy_gain"] == pytest.approx(0.05)


def test_patterns_alternate_as_they_say():
    X = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.5, 0.5]])
    assert alternating(X, 0.5).tolist() == [1, -1, 1, -1]
    assert Seed("sawtooth", 2.0, 0.5)(X)[:, 0].tolist() == [2, -2, -2, -2]
    assert Seed("hourglass", 2.0, 0.5)(X)[:, 0].tolist() == [2, -2, 2, -2]
    noise = Seed("noise", 2.0, 0.5)
    assert np.array_equal(noise(X), noise(X))


@pytest.mark.parametrize(("pattern", "seen"), [("sawtooth", True), ("hourglass", False)])
def test_patterns_hide_where_they_are_said_to(pattern, seen):
    """No gradient at inner particles; at cell centroids only the saw tooth has one."""
    sim = sph.Simulation(block(), spacing=0.125)
    seed = Seed(pattern, 1.0, 0.125)(sim.cloud.X)
    F = np.empty_like(sim.state.F)
    sim._rhs.kinematic_gradient(seed, 1.0, F)
    inner = np.all((sim.cloud.X > 0.45) & (sim.cloud.X < 0.55), axis=1)
    assert np.abs(F[inner]).max() < 1e-10
    cell = seed[sim.cloud.mesh.cells][:, :, 0]
    across = cell[:, [1, 2, 5, 6]].mean(axis=1) - cell[:, [0, 3, 4, 7]].mean(axis=1)
    assert np.allclose(np.abs(across), 2.0 if seen else 0.0)


def test_the_pulled_block_is_pulled_at_both_ends():
    scene = pulled_block(noisy=True)
    ends = np.array([[0.0, 0.2, 0.2], [1.0, 0.2, 0.2]])
    held = [constraint.velocity(ends, 0.05)[:, 0] for constraint in scene.constraints]
    assert np.array_equal(held[0], [-5.0, 5.0])
    assert 1.0 + (held[0][1] - held[0][0]) * scene.end_time == pytest.approx(2.0)
    clean, noisy = (pulled_block(noisy=n).initial_velocity(ends) for n in (False, True))
    assert 0.0 < np.abs(noisy - clean).max() < 2.0


def test_a_collapsing_step_is_a_lost_solution(monkeypatch):
    sim = sph.Simulation(seeded_block(pattern="noise", spacing=0.5), spacing=0.5)
    watched = Watched(sim)
    first = watched.stable_time_step()
    watched.advance(first)
    watched.time = 2.0 * first
    assert (sim.time, sim.step, watched.step) == (2.0 * first, 1, 1)
    sim.state.F[:] = np.diag([1.0, 0.02, 50.0])
    assert watched.stable_time_step() == sim.stable_time_step()
    bar = fem.Simulation(block(), spacing=0.5)
    elements = Watched(bar)
    monkeypatch.setattr(bar, "stable_time_step", lambda: 0.5 * COLLAPSED * first)
    with pytest.raises(Diverged, match="step collapsed") as lost:
        elements.stable_time_step()
    assert (lost.value.step, lost.value.time) == (0, 0.0)


def test_the_list_of_cases_is_whole():
    full, quick = hard_cases(False), hard_cases(True)
    keys = [case.key for case in full]
    assert len(set(keys)) == len(keys)
    assert {case.name for case in CASES} >= set(KEY_CASES)
    for case in CASES:
        mine = [c for c in full if c.arguments["case"] == case.name]
        ours = [c for c in mine if c.arguments["method"]["name"] in {m.name for m in case.methods}]
        assert len(ours) == len(case.methods)
        assert (len(mine) > len(case.methods) + 1) == (case.name in KEY_CASES)
    assert {case.arguments["case"] for case in quick} < {case.name for case in CASES}
    named = [case.reference for case in CASES if case.reference]
    assert set(named) <= {case.name for case in CASES}
    assert sum(case.cost for case in quick) < 0.1 * sum(case.cost for case in full)


def tabled(*rows):
    frame = pd.DataFrame([*rows])
    return judged(frame, {}, REFERENCE.name, FEM.name)


def runs(case, verdicts, **more):
    """One row a stabilised method, sound, useless or lost in turn."""
    change = {
        SOUND: {}, USELESS: {"energy_gain": 5.0},
        LOST: {"survived": False, "lost_time": 0.01, "reason": "negative Jacobian"},
    }  # fmt: skip
    return [
        GOOD | {"case": case, "method": method} | more | change[verdict]
        for method, verdict in zip(STABILISED, verdicts, strict=False)
    ]


ALL, NONE = [SOUND] * len(STABILISED), [LOST] * len(STABILISED)
SOME = [USELESS, SOUND] + [LOST] * (len(STABILISED) - 2)


@pytest.mark.parametrize(
    ("decide", "case"),
    [
        (stability_verdicts.seeds_decay, "seeded noise"),
        (stability_verdicts.tension_is_stable, "pulled to stretch 2"),
        (stability_verdicts.all_survive, "punch, held"),
    ],
)
def test_three_verdicts_and_none(decide, case):
    assert decide(tabled(*runs("other", ALL)))[0] == UNKNOWN
    assert decide(tabled(*runs(case, ALL)))[0] == YES
    assert decide(tabled(*runs(case, SOME)))[0] == PARTLY
    assert decide(tabled(*runs(case, NONE)))[0] == NO


def test_surviving_uselessly_is_only_a_part():
    found = stability_verdicts.all_survive(tabled(*runs("punch, held", [SOUND, USELESS])))
    assert found[0] == PARTLY
    assert "2 of 2 ran to the end, 1 of them useless" in found[1]


def test_every_case_needs_a_method_and_one_method_for_all_more():
    one = runs("a", [SOUND, LOST])
    other = runs("b", [LOST, SOUND])
    every, same = (
        stability_verdicts.every_case_has_a_method, stability_verdicts.one_method_for_all,
    )  # fmt: skip
    assert every(tabled(*one, *other))[0] == YES
    assert same(tabled(*one, *other))[0] == PARTLY
    assert same(tabled(*one))[0] == YES
    assert every(tabled(*one, *runs("c", NONE)))[0] == PARTLY
    assert "none sound: c" in every(tabled(*one, *runs("c", NONE)))[1]
    assert every(tabled(*runs("c", NONE)))[0] == same(tabled(*runs("c", NONE)))[0] == NO


def test_what_was_not_run_is_not_reproduced():
    table = tabled(*runs("a", ALL))
    whole = stability_verdicts.verdicts(table, ["a"]).set_index("claim")
    short = stability_verdicts.verdicts(table, ["a", "b"]).set_index("claim")
    claim = "one setting is sound in every case"
    assert (whole["verdict"][claim], short["verdict"][claim]) == (YES, PARTLY)
    assert short["decided by"][claim].endswith("1 of 2 cases were not run")


def test_a_setting_put_to_few_cases_is_not_the_best():
    few = [GOOD | {"case": "a", "method": VARIANTS[0].name}]
    table = tabled(*runs("a", [SOUND]), *runs("b", [LOST]), *few)
    assert stability_verdicts.one_method_for_all(table)[0] == PARTLY


def test_cures_are_named():
    seeds = [
        *runs("seeded noise", NONE),
        GOOD | {"case": "seeded noise", "method": VARIANTS[0].name},
        GOOD | {"case": "seeded noise", "method": VARIANTS[1].name, "energy_gain": 9.0},
    ]
    text = stability_verdicts.seeds_decay(tabled(*seeds))[1]
    assert text.endswith(f"changes that cure it: {VARIANTS[0].name}")


@pytest.mark.parametrize(
    ("without", "plain", "verdict"),
    [(0.3, 0.4, YES), (0.1, 0.4, PARTLY), (0.1, 0.1, NO)],
)
def test_the_pressure_term_is_judged_by_the_noise(without, plain, verdict):
    noise = {BASE.name: 0.1, "tau_p 0": without, "{p,F,J} unstabilised": plain}
    table = tabled(
        *(GOOD | {"case": "punch, initial", "method": name, "noise_end": value}
          for name, value in noise.items())
    )  # fmt: skip
    assert stability_verdicts.pressure_term_smooths(table)[0] == verdict
    assert stability_verdicts.pressure_term_smooths(table[:2])[0] == UNKNOWN


def test_making_energy_is_judged_by_the_work_of_the_term():
    decide = stability_verdicts.default_makes_no_energy
    made = {"dissipated_p": -0.01, "energy_gain": 0.05}
    printed = GOOD | made | {"method": "{p,F,J} H1, printed"}
    assert decide(tabled(printed))[0] == UNKNOWN
    verdict, text = decide(tabled(GOOD, printed))
    assert verdict == YES
    assert "as printed it made energy in 1 of 1, largest gain 5.0e-02" in text
    assert decide(tabled(GOOD, GOOD | made))[0] == PARTLY
    assert decide(tabled(GOOD | made))[0] == NO


@pytest.mark.parametrize(
    ("kept", "verdict"), [((0.98, 0.985), YES), ((0.98, 0.9), NO), ((0.99, math.nan), UNKNOWN)]
)
def test_the_step_is_judged_by_the_energy_kept(kept, verdict):
    rows = [
        GOOD | {"method": name, "energy_kept": value}
        for name, value in zip(("CFL 0.5", "CFL 0.8"), kept, strict=True)
        if value == value
    ]
    assert stability_verdicts.step_does_not_matter(tabled(GOOD, *rows))[0] == verdict


def test_a_lost_run_is_not_independent_of_the_step():
    lost = {"survived": False, "lost_time": 0.01, "reason": "negative Jacobian"}
    rows = [GOOD | {"method": "CFL 0.5"}, GOOD | {"method": "CFL 0.8"}]
    other = [GOOD | {"method": "CFL 0.8", "case": "b"} | lost]
    assert stability_verdicts.step_does_not_matter(tabled(GOOD, *rows, *other))[0] == PARTLY


@pytest.mark.parametrize(("nu", "tau_F", "tau_p"), [(0.495, 0.5, 0.1), (0.3, 0.5, 0.0)])
def test_methods_are_what_their_names_say(nu, tau_F, tau_p):
    """The base is what the package chooses; its intrinsic time does not follow the step."""
    scene = block(poisson_ratio=nu)
    by_name = {method.name: method for method in (*METHODS, *VARIANTS)}
    own = sph.Simulation(scene, spacing=0.5, formulation=sph.PFJ())
    ours = BASE.build(scene, 0.5)
    assert (ours.stabilisation, ours.integrator) == (own.stabilisation, own.integrator)
    assert ours.stable_time_step() == own.stable_time_step()
    assert ours.stabilisation.tau_p == sph.OfStep(tau_p)
    for name in ("CFL 0.5", "{p,F,J} H1, SSP-RK3"):
        other = by_name[name].build(scene, 0.5)
        assert isinstance(other.stabilisation.tau_F, sph.OfMesh)
        assert other.stabilisation.tau_F == ours.stabilisation.tau_F
    printed = by_name["{p,F,J} H1, printed"].build(scene, 0.5).stabilisation
    assert printed == sph.SUPG(tau_F=tau_F, xi_F=0.0, tau_p=0.1)
    paper = by_name["{p,F,H,J} H1, paper's settings"].build(scene, 0.5)
    assert paper.stabilisation == sph.SUPG(tau_F=1.0, xi_F=0.2, tau_p=0.1)
    assert (paper.integrator, paper._time_step.cfl) == (sph.TVDRK2(), 0.3)
    longer = by_name["tau_F x 4"].build(scene, 0.5).stabilisation.tau_F
    assert longer == sph.OfMesh(4.0 * ours.stabilisation.tau_F.c)
    assert isinstance(by_name["displacement SPH"].build(scene, 0.5).stabilisation,
                      sph.NoStabilisation)  # fmt: skip


def test_disordered_particles_get_the_operator_of_the_package():
    column = twisting_column()
    for jitter, operator in ((0.0, sph.Consistent()), (0.4, sph.SummationByParts())):
        scene = replace(column, body=replace(column.body, jitter=jitter))
        assert BASE.build(scene, 1 / 3).operator == operator


@pytest.fixture(scope="module")
def rows():
    """A seed with two methods on three cells, one of them far beyond its stable step."""
    seed = {
        "case": "seeded sawtooth", "kind": "seeded", "cells": 3,
        "arguments": {"pattern": "sawtooth"},
    }  # fmt: skip
    wild = replace(BASE, cfl=3.0)
    checkerboard = {"case": "seeded checkerboard", "kind": "checkerboard", "cells": 2,
                    "arguments": {}}  # fmt: skip
    return [
        *run(method=FEM.arguments(), **seed),
        *run(method=wild.arguments(), **seed),
        *run(method=FEM.arguments(), **checkerboard),
        *run(method=replace(BASE, cfl=0.1).arguments(), **checkerboard),
    ]


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_run_is_a_row(rows):
    kept, lost, absent, seeded = rows
    assert kept["survived"]
    assert [row["operator"] for row in (kept, lost, seeded)] == ["-", "Consistent", "Consistent"]
    assert 0.0 < kept["energy_kept"] < 1.5
    assert kept["noise_end"] > 0.0
    assert not lost["survived"]
    assert 0.0 < lost["lost_time"] < lost["end_time"]
    assert lost["lost_step"] >= 1
    assert lost["reason"]
    assert absent["applicable"] is False
    assert seeded["answer"] < 1.0
    assert seeded["energy_gain"] < 1e-3
    assert seeded["dissipated_J"] > 0.1


def test_the_report_is_made_from_the_rows(rows, tmp_path: Path):
    tables = stability.tables(rows)
    assert tables["table"]["verdict"].tolist() == [SOUND, LOST, ABSENT, SOUND]
    assert len(tables["verdicts"]) == len(stability_verdicts.CLAIMS) + len(WAVE_CLAIMS)
    path = tmp_path / "table.csv"
    tables["table"].to_csv(path, index=False)
    again = dict(tables) | {"table": pd.read_csv(path)}
    run_json = SimpleNamespace(
        commit="", sources_modified=False, command="", date_utc="", wall_s=1.0, cases=4,
        cases_failed=0, cases_resumed=0, version="0", source_hash="", python="", packages={},
        cpu="", cores=1, system="", jobs=1, threads_per_job=1, mode="quick",
    )  # fmt: skip
    failures = pd.DataFrame(columns=["key", "failure", "message", "wall_s"])
    document = stability.report(Results(tmp_path, again, failures, vars(run_json)))
    assert isinstance(document, Document)
    assert (tmp_path / "hard_cases.png").stat().st_size > 5_000
    assert "sound" in stability.summary(tables)


def test_heat_maps_take_any_table(rows, tmp_path: Path):
    table = hard_case_table(rows)
    names = [method.name for method in METHODS]
    assert overview(table, tmp_path, name="all", methods=names, title="").with_suffix(
        ".png"
    ).exists()


def test_parts_choose_what_runs():
    def keys(part):
        options = argparse.Namespace(quick=True, part=part)
        return {case.key for case in stability.cases(options)}

    assert keys("both") == keys("hard") | keys("spectrum")
    assert not keys("hard") & keys("spectrum")


def long_rows(folded):
    """The long columns of the defaults, some folded, beside sound ones of B-bar."""
    rows = [GOOD | {"case": f"long column 1/{k}, nu 0.3"} for k in range(4)]
    ours = [
        row | {"method": DEFAULTS.name, "unseen_rms": 0.9 if k < folded else 0.05}
        for k, row in enumerate(rows)
    ]
    return tabled(*ours, *(row | {"method": FEM.name} for row in rows))


@pytest.mark.parametrize(("folded", "verdict"), [(0, YES), (1, PARTLY), (4, NO)])
def test_a_folded_run_holds_no_claim(folded, verdict):
    table = long_rows(folded)
    assert stability_verdicts.long_columns_are_sound(table)[0] == verdict
    found, text = stability_verdicts.positions_hold(table)
    assert found == verdict
    assert f"{folded} of 4 runs with the package's settings folded, 0 of 4" in text
    assert stability_verdicts.positions_hold(table[table["method"] == FEM.name])[0] == UNKNOWN


def test_a_column_that_folds_is_useless_and_its_row_says_it():
    """nu 0.3 on 1/3 with nothing that damps: 0.15 s end folded, B-bar's do not."""
    by_name = {method.name: method for method in METHODS}
    case = {
        "case": "a", "kind": "column", "cells": 3,
        "arguments": {"poisson_ratio": 0.3, "end_time": 0.15},
    }  # fmt: skip
    rows = [*run(method=by_name["{p,F,J} unstabilised"].arguments(), **case),
            *run(method=FEM.arguments(), **case)]  # fmt: skip
    table = hard_case_table(rows)
    assert table["verdict"].tolist() == [USELESS, SOUND]
    assert table["why"][0].startswith("folded") or "; folded" in table["why"][0]
    assert table["unseen_rms"][0] > 0.3 > 0.1 > table["unseen_rms"][1] > 0.0


def test_the_pulse_satisfies_the_wave_equation_and_runs_one_way():
    wave = Pulse(speed=3.0, width=0.3, start=1.0)
    X = np.linspace(0.0, 4.0, 4001)[:, None] * [1.0, 0.0, 0.0]
    slope = np.gradient(wave.displacement(X)[:, 0], X[:, 0])
    assert np.allclose(slope, -wave.velocity(X, 0.0)[:, 0] / 3.0, atol=1e-9)
    half = wave.velocity(np.array([[1.15, 0, 0], [1.0, 0, 0]]), 0.0)[:, 0]
    assert half[0] == pytest.approx(0.5 * half[1])


@pytest.fixture(scope="module")
def waves():
    methods = (DEFAULTS, FEM)
    return [
        *(row for m in methods for row in vibration(
            method=m.arguments(), poisson_ratio=0.3, cells=4)),
        *(row for m in methods for row in pulse(
            method=m.arguments(), poisson_ratio=0.0, cells=10)),
    ]  # fmt: skip


@pytest.mark.slow
def test_waves_are_rows_with_verdicts(waves):
    tables = wave_tables(waves)
    ours, theirs = (row for _, row in tables["vibration"].iterrows())
    assert theirs["energy_left"] == pytest.approx(1.0, abs=1e-3)
    assert abs(theirs["damping_ratio"]) < 1e-5
    assert abs(theirs["frequency_error"]) < 0.02
    assert ours["energy_left"] < theirs["energy_left"]
    ours, theirs = (row for _, row in tables["pulse"].iterrows())
    assert theirs["energy_left"] == pytest.approx(1.0, abs=0.01)
    assert theirs["error"] < ours["error"]
    said = wave_verdicts(tables)
    assert said["verdict"].isin([YES, PARTLY, NO]).all()
    assert "nu 0.3 on 1/4" in said["decided by"][0]


def test_waves_that_were_not_run_are_said_to_be():
    assert wave_verdicts(wave_tables([]))["verdict"].tolist() == [UNKNOWN, UNKNOWN]


@pytest.mark.slow
def test_the_mode_is_the_limit_of_a_sequence():
    """Below every mesh of the sequence, as a minimum of the energy must be, and near the last."""
    mode = lowest_mode(0.3)
    assert len(LEVELS) == 3
    assert mode.limit < mode.omega
    assert mode.omega == pytest.approx(mode.limit, rel=1e-3)
    X = np.array([[0.25, 1.0, 0.25], [0.0, 0.5, 0.0], [0.5, 0.5, 0.0], [0.1, 0.0, 0.3]])
    shape = mode(X)
    assert shape[0, 0] == pytest.approx(1.0, abs=0.01)
    # Bent about Z: one side is stretched where the other is pressed.
    assert shape[1, 1] == pytest.approx(-shape[2, 1])
    assert abs(shape[1, 1]) > 0.1
    assert np.allclose(shape[3], 0.0)
