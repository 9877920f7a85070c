"""The list of files in a folder that a run of ours made, and that another may remove."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from sphsolid.errors import InputError
from sphsolid.record.atomic import PART

NAME = "manifest.txt"


class Manifest:
    """Names relative to ``folder``; each is added to the list before its file comes to be.

    So a run that is killed leaves no file of its own unlisted, and what is not on the list is
    somebody else's.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._path = folder / NAME
        self.exists = self._path.is_file()
        try:
            text = self._path.read_text(encoding="utf-8") if self.exists else ""
        except UnicodeDecodeError as damage:
            raise InputError(
                f"{self._path} is no list of files, or is damaged ({damage}): which files of the "
                "folder are those of a run is not known; move them, or choose another folder"
            ) from None
        # A name that was cut short by a kill was never followed by its file.
        lines = [line[:-1] for line in text.splitlines(keepends=True) if line.endswith("\n")]
        self.names = {line for line in lines if _is_inside(line)}

    def add(self, name: str) -> Path:
        """Own ``name`` from now on; returns its path."""
        if name not in self.names:
            with self._path.open("ab", buffering=0) as file:
                file.write(f"{name}\n".encode())
            self.exists = True
            self.names.add(name)
        return self.folder / name

    def remove(self, names: list[str]) -> None:
        """Delete files that are ours, in this order; they stay on the list."""
        for name in names:
            if name in self.names:
                (self.folder / name).unlink(missing_ok=True)

    def remove_parts(self) -> None:
        """Delete what a kill left half written."""
        for name in sorted(self.names):
            (self.folder / (name + PART)).unlink(missing_ok=True)

    def foreign(self, names: list[str]) -> list[str]:
        """Those of ``names`` that exist and are not ours."""
        return [n for n in names if n not in self.names and (self.folder / n).exists()]


def _is_inside(name: str) -> bool:
    path = PurePosixPath(name)
    return bool(name) and not path.is_absolute() and ".." not in path.parts
