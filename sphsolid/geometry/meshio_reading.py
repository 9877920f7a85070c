"""The readers of meshio: the one place that knows what they do and leave undone.

Each reader is called by itself: ``meshio.read`` tries several formats on a ``.msh`` file, prints
blank lines for those that fail and ends the process when none fits.
"""

from __future__ import annotations

import contextlib
import io
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from sphsolid.errors import InputError
from sphsolid.geometry.file_content import Block, Indices
from sphsolid.geometry.unread_features import Reasons


def read_guarded(
    reader: Callable[[str], Any], path: Path, what: str, reasons: Reasons = ()
) -> Any:
    """What a reader of meshio returns; whatever it raises becomes an ``InputError``.

    ``reasons``: a pattern of what meshio says of a feature that it does not read, and what to say
    of it instead of that the file is damaged.
    """
    said = io.StringIO()
    with (
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        try:
            return reader(str(path))
        except (Exception, SystemExit) as error:
            reason = " ".join(f"{type(error).__name__} {error} {said.getvalue()}".split())
            hints = [hint for pattern, hint in reasons if re.search(pattern, reason)]
            hint = [*hints, "it is truncated or damaged, or not what its name says"][0]
            raise InputError(f"{path} cannot be read as {what}: {hint} ({reason})") from error


def by_number(values: Any) -> list[tuple[int, Indices]]:
    """Each number above zero with the rows ``(k,)`` that have it; all of them by one sort."""
    order = np.argsort(values, kind="stable")
    order = order[values[order] > 0]
    starts = np.flatnonzero(np.diff(values[order].astype(np.int64), prepend=0))
    parts = np.split(order, starts[1:]) if len(order) else []
    return [(int(values[rows[0]]), rows) for rows in parts]


def index(nodes: Any) -> Indices:
    """Vertices of cells as numbers of one kind, whatever the file has them in."""
    return np.asarray(nodes).astype(np.int64)


def blocks_of(mesh: Any) -> tuple[Block, ...]:
    """All cells of what meshio has read."""
    return tuple(Block(block.type, index(block.data)) for block in mesh.cells)
