"""The stability study: its criteria, its shares of energy, its claims and a few tiny runs."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import Diverged, InputError
from sphsolid.scenes import twisting_column
from studies import stability
from studies.methods import B_BAR, PACKAGE, SUPG, UNSTABILISED
from studies.stability import waves
from studies.stability.hard_cases import (
    AT_200,
    AT_300,
    CASES,
    FINE,
    KEY_CASES,
    OTHER_STEPS,
    PAPER_COLUMN,
    PRINTED,
    REFERENCE,
    RK3,
    STABILISED,
    VARIANTS,
    WITHOUT_J,
    WITHOUT_TAU_P,
    hard_cases,
    hard_table,
    run_case,
)
from studies.stability.hard_problems import (
    COLLAPSED,
    Checkerboard,
    Column,
    Pulled,
    Seed,
    alternating,
    block,
    energy_shares,
    give_up_on_collapse,
)
from studies.stability.judgement import (
    ABSENT,
    DIVERGED,
    SOUND,
    USELESS,
    cell_text,
    judge,
    judged,
    overview,
)
from studies.stability.waves import Pulse, lowest_mode, pulse, vibration, wave_claims, wave_tables

GOOD = {
    "case": "column", "method": SUPG.name, "applicable": True, "survived": True, "why": "",
    "where": "", "diverged_at": math.nan, "end_time": 0.1, "energy_kept": 0.98,
    "energy_gain": 0.0, "J_min": 0.99, "J_max": 1.02, "folded": False, "unseen_rms": 0.05,
    "inside_out": 0.0, "noise_end": 0.1, "dissipated_p": 0.01, "answer": 6.0,
    "answer_is": "largest twist [rad]", "clumping": math.nan,
}  # fmt: skip
SEEDED = GOOD | {"answer": 0.1, "answer_is": "seed left [-]", "energy_kept": 0.04}
TENSION = GOOD | {"answer": 1.0, "answer_is": "noise growth [-]", "clumping": 0.01}
LOST = {"survived": False, "diverged_at": 0.01, "why": "negative Jacobian"}
FOLDED = {"folded": True, "unseen_rms": 0.8}


@pytest.mark.parametrize(
    ("row", "reference", "verdict", "why"),
    [
        (GOOD, 6.1, SOUND, ""),
        (GOOD, math.nan, SOUND, ""),
        (GOOD | LOST, 6.0, DIVERGED, "negative Jacobian at 0.01 s"),
        (GOOD | {"applicable": False, "why": "none"}, 6.0, ABSENT, "none"),
        (GOOD | {"energy_gain": 0.11}, 6.0, USELESS, "made 0.11 of the energy"),
        (GOOD | {"energy_gain": math.nan}, 6.0, USELESS, "made nan of the energy"),
        (GOOD | {"energy_kept": 0.4}, 6.0, USELESS, "kept 40% of the energy"),
        (GOOD | FOLDED, 6.0, USELESS, "folded (unseen motion 0.8, 0.0% inside out)"),
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
         GOOD | {"method": REFERENCE.name, "answer": 6.2},
         GOOD | {"method": B_BAR.name, "answer": 5.0}]
    )  # fmt: skip
    references = {"column": "column", "jittered": "column"}
    found = judged(table, references)
    assert found["reference"].tolist() == [6.2] * 4
    assert found["deviation"].to_numpy()[:2] == pytest.approx([6.0 / 6.2 - 1, 9.0 / 6.2 - 1])
    assert found["verdict"].tolist() == [SOUND, USELESS, SOUND, USELESS]
    coarse = judged(table[table["method"] != REFERENCE.name], references)
    assert coarse["reference"].tolist() == [5.0] * 3, "without a fine reference the coarse judges"
    assert judged(table, {})["reference"].isna().all()


def test_a_reference_that_diverged_judges_nothing():
    table = pd.DataFrame([GOOD, GOOD | LOST | {"method": REFERENCE.name}])
    found = judged(table, {"column": "column"})
    assert found["reference"].isna().all()
    assert found["verdict"].tolist() == [SOUND, DIVERGED]


@pytest.mark.parametrize(
    ("row", "text"),
    [
        (GOOD | {"verdict": SOUND}, "98 %"),
        (GOOD | FOLDED | {"verdict": USELESS}, "98 % fold 0.8"),
        (SEEDED | {"verdict": SOUND}, "x 0.2"),
        (SEEDED | {"verdict": USELESS, "energy_kept": 4.0e10}, "x 2e5"),
        (TENSION | {"verdict": USELESS, "answer": 101.7}, "x 102"),
        (GOOD | {"verdict": DIVERGED, "diverged_at": 0.034}, "div. 34 %"),
        (GOOD | {"verdict": ABSENT}, "–"),
    ],
)
def test_cells_say_the_telling_number(row, text):
    assert cell_text(row) == text


def shares(**columns):
    names = ["total_energy", "work_traction", "work_body_force", "work_constraint",
             "work_projection", "work_adjoint_defect", "dissipation_p", "dissipation_J",
             "energy_rest"]  # fmt: skip
    nothing = np.zeros(len(columns["total_energy"]))
    return energy_shares({f"{name} [J]": np.array(columns.get(name, nothing)) for name in names})


def test_shares_are_of_what_was_put_in():
    found = shares(
        total_energy=[10.0, 26.0, 27.0], work_constraint=[0.0, 10.0, 20.0],
        dissipation_p=[0.0, 0.0, -6.0], dissipation_J=[0.0, 0.0, 1.5], energy_rest=[0.0, 6.0, 1.5],
    )  # fmt: skip
    assert found["energy_kept"] == pytest.approx(27.0 / 30.0)
    assert found["energy_gain"] == pytest.approx(6.0 / 20.0)
    assert found["dissipated_p"] == pytest.approx(0.2)
    assert found["dissipated_J"] == pytest.approx(-0.05)
    assert found["energy_rest"] == pytest.approx(0.05)
    assert found["energy_projection"] == found["energy_defect"] == 0.0
    # Work that is taken out again does not make the scale small.
    found = shares(total_energy=[0.0, 9.0, 1.5], work_constraint=[0.0, 10.0, 1.0])
    assert found["energy_kept"] == pytest.approx(0.15)
    assert found["energy_gain"] == pytest.approx(0.05)


def test_patterns_alternate_as_they_say():
    X = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.5, 0.5]])
    assert alternating(X, 0.5).tolist() == [1, -1, 1, -1]
    assert Seed("sawtooth").velocity(X, 0.5)[:, 0].tolist() == [1, -1, -1, -1]
    assert Seed("hourglass").velocity(X, 0.5)[:, 0].tolist() == [1, -1, 1, -1]
    noise = Seed("noise")
    assert np.array_equal(noise.velocity(X, 0.5), noise.velocity(X, 0.5))


@pytest.mark.parametrize(("pattern", "seen"), [("sawtooth", True), ("hourglass", False)])
def test_patterns_hide_where_they_are_said_to(pattern, seen):
    """No gradient at inner particles; at cell centroids only the saw tooth has one."""
    sim = sph.Simulation(block(), spacing=0.125, formulation=sph.PF())
    seed = Seed(pattern).velocity(sim.cloud.X, 0.125)
    F = np.empty_like(sim.state.F)
    sim._rhs.kinematic_gradient(seed, 1.0, F)
    inner = np.all((sim.cloud.X > 0.45) & (sim.cloud.X < 0.55), axis=1)
    assert np.abs(F[inner]).max() < 1e-10
    cell = seed[sim.cloud.mesh.cells][:, :, 0]
    across = cell[:, [1, 2, 5, 6]].mean(axis=1) - cell[:, [0, 3, 4, 7]].mean(axis=1)
    assert np.allclose(np.abs(across), 2.0 if seen else 0.0)


def test_the_pulled_block_is_pulled_at_both_ends():
    scene = Pulled().scene(noisy=True)
    ends = np.array([[0.0, 0.2, 0.2], [1.0, 0.2, 0.2]])
    held = [constraint.velocity(ends, 0.05)[:, 0] for constraint in scene.constraints]
    assert np.array_equal(held[0], [-5.0, 5.0])
    assert 1.0 + (held[0][1] - held[0][0]) * scene.end_time == pytest.approx(2.0)
    clean, noisy = (Pulled().scene(noisy=n).initial_velocity(ends) for n in (False, True))
    assert 0.0 < np.abs(noisy - clean).max() < 2.0


def test_a_collapsing_step_diverges():
    sim = sph.Simulation(block(), spacing=0.5, formulation=sph.PF())
    give_up_on_collapse(sim)
    first = sim.stable_time_step()
    sim.advance(first)
    sim.state.F[:] = np.diag([1.0, 0.02, 50.0])
    assert sim.stable_time_step() < 0.1 * first, "small, and not small enough"
    elements = fem.Simulation(block(), spacing=0.5)
    usual = elements.stable_time_step()
    answers = iter([usual, 0.5 * COLLAPSED * usual])
    elements.stable_time_step = lambda: next(answers)
    give_up_on_collapse(elements)
    with pytest.raises(Diverged, match="step collapsed") as lost:
        elements.stable_time_step()
    assert (lost.value.step, lost.value.time) == (0, 0.0)


def test_the_list_of_cases_is_whole():
    full, quick = list(hard_cases(quick=False)), list(hard_cases(quick=True))
    keys = [case.key for case in full]
    assert len(set(keys)) == len(keys)
    assert {case.name for case in CASES} >= set(KEY_CASES)
    for case in CASES:
        mine = [c.arguments["method"] for c in full if c.arguments["case"] == case.name]
        assert set(case.methods) <= set(mine)
        assert (set(VARIANTS) <= set(mine)) == (case.name in KEY_CASES)
    assert {case.reference for case in CASES if case.reference} <= {case.name for case in CASES}
    assert sum(case.cost for case in quick) < 0.1 * sum(case.cost for case in full)


@pytest.mark.parametrize(("nu", "tau_F", "tau_p"), [(0.495, 0.5, 0.1), (0.45, 0.5, 0.0)])
def test_methods_are_what_their_names_say(nu, tau_F, tau_p):
    scene = block(poisson_ratio=nu)
    ours = SUPG.simulation(scene, spacing=0.5)
    assert ours.formulation == sph.PFJ(), "as every short case has it"
    assert ours.stabilisation.tau_p == sph.OfStep(tau_p)
    for method in (RK3, VARIANTS[0]):
        other = method.simulation(scene, spacing=0.5)
        assert other.stabilisation.tau_F == ours.stabilisation.tau_F, "not a time of the step"
    assert WITHOUT_J.simulation(scene, spacing=0.5).formulation == sph.PF()
    printed = PRINTED.simulation(scene, spacing=0.5)
    assert printed.stabilisation == sph.SUPG(tau_F=tau_F, xi_F=0.0, tau_p=0.1)
    assert (printed.integrator, printed._time_step.cfl) == (sph.SSPRK3(), 0.5)
    paper = PAPER_COLUMN.simulation(scene, spacing=0.5)
    assert paper.formulation == sph.PFHJ()
    assert paper.stabilisation == sph.SUPG(tau_F=1.0, xi_F=0.2, tau_p=0.1)
    assert (paper.integrator, paper._time_step.cfl) == (sph.TVDRK2(), 0.3)
    longer = VARIANTS[4].simulation(scene, spacing=0.5).stabilisation.tau_F
    assert longer == sph.OfMesh(4.0 * ours.stabilisation.tau_F.c)


def test_disordered_particles_get_the_operator_of_the_package():
    column = twisting_column()
    for jitter, operator in ((0.0, sph.Consistent()), (0.4, sph.SummationByParts())):
        scene = replace(column, body=replace(column.body, jitter=jitter))
        assert SUPG.simulation(scene, spacing=1 / 3).operator == operator


# --- claims on planted tables -------------------------------------------------------------------


def tabled(*rows):
    return judged(pd.DataFrame([*rows]), {})


def runs(case, verdicts):
    """One row a stabilised method, sound, useless or diverged in turn."""
    change = {SOUND: {}, USELESS: {"energy_gain": 5.0}, DIVERGED: LOST}
    return [
        GOOD | {"case": case, "method": method} | change[verdict]
        for method, verdict in zip(STABILISED, verdicts, strict=False)
    ]


def of(method, **change):
    name = method if isinstance(method, str) else method.name
    return GOOD | {"method": name} | change


ALL, NONE = [SOUND] * len(STABILISED), [DIVERGED] * len(STABILISED)
SOME = [USELESS, SOUND] + [DIVERGED] * (len(STABILISED) - 2)


@pytest.mark.parametrize(
    ("claim", "case"),
    [
        (stability.seeds_decay, "seeded noise"),
        (stability.tension_is_stable, "pulled to stretch 2"),
        (stability.all_survive, "punch, held"),
    ],
)
def test_three_verdicts_and_none(claim, case):
    assert claim(tabled(*runs("other", ALL)), "").verdict == "not examined"
    assert claim(tabled(*runs(case, ALL)), "").verdict == "reproduced"
    assert claim(tabled(*runs(case, SOME)), "").verdict == "reproduced in part"
    assert claim(tabled(*runs(case, NONE)), "").verdict == "not reproduced"
    assert claim(tabled(*runs(case, ALL)), "1 was not run").verdict == "reproduced in part"


def test_surviving_uselessly_is_only_a_part():
    found = stability.all_survive(tabled(*runs("punch, held", [SOUND, USELESS])), "")
    assert found.verdict == "reproduced in part"
    assert found.shown == "2 of 2 run to their end; 1 of them useless"


def test_every_case_needs_a_method_and_one_method_for_all_more():
    every, same = stability.every_case_has_a_method, stability.one_method_for_all
    both = tabled(*runs("a", [SOUND, DIVERGED]), *runs("b", [DIVERGED, SOUND]))
    assert (every(both, "").verdict, same(both, "").verdict) == ("met", "met in part")
    assert same(tabled(*runs("a", [SOUND, DIVERGED])), "").verdict == "met"
    without = tabled(*runs("a", ALL), *runs("c", NONE))
    assert every(without, "").verdict == "met in part"
    assert every(without, "").shown.endswith("not: c")
    none = tabled(*runs("c", NONE))
    assert every(none, "").verdict == same(none, "").verdict == "not met"
    # A setting put to few cases is not the best.
    few = tabled(*runs("a", [SOUND]), *runs("b", [DIVERGED]), of(VARIANTS[0], case="a"))
    assert same(few, "").verdict == "met in part"


def test_cures_are_named():
    seeds = [
        *runs("seeded noise", NONE),
        of(VARIANTS[0], case="seeded noise"),
        of(VARIANTS[1], case="seeded noise", energy_gain=9.0),
    ]
    said = stability.seeds_decay(tabled(*seeds), "").shown
    assert f"all do with {VARIANTS[0].name}; not" in said


@pytest.mark.parametrize(
    ("before", "after", "verdict"), [(0.3, 0.1, True), (0.3, 0.2, False), (0.1, 0.01, False)]
)
def test_what_smooths_the_pressure_is_judged_where_it_fluctuates(before, after, verdict):
    """``tau_p`` and the stabilisation as a whole are two claims, with the punch's criterion."""
    for claim, without, words in (
        (stability.pressure_term_smooths, WITHOUT_TAU_P, ("not reproduced", "reproduced")),
        (stability.stabilisation_smooths, UNSTABILISED.name, ("not met", "met")),
    ):
        noise = {SUPG.name: after, without: before}
        rows = [of(name, case="punch, initial", noise_end=value) for name, value in noise.items()]
        assert claim(tabled(*rows), "").verdict == words[verdict]
        assert claim(tabled(*rows[:1]), "").verdict == "not examined"


