"""Paths as a user writes them."""

from __future__ import annotations

import os
from pathlib import Path

from sphsolid.errors import InputError


def path_of(given: str | os.PathLike[str]) -> Path:
    """The path, ``~`` being the home folder; raises ``InputError`` for anything but a path."""
    try:
        return Path(given).expanduser()
    except TypeError:
        raise InputError(
            f"{given!r} is not a path; give a string or a pathlib.Path"
        ) from None
    except RuntimeError as homeless:
        raise InputError(f"{given}: there is no such home folder ({homeless})") from None
