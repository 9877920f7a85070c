"""Which CFL number does an operator allow on a cloud?  The spectrum of one step of a free cube."""

from __future__ import annotations

from typing import Any

import sphsolid as sph
from sphsolid.defaults import default_cfl, default_integrator
from sphsolid.errors import InputError
from sphsolid.scenes import Scene
from studies.clouds.cases import operator_of
from studies.clouds.choice import cloud_of, label_of
from studies.clouds.shape_cases import SOLID
from studies.stability.spectrum import Linearisation
from studies.stability.spectrum_growth import decades, largest_modulus, limits, scan

#: CFL numbers from which the limits are bracketed.
CFL = (0.35, 0.7, 0.9, 1.1, 1.3, 1.6)


def spectrum(*, cloud: str, level: int, operator: str) -> list[dict[str, Any]]:
    """A row: limits of the CFL number and growth at the default one, {p, F}, all else default.

    Limits are those of ``studies.stability``: no growth (``strict``), tenfold in 1000 steps
    (``slow``) and in 50 (``fast``), in units of the least distance of two neighbours.
    """
    instance = cloud_of(cloud).at(level)
    scene = Scene(name="free_cube", body=instance.body, material=SOLID, end_time=1.0)
    row: dict[str, Any] = {
        "kind": "spectrum", "cloud": label_of(cloud), "operator": operator, "h": instance.h,
    }  # fmt: skip
    options: dict[str, Any] = {
        "spacing": instance.spacing, "formulation": sph.PF(), "operator": operator_of(operator),
    }  # fmt: skip
    try:
        usual = sph.Simulation(scene, **options)
    except InputError as refusal:
        return [row | {"refused": str(refusal)}]
    cfl = default_cfl(default_integrator())
    linear = Linearisation(usual)

    def modulus(number: float) -> float:
        return largest_modulus(linear.eigenvalues(number))

    known = scan(modulus, CFL)
    return [
        row
        | {
            "particles": usual.cloud.size,
            "h_min_over_dx": usual.cloud.h_min / usual.cloud.spacing,
            "decades_at_default": decades(known[cfl]),
            **limits(modulus, known),
        }
    ]
