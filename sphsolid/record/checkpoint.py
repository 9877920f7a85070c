"""Checkpoints: the complete state of a solver in one file, put back bit for bit."""

from __future__ import annotations

import hashlib
import json
import math
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import SOURCE_HASH, description
from sphsolid.errors import Diverged, InputError
from sphsolid.geometry.mesh import Mesh
from sphsolid.paths import path_of
from sphsolid.record.atomic import atomic
from sphsolid.record.plain import values_of
from sphsolid.record.samples import Samples, differences, instants, instants_ahead
from sphsolid.record.solver import Solver
from sphsolid.scenes.scene import NoBodyForce, Scene

Array = NDArray[np.float64]
AnySolver = TypeVar("AnySolver", bound=Solver)
FORMAT = "sphsolid checkpoint 4"
#: Arrays of the budget of energy and momentum begin with this.
BUDGET = "budget."


@dataclass(frozen=True)
class Checkpoint:
    """What a file holds: ``records`` rows of the run's history had been taken by then.

    ``samples`` of the problem's functions at ``instants`` [s] tell it from others (a file has them,
    a copy in memory needs none); ``totals`` is what the run had cost; ``folded_since`` [s] when its
    positions were first found folded, nan where they were not.
    """

    time: float
    step: int
    records: int
    identity: dict[str, str]
    arrays: dict[str, NDArray[Any]]
    instants: list[float] = field(default_factory=list)
    samples: Samples = field(default_factory=dict)
    totals: dict[str, float] = field(default_factory=dict)
    folded_since: float = math.nan


def checkpoint_of(solver: Solver, *, records: int = 0) -> Checkpoint:
    """The complete state of a solver; its arrays are the solver's own."""
    return Checkpoint(
        time=float(solver.time),
        step=solver.step,
        records=records,
        identity=solver.identity(),
        arrays=solver.state_arrays(),
        totals=solver.totals(),
        folded_since=float(solver.positions.folded_since),
    )


def _sampled(solver: Solver, until: float | None) -> list[float]:
    times = instants(solver.scene, until=until)
    # A diverged state can be written too; no step follows it.
    with suppress(Diverged):
        times += instants_ahead(solver.time, solver.stable_time_step())
    return times


def write_checkpoint(
    solver: Solver, path: str | Path, *, records: int = 0, until: float | None = None
) -> None:
    """Write the complete state; the file is whole or not there.

    ``until`` [s]: the end of the run, where it is not the scene's.
    """
    made = checkpoint_of(solver, records=records)
    times = _sampled(solver, until)
    header = {
        "format": FORMAT,
        # In hexadecimal, so that the instant comes back as the same double.
        "time": made.time.hex(),
        "step": made.step,
        "records": records,
        "identity": made.identity,
        "instants": [time.hex() for time in times],
        "samples": {name: values.tolist() for name, values in solver.samples(times).items()},
        "totals": made.totals,
        "folded_since": made.folded_since.hex(),
    }
    arrays = {f"state.{name}": array for name, array in made.arrays.items()}
    with atomic(path_of(path)) as part, part.open("wb") as file:
        np.savez(file, header=np.array(json.dumps(header)), **arrays)  # type: ignore[arg-type]


def read_checkpoint(path: str | Path) -> Checkpoint:
    """Read a file; raises ``InputError`` when it is missing, damaged or something else."""
    try:
        with np.load(path_of(path), allow_pickle=False) as file:
            header = json.loads(str(file["header"]))
            if header["format"] != FORMAT:
                raise InputError(f"{path} has the format {header['format']!r}, not {FORMAT!r}")
            arrays = {
                name.removeprefix("state."): file[name]
                for name in file.files
                if name.startswith("state.")
            }
            return Checkpoint(
                time=float.fromhex(header["time"]),
                step=int(header["step"]),
                records=int(header["records"]),
                identity=header["identity"],
                arrays=arrays,
                instants=[float.fromhex(time) for time in header["instants"]],
                samples={name: np.array(values) for name, values in header["samples"].items()},
                totals=header["totals"],
                folded_since=float.fromhex(header["folded_since"]),
            )
    except FileNotFoundError:
        raise InputError(f"there is no checkpoint {path}") from None
    except InputError:
        raise
    except (zipfile.BadZipFile, KeyError, TypeError, ValueError, OSError, EOFError) as damage:
        raise InputError(f"{path} is not a checkpoint, or is damaged ({damage})") from None


