"""Vertices and facets out of a Wavefront OBJ file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Surfaces that are no facets: patches and curves.
_CURVED = ("curv", "curv2", "surf", "cstype", "deg", "bzp", "bsp")


def read_obj(path: Path) -> tuple[Array, list[Indices]]:
    """Vertices ``(n, 3)`` in units of the file; facets of three and of four corners.

    Of a vertex that has a weight or a colour only the place is read.  A facet may count vertices
    from the end, and a line go on in the next.  Groups and materials name nothing.  Raises
    ``InputError`` for facets of more corners, curved surfaces, and what is no number.
    """
    data = path.read_bytes()
    require(b"\0" not in data, f"{path} is no text, or in UTF-16; save it as UTF-8 or ASCII")
    text = data.decode("utf-8-sig", errors="replace").replace("\\\r\n", " ")
    points: list[list[float]] = []
    loops: dict[int, list[list[int]]] = {3: [], 4: []}
    for number, line in enumerate(text.replace("\\\n", " ").splitlines(), start=1):
        words = line.split("#")[0].split()
        if not words:
            continue
        where = f"{path}, line {number}"
        require(
            words[0] not in _CURVED,
            f"{where}: curved surfaces ({words[0]}) are not read; save the surface as triangles",
        )
        try:
            if words[0] == "v":
                points.append([float(word) for word in words[1:4]])
                require(len(points[-1]) == 3, f"{where}: a vertex needs three coordinates")
            elif words[0] == "f":
                corners = [int(word.split("/")[0]) for word in words[1:]]
                require(
                    len(corners) in loops,
                    f"{where}: facets of {len(corners)} corners are not read; save the surface "
                    "as triangles",
                )
                require(0 not in corners, f"{where}: vertex 0: OBJ counts from one")
                # From one, or back from the vertex before this line, which is -1.
                loops[len(corners)].append([k - 1 if k > 0 else len(points) + k for k in corners])
        except InputError:
            raise
        except ValueError as error:
            raise InputError(f"{where}: {line.strip()[:60]!r} cannot be read ({error})") from error
    found = [np.array(rows, dtype=np.int64).reshape(-1, size) for size, rows in loops.items()]
    X = np.array(points, dtype=np.float64).reshape(-1, 3)
    for rows in found:
        require(
            rows.size == 0 or (int(rows.min()) >= 0 and int(rows.max()) < len(X)),
            f"{path}: facets use vertices that the file does not have; it has {len(X)}",
        )
    return X, found