def test_making_energy_is_judged_by_the_work_of_the_term():
    claim, made = stability.damping_makes_no_energy, {"dissipated_p": -0.01, "energy_gain": 0.05}
    assert claim(tabled(of(PRINTED, **made)), "").verdict == "not examined"
    found = claim(tabled(GOOD, of(PRINTED, **made)), "")
    assert found.verdict == "met"
    assert "as printed 0 of 1" in found.shown
    assert claim(tabled(GOOD, GOOD | made), "").verdict == "met in part"
    assert claim(tabled(GOOD | made), "").verdict == "not met"


@pytest.mark.parametrize(
    ("kept", "verdict"),
    [((0.98, 0.985), "met"), ((0.98, 0.9), "not met"), ((0.99,), "not examined")],
)
def test_the_step_is_judged_by_the_energy_kept(kept, verdict):
    rows = [of(name, energy_kept=k) for name, k in zip(OTHER_STEPS, kept, strict=False)]
    assert stability.step_does_not_matter(tabled(GOOD, *rows), "").verdict == verdict


def test_a_run_that_diverged_is_not_independent_of_the_step():
    rows = [*map(of, OTHER_STEPS), of(OTHER_STEPS[1], case="b", **LOST)]
    assert stability.step_does_not_matter(tabled(GOOD, *rows), "").verdict == "met in part"


