"""Whether a run's folder can be where its path says, refused in one sentence where it cannot."""

from __future__ import annotations

from pathlib import Path

from sphsolid.errors import InputError, require


def refuse_no_name(path: Path) -> None:
    """Raise ``InputError`` for a path that no file system can have."""
    require(
        "\0" not in str(path),
        f"RunFolder: path = {str(path)!r} has a null character, which no name may have; choose "
        "another",
    )


def refuse_no_folder(folder: Path) -> None:
    """Raise ``InputError`` for a file, for what is below one, and for what cannot be looked at."""
    try:
        above = next(place for place in (folder, *folder.parents) if place.exists())
        is_free = above.is_dir()
    except (OSError, StopIteration) as failure:
        reason = getattr(failure, "strerror", None) or "there is no such place"
        raise InputError(f"{folder} cannot be a folder ({reason}); choose another") from None
    what = folder if above == folder else f"{above}, in the path of the run,"
    require(is_free, f"{what} is a file; name a folder for the run")


def make_folder(folder: Path, inside: str) -> None:
    """Make ``folder`` and the one named ``inside`` it; raises ``InputError`` where that fails."""
    try:
        (folder / inside).mkdir(parents=True, exist_ok=True)
    except OSError as failure:
        raise InputError(
            f"the folder {folder} cannot be made ({failure.strerror}); choose another"
        ) from None
