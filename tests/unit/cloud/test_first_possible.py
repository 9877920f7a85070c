"""A default that does not exist on a cloud gives way, and says so; what was asked for does not."""

from __future__ import annotations

import warnings

import pytest

import sphsolid as sph
from sphsolid.cloud.first_possible import Candidate, first_possible
from sphsolid.errors import InputError
from sphsolid.geometry import Box

MESH = Box(jitter=0.3, seed=2).mesh(0.25)
#: Fewer than four neighbours: no gradient at all.
NONE = Candidate(sph.SummationByParts(), 0.3)
GOOD = Candidate(sph.Consistent(), 0.9)


def test_the_first_that_exists_is_taken_without_a_word() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = first_possible(MESH, sph.WendlandC2(), [GOOD, NONE])
    assert (found.candidate, found.refused) == (GOOD, ())


def test_a_fallback_is_said_once_with_its_reason() -> None:
    with pytest.warns(UserWarning, match=r"Consistent with h_over_dx = 0.9 is used inst") as said:
        found = first_possible(MESH, sph.WendlandC2(), [NONE, NONE, GOOD])
    assert len(said) == 1
    assert found.candidate == GOOD
    assert [candidate for candidate, _ in found.refused] == [NONE, NONE]
    assert "too small" in found.refused[0][1]


def test_where_none_exists_the_first_refusal_is_raised() -> None:
    with pytest.raises(InputError, match=r"h_over_dx = 0.3 is too small"):
        first_possible(MESH, sph.WendlandC2(), [NONE, Candidate(sph.Consistent(), 0.2)])
