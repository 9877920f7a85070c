"""Solved operators on disk, by a hash of everything they depend on: a second set-up is a read.

A file is whole or not there, and one that cannot be read is made anew.  The folder is that of the
compiled kernels (``SPHSOLID_CACHE``, or the user's cache); the oldest files make room for new ones.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import zipfile
import zlib
from contextlib import suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numba
import numpy as np
import scipy
from numpy.typing import NDArray

from sphsolid.cloud.operator import Gradients, Ingredients, OperatorKind
from sphsolid.compiled import SOURCE_HASH, cache_base

Array = NDArray[np.float64]
#: Clouds of fewer particles are solved faster than it is worth to keep them.
LEAST_PARTICLES = 4000
#: Bytes the folder may hold.
MOST_BYTES = 4_000_000_000
_PACKAGE = "sphsolid"
#: What an option may hold besides options.
_DATA = (bool, int, float, str, type(None))


def gradients_of(operator: OperatorKind, cloud: Ingredients) -> Gradients:
    """``operator.build(cloud)``, from the disk where it was built before.

    Only operators that say ``is_kept`` are, of classes of this package, with a smoothing function
    and a mesh of it: the text of a user's own class is not in the hash, derived from ours or not.
    """
    if not getattr(operator, "is_kept", False) or len(cloud.volumes) < LEAST_PARTICLES:
        return operator.build(cloud)
    told = _is_told_by_repr(operator) and _is_told_by_repr(cloud.smoothing)
    if not told or not _is_ours(type(cloud.mesh)):
        return operator.build(cloud)
    try:
        folder = cache_base() / "operators"
    except OSError:
        return operator.build(cloud)
    path = folder / f"{content_hash(operator, cloud)}.npz"
    shapes = (len(cloud.pairs.indices), 3), (len(cloud.volumes), 3)
    return _read(path, *shapes) or _write(path, operator.build(cloud))


def _is_ours(kind: type) -> bool:
    """True for a class of this package itself, not one that says so or is made from it."""
    home = kind.__module__
    if home.split(".")[0] != _PACKAGE:
        return False
    return getattr(sys.modules.get(home), kind.__qualname__, None) is kind


def _is_told_by_repr(option: Any) -> bool:
    """True where our sources and the ``repr`` of ``option`` say all that it does."""
    kind = type(option)
    if kind in _DATA or (kind.__module__ == "numpy" and isinstance(option, np.generic)):
        return True
    return _is_ours(kind) and is_dataclass(option) and all(
        _is_told_by_repr(getattr(option, each.name)) for each in fields(option)
    )


def content_hash(operator: OperatorKind, cloud: Ingredients) -> str:
    """Of the mesh, what was made of it, the options, our sources and the libraries."""
    digest = hashlib.sha256()
    for part in (
        SOURCE_HASH, numba.__version__, np.__version__, scipy.__version__,
        repr(operator), repr(cloud.smoothing), repr(cloud.mesh.is_lattice),
        repr(cloud.mesh.spacing), *sorted(cloud.mesh.faces),
    ):  # fmt: skip
        digest.update(part.encode())
    mesh = cloud.mesh
    arrays: list[NDArray[Any]] = [mesh.vertices, mesh.cells, cloud.volumes, cloud.areas]
    arrays += [mesh.faces[name] for name in sorted(mesh.faces)]
    arrays += [cloud.pairs.indptr, cloud.pairs.indices, np.asarray(cloud.h)]
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:32]


def _read(path: Path, pairs: tuple[int, int], areas: tuple[int, int]) -> Gradients | None:
    try:
        with np.load(path, allow_pickle=False) as file:
            kinematic = file["kinematic"]
            force = file.get("force", kinematic)
            found = Gradients(
                kinematic, force, file["areas"], int(file["iterations"]), float(file["change"])
            )
    except (OSError, EOFError, KeyError, TypeError, ValueError, zipfile.BadZipFile, zlib.error):
        return None
    wanted = (found.kinematic, pairs), (found.force, pairs), (found.areas, areas)
    if any(part.shape != shape or part.dtype != np.float64 for part, shape in wanted):
        # Readable, but not what belongs to these particles.
        return None
    # The time of the last use decides what makes room; a cache of others may be read-only.
    with suppress(OSError):
        os.utime(path)
    return found


def _write(path: Path, made: Gradients) -> Gradients:
    arrays: dict[str, Array] = {
        "kinematic": made.kinematic,
        "areas": made.areas,
        "iterations": np.array(made.iterations),
        "change": np.array(made.change),
    }
    if not made.is_adjoint:
        arrays["force"] = made.force
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as part:
            try:
                np.savez(part, **arrays)  # type: ignore[arg-type]
                part.close()
                os.replace(part.name, path)
            except BaseException:
                Path(part.name).unlink(missing_ok=True)
                raise
        _make_room(path.parent)
    except OSError:
        # No room or no right to write: the next run solves again.
        return made
    return made


def _make_room(folder: Path) -> None:
    files = sorted(folder.glob("*.npz"), key=lambda file: file.stat().st_mtime, reverse=True)
    total = 0
    for file in files:
        total += file.stat().st_size
        if total > MOST_BYTES:
            file.unlink(missing_ok=True)
