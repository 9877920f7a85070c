"""Options of ``run`` that are something else, in one sentence each, before any step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.record import Energy, EnergyLedger, NoOutput, Probe, ProgressLine, march

WRONG = [
    ({"record": Energy()}, r"record = Energy\(\) is one recorder; .*record=\[Energy\(\)\]"),
    ({"record": Energy}, r"record=\[Energy\(\)\]"),
    ({"record": Probe("tip")}, r"Probe\(point='tip'\) is one recorder"),
    ({"record": [Energy]}, r"the class Energy; write Energy\(\)"),
    ({"record": "energy"}, "'energy' is no list of recorders"),
    ({"record": None}, "None is no list"),
    ({"record": ["tip"]}, "'tip', which is no recorder"),
    ({"output": "out/run"}, r"'out/run' is a path; use RunFolder\('out/run'\)"),
    ({"output": Path("out")}, r"use RunFolder\('out'\)"),
    ({"output": NoOutput}, "is not an option object"),
    ({"output": None}, "is not an option object"),
    ({"progress": True}, r"progress = True is no object to be called; use ProgressLine\(\)"),
    ({"progress": ProgressLine}, "is no object to be called"),
    ({"until": "0.1"}, "until = '0.1' is not a number"),
    ({"until": True}, "until = True is not a number"),
    ({"until": np.nan}, "until = nan s must be finite"),
    ({"until": (0.1,)}, "not a number"),
    ({"every": "1e-3"}, "every = '1e-3' is not a number"),
]


@pytest.mark.parametrize(("options", "named"), WRONG)
def test_a_wrong_option_is_named(fake_solver, options, named):
    solver = fake_solver()
    with pytest.raises(InputError, match=named):
        march(solver, **{"until": 0.1, **options})
    assert solver.step == 0


def test_numbers_of_numpy_and_any_iterable_are_fine(fake_solver):
    record = (each for each in (Energy(),))
    history = march(fake_solver(), until=np.float32(0.5), every=np.float64(0.25), record=record)
    assert len(history.table) == 3


def test_recorders_that_need_it_get_an_account(fake_solver):
    solver = fake_solver()
    with pytest.raises(InputError, match="needs the account"):
        march(solver, until=0.1, record=[EnergyLedger()])
    assert solver.tracks
