"""All methods of the paper and of others on the same scenes: ``python -m studies.comparison``.

The swinging cube, the twisting column and the punch with SUPG-SPH, JST-SPH, upwind SPH,
hourglass-controlled and plain displacement SPH, the package default, and meshes: B-bar,
Taylor-Hood, fully integrated and nodal-pressure elements, PG-FEM and constrained TOUCH.  Then the
short hard cases, a free body, and what a step of each costs in one common timing.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from studies.comparison.claims import AGREE, COMPARABLE, DRIFT, LIMIT, claims
from studies.comparison.contenders import (
    AGREEING,
    BARE,
    BY_NAME,
    COLUMN,
    CONTENDERS,
    CUBE,
    DEFAULT,
    ELEMENTS,
    JSTS,
    PAPERS,
    PETROV,
    PUNCH,
    SELF_ADJOINT,
    TOUCH,
    Contender,
    variants,
)
from studies.comparison.cost import run_cost
from studies.comparison.figures import FIGURES
from studies.comparison.pictures import PICTURED, PICTURES
from studies.comparison.runs import (
    AMPLITUDES,
    CUBE_NU,
    EARLY,
    SEED_CELLS,
    SPIN_CELLS,
    Shots,
    column_case,
    punch_case,
    run_column,
    run_cube,
    run_punch,
    run_seed,
    run_spin,
)
from studies.comparison.tables import (
    COLUMN_AT,
    CUBE_AT,
    EQUAL,
    NU,
    OMEGA,
    PUNCH_AT,
    PUNCH_FINE,
    papers_column,
    tables,
)
from studies.engine.study import Case, Study, Tables
from studies.measures.tables import select
from studies.pareto.problems import FAMILY as CUBE_FAMILY
from studies.pictures.picture import keeping
from studies.stability.judgement import CRITERIA, SOUND
from studies.twisting_column.outside import NAME as OUTSIDE
from studies.twisting_column.outside import sequence_frame

#: Amplitudes of the cube.
SCENES = tuple(AMPLITUDES)
#: Cells a side of the cube, and a metre of the column.
CUBES, COLUMNS = (4, 8, 16), (3, 4, 5)
#: Lattices that some have beside them: those of whom the claims speak, and those whose limits
#: must agree.
FINER = {
    **dict.fromkeys((DEFAULT, SELF_ADJOINT, PAPERS, JSTS), (6,)),
    **dict.fromkeys(AGREEING, (6, 8, 12)),
}
#: The column of the hard cases: angular velocity [rad/s], Poisson's ratio, cells a metre.
HARD_COLUMNS = ((200.0, NU, 5), (OMEGA, 0.3, 4))
#: Lattices of the column on which a step is timed.
TIMED = (4, 8)
#: In the short form.
_QUICK = (DEFAULT, PAPERS, JSTS, ELEMENTS, PETROV, TOUCH)


def _weight(one: Contender) -> float:
    """What a run costs beside one of the default, roughly."""
    return 40.0 if one.slow else 3.0 if one in (DEFAULT, ELEMENTS) else 20.0


def _of_scenes(one: Contender, quick: bool, out: Path) -> Iterator[Case]:
    weight = _weight(one)
    cubes: Sequence[int] = CUBES
    columns: Sequence[int] = (*COLUMNS, *FINER.get(one, ()))
    if quick:
        cubes, columns = CUBES[:2], COLUMNS[:1]
    for scene in SCENES[-1:] if quick else SCENES:
        for cells in cubes:
            yield Case(
                f"cube 1/{cells}, {scene}: {one.name}", run_cube,
                {"name": one.name, "method": one.on(CUBE), "scene": scene, "cells": cells},
                1.0e-6 * weight * cells**4,
            )  # fmt: skip
    pictured = columns[0] if quick else COLUMN_AT
    for cells in columns:
        kept = (0.1,) if one in PICTURED and cells == pictured else ()
        yield _column(one.name, one.on(COLUMN), OMEGA, NU, cells, _shots(out, kept), weight)
    if not quick or one in _QUICK[:4]:
        yield _punch(one, 10 if quick else PUNCH_AT, _shots(out, EARLY), weight)


def _shots(out: Path, times: tuple[float, ...]) -> Shots:
    return Shots((out / "shots").as_posix(), times)


def _column(
    name: str, method: Any, omega: float, nu: float, cells: int, shots: Shots, weight: float
) -> Case:
    soft = 1.0 if nu > 0.4 else 0.25
    return Case(
        f"{column_case(omega, nu, cells)}: {name}", run_column,
        {"name": name, "method": method, "omega": omega, "nu": nu, "cells": cells, "shots": shots},
        2.0e-3 * weight * (cells / 4.0) ** 4 * soft,
    )  # fmt: skip


def _punch(one: Contender, cells: int, shots: Shots, weight: float) -> Case:
    return Case(
        f"{punch_case(cells)}: {one.name}", run_punch,
        {"name": one.name, "method": one.on(PUNCH), "cells": cells, "shots": shots},
        2.0e-3 * weight * (cells / 20.0) ** 4,
    )  # fmt: skip


def _of_hard(one: Contender, quick: bool) -> Iterator[Case]:
    """What the scenes do not have already: faster, softer, a seed; and a free body."""
    weight = _weight(one)
    for omega, nu, cells in () if quick else HARD_COLUMNS:
        yield _column(one.name, one.on(COLUMN), omega, nu, cells, Shots(""), weight)
    given = {"name": one.name, "method": one.on(COLUMN)}
    if not quick:
        yield Case(f"seeded noise: {one.name}", run_seed, given, 2.0e-3 * weight)
    yield Case(f"free cube: {one.name}", run_spin, given, 1.0e-3 * weight)


def _of_variants() -> Iterator[Case]:
    for method in variants():
        given = {"name": method.name, "method": method}
        for scene in SCENES:
            yield Case(
                f"cube 1/{CUBE_AT}, {scene}: {method.name}", run_cube,
                given | {"scene": scene, "cells": CUBE_AT}, 0.1,
            )  # fmt: skip
        yield _column(method.name, method, OMEGA, NU, COLUMNS[1], Shots(""), 20.0)


def _cost(quick: bool) -> Iterator[Case]:
    shown = _QUICK if quick else CONTENDERS
    timed = [(one.name, one.on(COLUMN)) for one in shown]
    # The paper's own comparison has one formulation and one set of terms for both.
    timed = [(n, BY_NAME[n].on(CUBE) if n in BARE else m) for n, m in timed]
    timed += [(method.name, method) for method in BARE.values()]
    for cells in TIMED[:1] if quick else TIMED:
        given = {
            "methods": tuple(timed), "cells": cells, "window_s": 0.05 if quick else 0.3,
            "repeats": 3 if quick else 5,
        }  # fmt: skip
        yield Case(f"cost of a step, column 1/{cells}", run_cost, given, 2.0)


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """Every run of the study; the short form has six methods on coarse lattices."""
    quick = options.quick
    listed: list[Case] = []
    for one in _QUICK if quick else CONTENDERS:
        listed += [*_of_scenes(one, quick, options.out), *_of_hard(one, quick)]
    if not quick:
        listed += _of_variants()
        listed.append(_punch(ELEMENTS, PUNCH_FINE, Shots(""), 3.0))
    return [*listed, *_cost(quick)]


def tiny(options: argparse.Namespace) -> Sequence[Case]:
    """Runs that compile every kernel of the study."""
    shown = _QUICK if options.quick else CONTENDERS
    return [Case(f"cube 1/2: {one.name}", run_cube, {
        "name": one.name, "method": one.on(CUBE), "scene": "manufactured", "cells": 4,
    }) for one in shown]  # fmt: skip


def words(found: Tables) -> Mapping[str, Any]:
    """Constants, and parts of the tables in the units of the report."""
    table, runs, cube = found["table"], found["runs"], found["cube"]
    named = runs[runs["method"].isin(list(BY_NAME))]
    per_cent = ("energy_lost", "inside_out", "punch_lost", "punch_inside_out", "twist_error")
    shares = {name: 100.0 * table[name] for name in per_cent}
    own = [method.name for method in variants()]
    large = select(cube, scene="manufactured", cells=CUBE_AT).set_index("method")
    twisted = select(runs, case=column_case(OMEGA, NU, COLUMNS[1])).set_index("method")
    side = pd.DataFrame({"method": [name for name in own if name in large.index]})
    for column, source, frame in (
        ("cube_p", "momentum", large), ("cube_P", "stress", large),
        ("twist_error", "twist_error", twisted), ("energy_kept", "energy_kept", twisted),
        ("noise", "noise", twisted), ("verdict", "verdict", twisted), ("why", "why", twisted),
    ):  # fmt: skip
        side[column] = [frame[source].get(name) for name in side["method"]]
    columns = papers_column(named)
    finest = columns["cells"].max()
    return {
        "shown": table.assign(**shares, top_mm=1.0e3 * table["top_error"]),
        "variants": side, "named": named, "judged": named[named["verdict"] != SOUND],
        "columns": columns.assign(
            twist_percent=100.0 * columns["twist_error"], kept=100.0 * columns["energy_kept"],
            inside=100.0 * columns["inside_out"],
        ).sort_values(["cells"], kind="stable"),
        "cost": found["cost"].assign(
            us=1.0e6 * found["cost"]["step_s"],
            ns=1.0e9 * found["cost"]["step_s"] / found["cost"]["particles"],
        ),
        "sequences": sequence_frame(papers_column(runs), [one.name for one in AGREEING]),
        "agree": AGREE, "limit": LIMIT,
        "merit": found["merit"], "others": int((~found["merit"]["as_published"]).sum()),
        "criteria": CRITERIA, "outside": OUTSIDE, "nu": NU, "omega": OMEGA, "cube_nu": CUBE_NU,
        "family": CUBE_FAMILY, "seed_cells": SEED_CELLS, "spin_cells": SPIN_CELLS,
        "comparable": COMPARABLE, "drift": DRIFT, "cube_at": CUBE_AT, "column_at": COLUMN_AT,
        "punch_at": PUNCH_AT, "finest": finest, "timed": list(TIMED), "equal": list(_equal(found)),
        "fine": PUNCH_FINE, "slow": [one.name for one in CONTENDERS if one.slow],
        "default": DEFAULT.name, "papers": PAPERS.name, "jst": JSTS.name, "petrov": PETROV.name,
        "touch": TOUCH.name, "bar": ELEMENTS.name,
        "pictures": {name: each.is_worth_drawing(found) for name, each in PICTURES.items()},
    }  # fmt: skip


def _equal(found: Tables) -> Iterator[tuple[str, str, float, pd.DataFrame]]:
    """A table for each error that is asked for, with what it is an error of."""
    words = {"twist_error": "twist"}
    for scene, measure, asked in EQUAL:
        part = select(found["equal_error"], scene=scene, measure=measure)
        yield scene, words.get(measure, measure), asked, part


STUDY = Study(
    name="comparison",
    cases=cases,
    tables=tables,
    claims=claims,
    figures=FIGURES,
    shown=("cube", "column", "punch", "hard"),
    keep=keeping(list(PICTURES.values())),
    words=words,
    text=Path(__file__).with_name("report.md"),
    warm_up=tiny,
    description="All methods of the paper and of others on the same scenes.",
)
