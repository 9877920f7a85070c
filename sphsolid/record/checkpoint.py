"""Checkpoints: the complete state of a solver in one file, put back bit for bit."""

from __future__ import annotations

import hashlib
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import CACHE_DIR, description
from sphsolid.errors import InputError
from sphsolid.record.atomic import atomic
from sphsolid.record.solver import Solver
from sphsolid.scenes.scene import NoBodyForce, Scene

Array = NDArray[np.float64]
FORMAT = "sphsolid checkpoint 1"


@dataclass(frozen=True)
class Checkpoint:
    """What a file holds: ``records`` rows of the run's history had been taken by then."""

    time: float
    step: int
    records: int
    identity: dict[str, str]
    arrays: dict[str, NDArray[Any]]


def write_checkpoint(solver: Solver, path: str | Path, *, records: int = 0) -> None:
    """Write the complete state; the file is whole or not there."""
    header = {
        "format": FORMAT,
        # In hexadecimal, so that the instant comes back as the same double.
        "time": float(solver.time).hex(),
        "step": solver.step,
        "records": records,
        "identity": solver.identity(),
    }
    arrays = {f"state.{name}": array for name, array in solver.state_arrays().items()}
    with atomic(Path(path)) as part, part.open("wb") as file:
        np.savez(file, header=np.array(json.dumps(header)), **arrays)  # type: ignore[arg-type]


def read_checkpoint(path: str | Path) -> Checkpoint:
    """Read a file; raises ``InputError`` when it is missing, damaged or something else."""
    try:
        with np.load(path, allow_pickle=False) as file:
            header = json.loads(str(file["header"]))
            if header["format"] != FORMAT:
                raise InputError(f"{path} has the format {header['format']!r}, not {FORMAT!r}")
            arrays = {
                name.removeprefix("state."): file[name]
                for name in file.files
                if name.startswith("state.")
            }
    except FileNotFoundError:
        raise InputError(f"there is no checkpoint {path}") from None
    except InputError:
        raise
    except (zipfile.BadZipFile, KeyError, TypeError, ValueError, OSError, EOFError) as damage:
        raise InputError(f"{path} is not a checkpoint, or is damaged ({damage})") from None
    return Checkpoint(
        time=float.fromhex(header["time"]),
        step=int(header["step"]),
        records=int(header["records"]),
        identity=header["identity"],
        arrays=arrays,
    )


def restore(solver: Solver, path: str | Path) -> Checkpoint:
    """Put ``solver`` into the state of a checkpoint that an equal solver wrote.

    Nothing is changed when the checkpoint does not fit: ``InputError`` names what differs.
    """
    checkpoint = read_checkpoint(path)
    here = solver.identity()
    differing = [
        f"{key}: {checkpoint.identity.get(key, 'nothing')} there, {here.get(key, 'nothing')} here"
        for key in sorted(here.keys() | checkpoint.identity.keys())
        if here.get(key) != checkpoint.identity.get(key)
    ]
    if differing:
        raise InputError(
            f"checkpoint {path} does not fit this simulation ({'; '.join(differing)}); build the "
            "simulation with the same scene, spacing and options, by the sources and libraries "
            "that wrote the checkpoint, or start the run anew"
        )
    targets = solver.state_arrays()
    for name, target in targets.items():
        found = checkpoint.arrays.get(name)
        if found is None or found.shape != target.shape or found.dtype != target.dtype:
            raise InputError(
                f"checkpoint {path} holds no array {name!r} of shape {target.shape}; go on with "
                "the same recorders as before, or start the run anew"
            )
    for name, target in targets.items():
        target[...] = checkpoint.arrays[name]
    solver.time, solver.step = checkpoint.time, checkpoint.step
    solver.state_changed()
    return checkpoint


def common_identity(scene: Scene, X: Array, V: Array) -> dict[str, str]:
    """What any method must agree on: problem, points, initial state, sources and libraries.

    Loads and constraints are functions of time, of which only the places are compared.
    """
    libraries = description()
    held = [f"{c.face} {c.direction} {type(c.velocity).__name__}" for c in scene.constraints]
    loaded = [f"traction {traction.face}" for traction in scene.tractions]
    if not isinstance(scene.body_force, NoBodyForce):
        loaded.append("body force")
    return {
        "scene": scene.name,
        "material": repr(scene.material),
        "constraints": ", ".join(held) or "none",
        "loads": ", ".join(loaded) or "none",
        "points": _hash(X, V),
        "initial state": _hash(*scene.initial_state(X)),
        # The name of the kernels' folder is the hash of the sources as they were imported.
        "sources": CACHE_DIR.name,
        "libraries": ", ".join(f"{k} {libraries[k]}" for k in ("numba", "llvmlite", "numpy")),
    }


def _hash(*arrays: Array) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]