@pytest.mark.parametrize(("folded", "verdict"), [(0, "met"), (1, "met in part"), (4, "not met")])
def test_a_folded_run_holds_no_claim(folded, verdict):
    rows = [GOOD | {"case": f"long column 1/{k}, nu 0.3"} for k in range(4)]
    ours = [row | (FOLDED if k < folded else {}) for k, row in enumerate(rows)]
    table = tabled(*ours, *(row | {"method": B_BAR.name} for row in rows))
    assert stability.long_columns_are_sound(table, "").verdict == verdict
    found = stability.positions_hold(table, "")
    assert found.verdict == verdict
    assert f"{4 - folded} of 4 do not fold; B-bar FEM: 4 of 4" in found.shown
    theirs = table[table["method"] == B_BAR.name]
    assert stability.positions_hold(theirs, "").verdict == "not examined"


def default(case, **change):
    more = {"cells": 4, "energy_at_tenth": 0.98, "top_height": 6.0}
    return of(PACKAGE, case=case) | more | change


@pytest.mark.parametrize(
    ("change", "shape", "sound"),
    [({}, "met", "met"), (FOLDED, "met in part", "met in part"),
     ({"inside_out": 0.01}, "met in part", "met"), ({"J_max": 1.6}, "met", "met in part"),
     (LOST, "met in part", "met in part")],
)  # fmt: skip
def test_the_default_must_hold_its_shape_and_be_sound(change, shape, sound):
    table = tabled(default("a"), default("b", **change), GOOD | FOLDED,
                   default("c", applicable=False, why="none", survived=None))  # fmt: skip
    assert stability.default_holds_its_shape(table, "").verdict == shape
    assert stability.default_is_sound(table, "").verdict == sound
    assert stability.default_is_sound(tabled(GOOD), "").verdict == "not examined"


