"""Folded positions as a criterion: what a row says, and when a run counts as sound."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import FoldingWarning
from sphsolid.look.frame import take_shot
from sphsolid.scenes import twisting_column
from studies.measures.folding import folding, has_folded, largest, sound
from studies.measures.indicators import twist_of_top

RUNS = pd.DataFrame(
    {"survived": [True, True, True, False], "folded": [False, True, True, False],
     "folded_at": [math.nan, 0.02, 0.08, math.nan]}
)  # fmt: skip


def test_folded_by_a_time():
    assert has_folded(RUNS).tolist() == [False, True, True, False]
    assert has_folded(RUNS, by=0.05).tolist() == [False, True, False, False]
    assert sound(RUNS).tolist() == [True, False, False, False]


def test_a_table_that_was_read_back_says_the_same():
    text = RUNS.astype(object)
    assert has_folded(text, by=0.05).tolist() == has_folded(RUNS, by=0.05).tolist()


def test_the_largest_of_a_history():
    history = pd.DataFrame({"unseen_rms [-]": [0.0, 0.3, math.nan, 0.1]})
    assert largest(history, "unseen_rms [-]") == 0.3
    assert math.isnan(largest(history, "no such column"))


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_a_run_that_did_nothing_yet_is_not_folded(solver):
    sim = solver(twisting_column(), spacing=0.5)
    sim.run(until=2e-3)
    assert folding(sim)["folded"] is False
    assert math.isnan(folding(sim)["folded_at"])
    assert not take_shot(sim.snapshot(), "sound").folded


def test_a_saw_tooth_is_folded_in_a_picture_whatever_its_gradients_say():
    """Layers turned to and fro by half a radian: the top's twist is what it was."""
    shot = sph.Simulation(twisting_column(), spacing=0.25).snapshot()
    X = shot.X
    layer = np.rint(X[:, 1] / 0.25)
    angle = np.where(layer == layer.max(), 0.0, 0.5 * (-1.0) ** layer)
    turned = (X[:, 0] + 1j * X[:, 2]) * np.exp(1j * angle)
    bent = replace(shot, x=np.stack([turned.real, X[:, 1], turned.imag], axis=1))
    assert twist_of_top(bent) == pytest.approx(0.0, abs=1e-12)
    assert take_shot(bent, "a saw tooth").folded
    assert not take_shot(shot, "at rest").folded


@pytest.mark.filterwarnings("ignore::sphsolid.errors.FoldingWarning")
def test_a_run_that_folds_says_when():
    """Nothing stabilises it: the column of two cells across folds on the way."""
    assert issubclass(FoldingWarning, UserWarning)
    sim = sph.Simulation(
        twisting_column(poisson_ratio=0.3), spacing=0.25, stabilisation=sph.NoStabilisation()
    )
    sim.run(until=0.1)
    row = folding(sim)
    assert row["folded"] is True
    assert 0.0 < row["folded_at"] <= 0.1
