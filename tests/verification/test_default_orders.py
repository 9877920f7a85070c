"""The package's own choices converge at second order: nothing given but the scene and spacing."""

from __future__ import annotations

from typing import Any

import pytest

import sphsolid as sph
from sphsolid.scenes import amplitude_of_gradient, swinging_cube
from studies.measures.order import last_order
from studies.measures.swinging_cube import LINEAR_AMPLITUDE, period_errors_of

CASES: dict[str, dict[str, Any]] = {
    "A+B+C=0": {"family": "A+B+C=0", "amplitude": LINEAR_AMPLITUDE},
    "A=B=C": {"family": "A=B=C", "amplitude": LINEAR_AMPLITUDE},
    "manufactured": {
        "family": "A+B+C=0",
        "amplitude": amplitude_of_gradient("A+B+C=0", 0.2),
        "manufactured": True,
    },
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFJ()], ids=lambda f: f.name)
def test_every_component_is_second_order(name: str, formulation: Any) -> None:
    errors = [
        period_errors_of(
            sph.Simulation(
                swinging_cube(**CASES[name]), spacing=1.0 / cells, formulation=formulation
            )
        )
        for cells in (8, 16)
    ]
    slopes = {
        what: last_order([1 / 8, 1 / 16], [level[what] for level in errors])
        for what in errors[0]
    }
    assert min(slope for what, slope in slopes.items() if what.startswith("p")) > 1.93, slopes
    assert min(slope for what, slope in slopes.items() if what.startswith("P")) > 1.85, slopes