def test_the_energy_of_the_long_columns_is_asked_by_lattice():
    def verdict(*left):
        rows = [
            default(f"long column 1/{cells}, nu 0.3", cells=cells, energy_at_tenth=kept)
            for cells, kept in zip((4, 5, 6), left, strict=True)
        ]
        return stability.default_keeps_its_energy(tabled(*rows), "").verdict

    assert verdict(0.971, 0.5, 0.991) == "met"
    assert verdict(0.971, 1.0, 0.98) == "met in part"
    assert verdict(0.96, 1.0, 0.98) == "not met"
    folded = tabled(default("long column 1/4, nu 0.3", **FOLDED))
    assert stability.default_keeps_its_energy(folded, "").verdict == "not met"


@pytest.mark.parametrize(
    ("change", "verdict"),
    [({}, "met"), ({"energy_kept": 0.96}, "met in part"), ({"answer": 6.07}, "met in part"),
     ({"noise_end": 0.23}, "met in part"), (FOLDED, "not met"), (LOST, "not met")],
)  # fmt: skip
def test_the_fast_column_is_held_against_fine_elements(change, verdict):
    own, fine = default(AT_200, **change), of(FINE, case=AT_200)
    rows = [own, fine, of(B_BAR, case=AT_200, noise_end=0.3)]
    found = stability.default_at_200(tabled(*rows), "")
    assert found.verdict == verdict
    assert stability.default_at_200(tabled(*rows[:1]), "").verdict == "not examined"


