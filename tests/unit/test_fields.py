"""Fields: shapes that users see, memory that kernels see."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.fields import (
    GRAIN,
    LANES,
    as_field,
    components,
    leading,
    scalar_field,
    tensor_field,
    vector_field,
)


@pytest.mark.parametrize("size", [1, 47, 48, 49, 64, 500, 512, 4096, 35937])
def test_rows_have_room_for_whole_tiles_and_do_not_evict_each_other(size: int) -> None:
    length = leading(size)
    assert length % LANES == 0
    assert size + GRAIN <= length <= size + GRAIN + 2 * LANES
    assert length % 512 != 0


@pytest.mark.parametrize("size", [0, 1, 100])
def test_a_field_and_its_memory_are_one(size: int) -> None:
    F, v, J = tensor_field(size), vector_field(size), scalar_field(size)
    records = tensor_field(size, particle_major=True)
    assert (F.shape, v.shape, J.shape) == ((size, 3, 3), (size, 3), (size,))
    assert components(F).shape == (9, leading(size))
    assert components(records).shape == (leading(size), 3, 3)
    if size:
        F[0, 1, 2] = v[0, 2] = J[0] = records[0, 1, 2] = 5.0
        assert components(F)[5, 0] == components(v)[2, 0] == components(J)[0, 0] == 5.0
        assert components(records)[0, 1, 2] == 5.0


def test_another_array_is_refused_or_copied() -> None:
    array = np.arange(27.0).reshape(3, 3, 3)
    with pytest.raises(TypeError, match=r"\(3, 3, 3\) is not a field"):
        components(array)
    with pytest.raises(TypeError, match="is not a field"):
        components(tensor_field(9)[2:])
    field = as_field(array)
    np.testing.assert_array_equal(field, array)
    assert as_field(field) is field
