"""The comparison of methods: tables, claims and order of merit on planted runs; a quick run."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import pandas as pd
import pytest

import sphsolid as sph
from studies import comparison
from studies.comparison.claims import ratios
from studies.comparison.contenders import (
    BY_NAME,
    CLASSICAL,
    CONTENDERS,
    DEFAULT,
    ELEMENTS,
    JSTS,
    PAPERS,
    PETROV,
    PRINTED,
)
from studies.comparison.cost import run_cost, step_seconds
from studies.comparison.runs import column_case, punch_case, run_column, run_cube, run_spin
from studies.comparison.tables import COLUMN_AT, CUBE_AT, NU, OMEGA, PUNCH_AT, merit, tables
from studies.methods import B_BAR, PACKAGE, PG_FEM
from studies.stability.judgement import DIVERGED, SOUND, USELESS
from studies.twisting_column.outside import twist

#: Errors of planted methods, as multiples of those of the paper's.
PLANTED = {
    PAPERS: 1.0, PRINTED: 4.0, JSTS: 2.0, PETROV: 1.2, CLASSICAL: 5.0, DEFAULT: 0.1, ELEMENTS: 0.5,
}  # fmt: skip


def cube_row(name: str, cells: int, error: float, scene: str = "manufactured") -> dict:
    return {
        "kind": "cube", "method": name, "scene": scene, "cells": cells, "steps": 10,
        "particles": (cells + 1) ** 3, "survived": True, "folded": False, "folded_at": math.nan,
        "momentum": error, "stress": 2.0 * error,
    }  # fmt: skip


def run_row(name: str, case: str, scene: str, **more: object) -> dict:
    sound = {
        "kind": "run", "scene": scene, "case": case, "method": name, "cells": 5, "particles": 100,
        "steps": 10, "applicable": True, "survived": True, "folded": False, "folded_at": math.nan,
        "end_time": 0.1, "energy_kept": 0.97, "energy_gain": 0.0, "J_min": 0.9, "J_max": 1.1,
        "unseen_rms": 0.1, "inside_out": 0.0, "noise": 0.1, "answer": 5.9, "why": "",
        "answer_is": "largest twist [rad]", "diverged_at": math.nan,
    }  # fmt: skip
    return sound | more


def column_row(name: str, error: float, cells: int = COLUMN_AT, **more: object) -> dict:
    known = {f"twist_{ms}": twist(ms).value * (1.0 + error) for ms in (20, 40, 60, 80, 100)}
    given: dict[str, object] = {"omega": OMEGA, "nu": NU, "cells": cells} | known | more
    return run_row(name, column_case(OMEGA, NU, cells), "column", **given)


def punch_row(name: str, error: float, cells: int = PUNCH_AT) -> dict:
    answer = {"answer": 0.05, "answer_is": "bulge of the top [m]", "cells": cells}
    ends = {"low": 0.45 + 0.01 * error, "high": 0.54}
    return run_row(name, punch_case(cells), "punch", **answer, **ends)


def cost_row(name: str, cells: int, particles: int, seconds: float) -> dict:
    return {
        "kind": "cost", "method": name, "cells": cells, "particles": particles, "step_s": seconds,
        "window_steps": 2, "repeats": 3,
    }  # fmt: skip


@pytest.fixture
def rows() -> list[dict]:
    made = [punch_row(ELEMENTS.name, 0.0, 40)]
    for one, size in PLANTED.items():
        for cells in (4, CUBE_AT):
            error = 0.02 * size * (CUBE_AT / cells) ** 2
            made += [cube_row(one.name, cells, error), cube_row(one.name, cells, error, "linear")]
        made.append(column_row(one.name, 0.02 * size))
        made.append(punch_row(one.name, size))
        made += [cost_row(one.name, 4, 100, 1.0e-3), cost_row(one.name, 8, 1100, 6.0e-3)]
        made.append(
            {"kind": "spin", "method": one.name, "survived": True, "folded": False,
             "folded_at": math.nan, "linear_drift": 1.0e-15, "angular_drift": 1.0e-14}
        )  # fmt: skip
    return made


def verdict(made: dict, start: str) -> str:
    found = [claim for claim in comparison.claims(made) if claim.what.startswith(start)]
    return found[0].verdict


def test_equal_particles_and_the_three_claims(rows: list[dict]) -> None:
    made = tables(rows)
    table = made["table"].set_index("method")
    assert list(table.index) == [one.name for one in CONTENDERS if one in PLANTED]
    assert table["cube_p"][JSTS.name] == pytest.approx(0.04)
    assert table["twist_error"][JSTS.name] == pytest.approx(0.04)
    assert table["top_error"][JSTS.name] == pytest.approx(0.02)
    found = ratios(made["table"], JSTS.name, PAPERS.name)
    assert list(found.values()) == pytest.approx([2.0] * 4)
    accuracy = [claim for claim in comparison.claims(made) if claim.what.startswith("1.")]
    assert [claim.verdict for claim in accuracy] == ["reproduced", "not reproduced"]
    assert verdict(made, "3.") == "reproduced"


def test_the_saved_cost_is_that_of_the_dissipation_alone(rows: list[dict]) -> None:
    bare = {PAPERS.name: 0.9e-3, JSTS.name: 0.5e-3}
    for name, seconds in bare.items():
        rows.append(cost_row(comparison.BARE[name].name, 4, 100, seconds))
    claim = next(c for c in comparison.claims(tables(rows)) if c.what.startswith("2."))
    assert claim.measured == {"column 1/4": pytest.approx(5.0)}
    assert claim.verdict == "reproduced"


def test_order_of_merit_is_held_against_the_papers(rows: list[dict]) -> None:
    assert merit(tables(rows)["table"])["as_published"].all()
    for row in rows:
        if row["kind"] == "cube" and row["method"] == JSTS.name:
            row["momentum"] *= 0.1
    found = merit(tables(rows)["table"]).set_index("measure")["as_published"]
    assert not found["cube momentum"]
    assert found["cube stress"]


def test_a_run_that_folded_has_no_merit(rows: list[dict]) -> None:
    for row in rows:
        if row["kind"] == "run" and row["method"] == JSTS.name and row["scene"] == "column":
            row["folded"] = True
    made = tables(rows)
    found = made["merit"].set_index("measure")["found"]["column twist"]
    assert found.endswith(f"{JSTS.name} (folded)")
    assert verdict(made, "1.") == "reproduced in part"


def test_equal_error_takes_no_run_that_folded(rows: list[dict]) -> None:
    made = tables([*rows, column_row(JSTS.name, 0.005, 6, folded=True, particles=400)])
    own = made["equal_error"].set_index(["measure", "method"])
    assert own.loc[("momentum", PAPERS.name), "how"] == "extrapolated"
    assert own.loc[("momentum", DEFAULT.name), "how"] == "coarsest is enough"
    assert own.loc[("twist_error", JSTS.name), "how"] == "not reached"
    assert math.isnan(own.loc[("twist_error", JSTS.name), "particles"])


def test_verdicts_of_runs(rows: list[dict]) -> None:
    broken = {
        JSTS.name: {"survived": False, "diverged_at": 0.05, "why": "negative Jacobian"},
        PETROV.name: {"folded": True},
    }
    for row in rows:
        if row["kind"] == "run" and row["scene"] == "column":
            row.update(broken.get(row["method"], {}))
    found = select_column(tables(rows)["runs"])
    assert found[JSTS.name] == DIVERGED
    assert found[PETROV.name] == USELESS
    assert found[DEFAULT.name] == SOUND


def select_column(runs: pd.DataFrame) -> pd.Series:
    return runs[runs["scene"] == "column"].set_index("method")["verdict"]


def test_seconds_of_a_step_have_a_fixed_part() -> None:
    cost = pd.DataFrame([cost_row("a", 4, 100, 1.0e-3), cost_row("a", 8, 1100, 6.0e-3)])
    assert step_seconds(cost, "a", 100) == pytest.approx(1.0e-3)
    assert step_seconds(cost, "a", 2100) == pytest.approx(11.0e-3)
    assert step_seconds(cost.iloc[:1], "a", 200) == pytest.approx(2.0e-3)
    assert math.isnan(float(step_seconds(cost, "b", 200)))


def test_nothing_was_run_yet() -> None:
    made = tables([])
    assert len(made["table"]) == len(made["merit"]) == 0


def test_cases_have_names_of_their_own_and_options_of_the_scene(tmp_path: Path) -> None:
    for quick in (True, False):
        listed = comparison.cases(argparse.Namespace(quick=quick, out=tmp_path))
        assert len({case.key for case in listed}) == len(listed)
    assert len(BY_NAME) == len(CONTENDERS)
    punched = JSTS.punch.simulation(sph.scenes.punch(), spacing=0.1)
    assert punched.stabilisation == sph.JST(eps_J4=1.0 / 32.0)
    assert JSTS.cube.simulation(sph.scenes.punch(), spacing=0.1).formulation == sph.PFHJ()


def test_a_run_of_each_kind(tmp_path: Path) -> None:
    shots = comparison.Shots(tmp_path.as_posix(), (0.1,))
    rows = []
    for method in (PACKAGE, B_BAR, PG_FEM):
        rows += run_cube(name=method.name, method=method, scene="manufactured", cells=4)
    for method in (PACKAGE, B_BAR):
        rows += run_column(
            name=method.name, method=method, omega=OMEGA, nu=0.3, cells=3, shots=shots
        )
        rows += run_spin(name=method.name, method=method)
    timed = tuple((method.name, method) for method in (PACKAGE, B_BAR))
    rows += run_cost(methods=timed, cells=3, window_s=0.001, repeats=1)
    made = tables(rows)
    assert (made["spin"][["linear_drift", "angular_drift"]] <= 1.0e-12).all(axis=None)
    assert (made["runs"]["verdict"] == SOUND).all()
    assert made["cube"].set_index("method")["momentum"][PACKAGE.name] < 0.1
    assert (made["cost"]["step_s"] > 0.0).all()
    assert len(list(tmp_path.iterdir())) == 2