def test_the_fastest_column_is_as_high_as_fine_elements():
    def verdict(height, **change):
        rows = [default(AT_300, top_height=height, **change), of(FINE, case=AT_300, top_height=5.0)]
        return stability.default_at_300(tabled(*rows), "").verdict

    assert (verdict(5.09), verdict(4.89), verdict(5.0, **FOLDED)) == ("met", "not met", "not met")
    assert verdict(5.0, **LOST) == "not met"
    alone = tabled(default(AT_300))
    assert stability.default_at_300(alone, "").verdict == "not examined"


def test_a_seed_that_a_method_cannot_have_does_not_count_against_it():
    rows = [default("a"), default("b", applicable=False, why="none", survived=None)]
    others = [*runs("a", NONE), *runs("b", NONE)]
    assert stability.one_method_for_all(tabled(*rows, *others), "").verdict == "met"


# --- tiny runs ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rows():
    """A seed with two methods, one of them far beyond its stable step; a checkerboard with two."""
    seed = {"case": "seeded sawtooth", "problem": Seed("sawtooth"), "cells": 3}
    checkerboard = {"case": "seeded checkerboard", "problem": Checkerboard(), "cells": 2}
    return [
        *run_case(method=B_BAR, **seed),
        *run_case(method=SUPG.but(name=SUPG.name, cfl=3.0), **seed),
        *run_case(method=B_BAR, **checkerboard),
        *run_case(method=SUPG.but(name=SUPG.name, cfl=0.1), **checkerboard),
    ]


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_run_is_a_row(rows):
    kept, lost, absent, seeded = rows
    assert kept["survived"]
    assert 0.0 < kept["energy_kept"] < 1.5
    assert kept["noise_end"] > 0.0
    assert not lost["survived"]
    assert 0.0 < lost["diverged_at"] < lost["end_time"]
    assert lost["where"]
    assert lost["why"]
    assert absent["applicable"] is False
    assert seeded["answer"] < 1.0
    assert seeded["energy_gain"] < 1e-3
    assert seeded["dissipated_J"] > 0.1


