"""Files that are either whole or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

#: What is still being written ends in this; a kill may leave one behind, the next write reuses it.
PART = ".part"


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Yield a path beside ``path`` to write to; it takes the place of ``path`` when all went well.

    A reader, and a process that is killed at any moment, sees the old file or the new one.  (The
    loss of power is another matter: nothing is forced to the disk.)
    """
    part = path.with_name(path.name + PART)
    try:
        yield part
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
