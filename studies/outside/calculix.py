"""Runs CalculiX on a deck and reads back what it wrote."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from studies.outside.deck import Deck

Array = NDArray[np.float64]
PROGRAM = "ccx"
_NAME = "deck"
_BLOCK = re.compile(
    r"^ (displacements|total internal energy|total kinetic energy).* and time\s+(\S+)\s*$"
)
_EIGENVALUES = "E I G E N V A L U E   O U T P U T"


@dataclass(frozen=True)
class Answer:
    """Records of a run: ``time (T,)`` [s], ``u (T, n, 3)`` [m] and both energies ``(T,)`` [J]."""

    time: Array
    u: Array
    strain_energy: Array
    kinetic_energy: Array


def installed() -> bool:
    """Whether the program is on the path."""
    return shutil.which(PROGRAM) is not None


@cache
def version() -> str:
    """The version that the program states; raises ``InputError`` where it is not installed."""
    _require_program()
    said = subprocess.run([PROGRAM, "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"Version\s+(\S+)", said)
    return found.group(1) if found else "unknown"


def solve(deck: Deck) -> tuple[str, float]:
    """The text that a run prints to its ``.dat`` file, and the wall time [s] of the run.

    One thread.  Raises ``InputError`` where the program is not installed, and where it stops before
    its end, with what it said.
    """
    _require_program()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, f"{_NAME}.inp").write_text(deck.text, encoding="ascii")
        start = time.perf_counter()
        ran = subprocess.run(
            [PROGRAM, "-i", _NAME], cwd=folder, capture_output=True, text=True, check=False,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        wall_s = time.perf_counter() - start
        if ran.returncode != 0 or "Job finished" not in ran.stdout or "*ERROR" in ran.stdout:
            said = [line for line in ran.stdout.splitlines() if line.strip()]
            wrong = [line.strip() for line in said if "*ERROR" in line]
            raise InputError(f"CalculiX stopped: {'; '.join(wrong or said[-3:])}")
        return Path(folder, f"{_NAME}.dat").read_text(encoding="ascii"), wall_s


def read(text: str, nodes: int) -> Answer:
    """The records in the text of a ``.dat`` file of a body of so many ``nodes``."""
    found: dict[str, dict[float, list[list[float]]]] = {}
    rows: list[list[float]] = []
    for line in text.splitlines():
        block = _BLOCK.match(line)
        if block:
            rows = found.setdefault(block.group(1), {}).setdefault(float(block.group(2)), [])
        elif line.strip():
            rows.append([float(word) for word in line.split()])
    require(
        set(found) == {"displacements", "total internal energy", "total kinetic energy"},
        f"the .dat file of CalculiX has no {{displacements, energies}}; it has {sorted(found)}",
    )
    shifts = [np.array(rows) for rows in found["displacements"].values()]
    require(
        all(shift.shape == (nodes, 4) for shift in shifts),
        f"the .dat file of CalculiX does not have displacements of {nodes} nodes",
    )
    return Answer(
        time=np.array(list(found["displacements"])),
        u=np.stack([shift[:, 1:] for shift in shifts]),
        strain_energy=np.array([rows[0][0] for rows in found["total internal energy"].values()]),
        kinetic_energy=np.array([rows[0][0] for rows in found["total kinetic energy"].values()]),
    )


def read_frequencies(text: str) -> Array:
    """Angular frequencies ``(n,)`` [rad/s], ascending, of the text of a ``.dat`` file."""
    _, found, rest = text.partition(_EIGENVALUES)
    require(bool(found), "the .dat file of CalculiX has no eigenvalues")
    rows = []
    for line in rest.splitlines():
        words = line.split()
        if len(words) == 5 and words[0].isdigit():
            rows.append(float(words[2]))
        elif rows:
            break
    return np.array(rows)


def _require_program() -> None:
    if not installed():
        raise InputError(
            f"CalculiX is not installed ({PROGRAM} is not on the path): install the Debian package "
            "calculix-ccx, or run our solvers alone with --codes ours"
        )
