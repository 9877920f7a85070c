"""``J^(-2/3)`` without a power function."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from sphsolid.compiled import serial_kernel
from sphsolid.continuum.inverse_root import inverse_two_thirds


@serial_kernel
def in_a_kernel(J, out):  # type: ignore[no-untyped-def]
    for i in range(len(J)):
        out[i] = inverse_two_thirds(J[i])


def compiled(J: NDArray[np.float64]) -> NDArray[np.float64]:
    out = np.empty_like(J)
    in_a_kernel(J, out)
    return out


def test_it_is_the_power_to_a_few_units_in_the_last_place() -> None:
    J = np.concatenate(
        [np.linspace(0.3, 3.0, 20_001), np.exp(np.linspace(-300.0, 300.0, 20_001))]
    )
    # In extended precision: the exponent itself is rounded, which shows where J is huge or tiny.
    exact = J.astype(np.longdouble) ** (np.longdouble(-2) / 3)
    np.testing.assert_allclose(compiled(J), exact.astype(float), rtol=2e-15)
    assert compiled(np.ones(1))[0] == 1.0


def test_a_lost_volume_is_not_a_number() -> None:
    assert np.all(np.isnan(compiled(np.array([0.0, -1.0, -1e-300, np.nan]))))


def test_python_numbers_complex_numbers_and_arrays_keep_the_power() -> None:
    assert inverse_two_thirds(8.0) == 8.0 ** (-2.0 / 3.0)
    z = inverse_two_thirds(complex(2.0, 1e-30))
    assert z.imag / 1e-30 == pytest.approx(-2.0 / 3.0 * 2.0 ** (-5.0 / 3.0), rel=1e-14)
    np.testing.assert_array_equal(inverse_two_thirds(np.ones(3)), np.ones(3))