def test_the_report_is_made_from_the_rows(rows, tmp_path):
    tables = stability.tables(rows)
    assert tables["table"]["verdict"].tolist() == [SOUND, DIVERGED, ABSENT, SOUND]
    found = stability.claims(tables)
    assert len(found) == len(stability.HARD_CLAIMS) + len(wave_claims(tables))
    assert {claim.verdict for claim in found} >= {"not examined"}
    assert overview(tables["table"], {SUPG.name: "a", B_BAR.name: "b"}).axes
    with pytest.raises(InputError, match="no run of none"):
        overview(tables["table"], {"none": "-"})


def test_parts_choose_what_runs():
    def keys(part):
        options = argparse.Namespace(quick=True, part=part)
        return {case.key for case in stability.cases(options)}

    assert keys("both") == keys("hard") | keys("spectrum")
    assert not keys("hard") & keys("spectrum")


def test_a_column_that_folds_is_useless_and_its_row_says_it():
    """nu 0.3 on 1/3 with nothing that damps: 0.15 s end folded, B-bar's do not."""
    case = {"case": "a", "problem": Column(poisson_ratio=0.3, end_time=0.15), "cells": 3}
    rows = [*run_case(method=UNSTABILISED, **case), *run_case(method=B_BAR, **case)]
    table = judged(hard_table(rows), {})
    assert table["verdict"].tolist() == [USELESS, SOUND]
    assert "folded" in table["why"][0]
    assert table["unseen_rms"][0] > 0.3 > 0.1 > table["unseen_rms"][1] > 0.0


def test_the_pulse_satisfies_the_wave_equation_and_runs_one_way():
    wave = Pulse(speed=3.0, width=0.3, start=1.0)
    X = np.linspace(0.0, 4.0, 4001)[:, None] * [1.0, 0.0, 0.0]
    slope = np.gradient(wave.displacement(X)[:, 0], X[:, 0])
    assert np.allclose(slope, -wave.velocity(X, 0.0)[:, 0] / 3.0, atol=1e-9)
    half = wave.velocity(np.array([[1.15, 0, 0], [1.0, 0, 0]]), 0.0)[:, 0]
    assert half[0] == pytest.approx(0.5 * half[1])