def restore(solver: Solver, path: str | Path) -> Checkpoint:
    """Put ``solver`` into the state of a checkpoint that an equal solver wrote.

    Nothing is changed when the checkpoint does not fit: ``InputError`` names what differs.
    """
    checkpoint = read_checkpoint(path)
    what = f"checkpoint {path}"
    differing = _other(solver.identity(), checkpoint.identity)
    differing += differences(
        checkpoint.samples, solver.samples(checkpoint.instants), checkpoint.instants
    )
    if differing:
        raise InputError(
            f"{what} does not fit this simulation ({'; '.join(differing)}); build the "
            "simulation with the same scene, spacing and options, by the sources and libraries "
            "that wrote the checkpoint, or start the run anew"
        )
    put_back(solver, checkpoint, what)
    return checkpoint


def rebuilt(
    kind: Callable[..., AnySolver], scene: Scene, arguments: dict[str, Any], state: Checkpoint
) -> AnySolver:
    """A solver set up anew and put into ``state``: how a pickled simulation comes back."""
    solver = kind(scene, **arguments)
    if differing := _other(solver.identity(), state.identity):
        raise InputError(f"the pickled simulation is of other sources ({'; '.join(differing)})")
    put_back(solver, state, "the pickled simulation")
    return solver


def _other(here: dict[str, str], there: dict[str, str]) -> list[str]:
    return [
        f"{key}: {there.get(key, 'nothing')} there, {here.get(key, 'nothing')} here"
        for key in sorted(here.keys() | there.keys())
        if here.get(key) != there.get(key)
    ]


def put_back(solver: Solver, checkpoint: Checkpoint, what: str) -> None:
    """Put ``solver`` into the state of ``checkpoint``, which must be its own or an equal one's.

    Raises ``InputError`` where the arrays are not those of ``solver``, and changes nothing then.
    """
    _write_over(solver.state_arrays(), checkpoint, what)
    kept = [name for name in checkpoint.arrays if name.startswith(BUDGET)]
    if kept and not solver.state_arrays().keys() & set(kept):
        # That budget goes on, not one that begins here.
        solver.track_budget()
        _write_over(solver.state_arrays(), checkpoint, what)
    solver.time, solver.step = checkpoint.time, checkpoint.step
    solver.positions.folded_since = checkpoint.folded_since
    solver.go_on_from(checkpoint.totals)
    solver.state_changed()


def _write_over(targets: dict[str, Array], checkpoint: Checkpoint, what: str) -> None:
    for name, target in targets.items():
        found = checkpoint.arrays.get(name)
        if found is None or found.shape != target.shape or found.dtype != target.dtype:
            raise InputError(
                f"{what} holds no array {name!r} of shape {target.shape}; go on with "
                "the same recorders as before, or start the run anew"
            )
    for name, target in targets.items():
        target[...] = checkpoint.arrays[name]


def common_identity(scene: Scene, material: Any, mesh: Mesh, V: Array) -> dict[str, str]:
    """What any method must agree on: problem, points, probes, sources and libraries.

    ``material`` is the law that the solver runs, as it was when the solver was built.
    Loads, motions and initial data are functions, of which there are :mod:`samples`.
    """
    libraries = description()
    held = [f"{c.face} {c.direction} {type(c.velocity).__name__}" for c in scene.constraints]
    loaded = [f"traction {traction.face}" for traction in scene.tractions]
    if not isinstance(scene.body_force, NoBodyForce):
        loaded.append("body force")
    return {
        "scene": scene.name,
        "material": values_of(scene.material),
        # The text of a law of the user's own, by its hash.
        "law": type(material).__name__,
        "constraints": ", ".join(held) or "none",
        "loads": ", ".join(loaded) or "none",
        "points": _hash(mesh.vertices, V),
        "sources": SOURCE_HASH,
        "libraries": ", ".join(f"{k} {libraries[k]}" for k in ("numba", "llvmlite", "numpy")),
    } | {
        f"boundary {face}": _hash(mesh.face(face))
        for face in [c.face for c in scene.constraints] + [t.face for t in scene.tractions]
    } | {f"probe {name}": f"X = {list(place)} m" for name, place in scene.probes.items()}


def _hash(*arrays: NDArray[Any]) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]
