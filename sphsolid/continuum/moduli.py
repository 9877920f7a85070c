"""Elastic constants of the small-strain limit, and the check of what a user gives."""

from __future__ import annotations

from typing import NamedTuple

from sphsolid.errors import require
from sphsolid.protocols import number


class Elastic(NamedTuple):
    """``mu``, ``kappa`` [Pa] shear and bulk modulus, ``density`` [kg/m^3]."""

    mu: float
    kappa: float
    density: float


def elastic(young_modulus: float, poisson_ratio: float, density: float) -> Elastic:
    """The moduli of ``E`` [Pa], ``nu`` and ``rho0`` [kg/m^3].

    Raises ``InputError`` unless they are numbers, ``E > 0``, ``-1 < nu < 0.5`` and ``rho0 > 0``.
    """
    check_elastic(young_modulus, poisson_ratio, density)
    return Elastic(
        mu=shear_modulus(young_modulus, poisson_ratio),
        kappa=bulk_modulus(young_modulus, poisson_ratio),
        density=float(density),
    )


def check_elastic(young_modulus: float, poisson_ratio: float, density: float) -> None:
    """Raise ``InputError`` unless ``E > 0``, ``-1 < nu < 0.5`` and ``rho0 > 0``."""
    require(
        number("young_modulus", young_modulus, "Pa") > 0.0,
        f"young_modulus = {young_modulus} Pa must be positive and finite",
    )
    require(
        -1.0 < number("poisson_ratio", poisson_ratio) < 0.5,
        f"poisson_ratio = {poisson_ratio} is outside (-1, 0.5): at 0.5 the bulk modulus and the "
        "p-wave speed are infinite and no explicit time step exists; use 0.499 for rubber",
    )
    require(
        number("density", density, "kg/m^3") > 0.0,
        f"density = {density} kg/m^3 must be positive and finite",
    )


def shear_modulus(young_modulus: float, poisson_ratio: float) -> float:
    """``mu = E / (2 (1 + nu))`` [Pa]."""
    return young_modulus / (2.0 * (1.0 + poisson_ratio))


def bulk_modulus(young_modulus: float, poisson_ratio: float) -> float:
    """``kappa = E / (3 (1 - 2 nu))`` [Pa]."""
    return young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))


def first_lame(mu: float, kappa: float) -> float:
    """``lambda = kappa - 2 mu / 3`` [Pa]."""
    return kappa - 2.0 * mu / 3.0
