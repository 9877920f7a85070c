"""An array in words that are the same for equal arrays, however long they are."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray


def array_words(array: NDArray[Any]) -> str:
    """Shape, type of the numbers and a digest of all their bytes; an array of objects as a list.

    ``repr`` leaves out the middle of a long array.
    """
    if array.dtype.hasobject:
        return f"array{array.shape} of {array.tolist()!r}"
    held = np.ascontiguousarray(np.ma.getdata(array))
    digest = hashlib.sha256(held.tobytes())
    if np.ma.isMaskedArray(array):
        digest.update(np.ma.getmaskarray(array).tobytes())
    return f"array{array.shape} {array.dtype.str} {digest.hexdigest()[:16]}"