@pytest.mark.slow
def test_waves_are_rows_with_verdicts():
    methods = (SUPG, PACKAGE, B_BAR)
    tables = wave_tables(
        [row for m in methods for row in vibration(method=m, nu=0.3, cells=4)]
        + [row for m in methods for row in pulse(method=m, nu=0.0, cells=10)]
    )
    ours, default, theirs = (row for _, row in tables["vibration"].iterrows())
    assert ours["energy_left"] < default["energy_left"] < 1.001
    assert theirs["energy_left"] == pytest.approx(1.0, abs=1e-3)
    assert abs(theirs["damping_ratio"]) < 1e-5
    assert abs(theirs["frequency_error"]) < 0.02
    assert ours["energy_left"] < theirs["energy_left"]
    ours, default, theirs = (row for _, row in tables["pulse"].iterrows())
    assert default["error"] < ours["error"]
    assert theirs["energy_left"] == pytest.approx(1.0, abs=0.01)
    assert theirs["error"] < ours["error"]
    vibrates, arrives = (claim for claim in wave_claims(tables) if claim.where == SUPG.name)
    assert {vibrates.verdict, arrives.verdict} <= {"met", "met in part", "not met"}
    assert "nu 0.3 on 1/4" in vibrates.shown


@pytest.mark.parametrize(
    ("left", "error", "verdicts"),
    [(0.99, 0.45, ["met", "met"]), (0.9, 0.9, ["not met", "not met"])],
)
def test_waves_are_judged_by_what_is_left(left, error, verdicts):
    made = [
        {"part": "vibration", "method": SUPG.name, "nu": 0.3, "cells": 8, "energy_left": left,
         "frequency_error": 0.01},
        {"part": "pulse", "method": SUPG.name, "nu": 0.3, "error": error},
        {"part": "pulse", "method": B_BAR.name, "nu": 0.3, "error": 0.4},
    ]  # fmt: skip
    found = wave_claims(wave_tables(made))
    assert [claim.verdict for claim in found if claim.where == SUPG.name] == verdicts
    assert {claim.verdict for claim in found if claim.where == PACKAGE.name} == {"not examined"}
    assert {claim.verdict for claim in wave_claims(wave_tables([]))} == {"not examined"}


def waves_of_default(damping=5e-5, off=0.009, fine=0.002, pulse_over=0.9):
    """Claims on waves of the default alone, by the first word of what they say."""
    row = {"part": "vibration", "method": PACKAGE.name, "energy_left": 0.99}
    made = [
        *(row | {"nu": nu, "cells": 8, "damping_ratio": damping, "frequency_error": -off}
          for nu in (0.3, 0.495)),
        row | {"nu": 0.3, "cells": 16, "damping_ratio": 1.0, "frequency_error": fine},
        {"part": "pulse", "method": PACKAGE.name, "nu": 0.3, "error": pulse_over * 0.4},
        {"part": "pulse", "method": B_BAR.name, "nu": 0.3, "error": 0.4},
    ]  # fmt: skip
    found = [c for c in wave_claims(wave_tables(made)) if c.where == PACKAGE.name]
    return {claim.what.split()[0]: claim.verdict for claim in found[:3]}


@pytest.mark.parametrize(
    ("change", "what", "verdict"),
    [
        ({"damping": 5e-4}, "damping", "met in part"), ({"damping": 2e-3}, "damping", "not met"),
        ({"off": 0.015}, "frequency", "met in part"),
        ({"fine": -0.004}, "frequency", "met in part"),
        ({"off": 0.03, "fine": 0.004}, "frequency", "not met"),
        ({"pulse_over": 1.01}, "error", "not met"),
    ],
)  # fmt: skip
def test_the_default_is_asked_more_of_waves(change, what, verdict):
    assert set(waves_of_default().values()) == {"met"}
    assert waves_of_default(**change) == waves_of_default() | {what: verdict}


@pytest.mark.slow
def test_the_mode_is_the_limit_of_a_sequence():
    """Below every mesh of the sequence, as a minimum of the energy must be, and near the last."""
    mode = lowest_mode(0.3)
    assert len(waves.LEVELS) == 3
    assert mode.limit < mode.omega
    assert mode.omega == pytest.approx(mode.limit, rel=1e-3)
    X = np.array([[0.25, 1.0, 0.25], [0.0, 0.5, 0.0], [0.5, 0.5, 0.0], [0.1, 0.0, 0.3]])
    shape = mode(X)
    assert shape[0, 0] == pytest.approx(1.0, abs=0.01)
    # Bent about Z: one side is stretched where the other is pressed.
    assert shape[1, 1] == pytest.approx(-shape[2, 1])
    assert abs(shape[1, 1]) > 0.1
    assert np.allclose(shape[3], 0.0)
