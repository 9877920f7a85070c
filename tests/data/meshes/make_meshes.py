"""The mesh files of this folder, made with Gmsh 4.15: ``python make_meshes.py`` (not run by tests).

One body, a prism of height 1.5 on the trapezium (0, 0), (2, 0), (1.5, 1), (0, 1), all in metres:
volume 2.625.  Physical surfaces ``clamped`` (X = 0), ``slant`` (the inclined face) and ``top side``
(Z = 1.5); the other three faces have no name.

- ``prism_{tet,hex}_{1,2}_{22,41}_{text,binary}.msh``: order 1 and 2, MSH 2.2 and 4.1;
- ``prism_{tet,hex}_{1,2}.inp``: Abaqus, hexahedra of order 2 with 20 nodes;
- ``prism_{tet,hex}_{1,2}.vtu``: the same through meshio, each surface an array of zeros and ones;
- ``prism_tet_mm.msh``: the tetrahedra of order 1 in millimetres;
- ``save_all_{22,41}.msh``: saved with ``Mesh.SaveAll``, which spoils the groups;
- ``partitioned_{22,41}.msh``: two partitions, as for parallel codes; ``one_of_two_22.msh``: the
  first of them, saved on its own; ``parametric_{22,41}.msh``: with ``Mesh.SaveParametric``.

Vertices are the same in all files of a kind of cell.
"""

from __future__ import annotations

import contextlib
import importlib
import itertools
from pathlib import Path
from typing import Any

import meshio
import numpy as np

FOLDER = Path(__file__).parent
BASE = [(0.0, 0.0), (2.0, 0.0), (1.5, 1.0), (0.0, 1.0)]
HEIGHT = 1.5


def prism(gmsh: Any, scale: float, hexahedra: bool) -> None:
    """The body and its named surfaces, meshed in first order."""
    geo = gmsh.model.geo
    points = [geo.addPoint(scale * x, scale * y, 0.0) for x, y in BASE]
    lines = [geo.addLine(points[k], points[(k + 1) % 4]) for k in range(4)]
    base = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    if hexahedra:
        for line, cells in zip(lines, (3, 2, 3, 2), strict=True):
            geo.mesh.setTransfiniteCurve(line, cells + 1)
        geo.mesh.setTransfiniteSurface(base)
        geo.mesh.setRecombine(2, base)
        made = geo.extrude([(2, base)], 0, 0, scale * HEIGHT, numElements=[2], recombine=True)
    else:
        made = geo.extrude([(2, base)], 0, 0, scale * HEIGHT)
    geo.synchronize()
    # The top, the body, then a side for each line.
    top, body, _, slant, _, clamped = (tag for _, tag in made)
    gmsh.model.addPhysicalGroup(2, [clamped], name="clamped")
    gmsh.model.addPhysicalGroup(2, [slant], name="slant")
    gmsh.model.addPhysicalGroup(2, [top], name="top side")
    gmsh.model.addPhysicalGroup(3, [body], name="body")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.7 * scale)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.7 * scale)
    gmsh.model.mesh.generate(3)


def write(gmsh: Any, name: str, version: float, binary: bool) -> None:
    """Save the model as MSH."""
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(str(FOLDER / f"{name}.msh"))


def as_vtu(name: str) -> None:
    """The MSH file ``prism_{name}_41_text`` with an array for each named surface."""
    read = meshio.gmsh.read(str(FOLDER / f"prism_{name}_41_text.msh"))
    arrays = {
        key: [np.isin(np.arange(len(block.data)), its).astype(np.int32)
              for block, its in zip(read.cells, sets, strict=True)]
        for key, sets in read.cell_sets.items()
        if not key.startswith("gmsh:") and key != "body"
    }  # fmt: skip
    mesh = meshio.Mesh(read.points, read.cells, cell_data=arrays)
    meshio.write(FOLDER / f"prism_{name}.vtu", mesh)


def unread(gmsh: Any) -> None:
    """Files with features that are not read, and the same that are."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    prism(gmsh, 1.0, hexahedra=True)
    gmsh.option.setNumber("Mesh.SaveParametric", 1)
    write(gmsh, "parametric_22", 2.2, binary=False)
    write(gmsh, "parametric_41", 4.1, binary=False)
    gmsh.option.setNumber("Mesh.SaveParametric", 0)
    gmsh.model.mesh.partition(2)
    write(gmsh, "partitioned_22", 2.2, binary=False)
    write(gmsh, "partitioned_41", 4.1, binary=False)
    gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", 1)
    write(gmsh, "one_of_two_22", 2.2, binary=False)
    gmsh.finalize()
    (FOLDER / "one_of_two_22_1.msh").rename(FOLDER / "one_of_two_22.msh")
    (FOLDER / "one_of_two_22_2.msh").unlink()


def main() -> None:
    """Write every file."""
    gmsh: Any = importlib.import_module("gmsh")
    for cell, order in itertools.product(("tet", "hex"), (1, 2)):
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        prism(gmsh, 1.0, cell == "hex")
        gmsh.model.mesh.setOrder(order)
        for version, binary in itertools.product((2.2, 4.1), (False, True)):
            kind = "binary" if binary else "text"
            write(gmsh, f"prism_{cell}_{order}_{round(10 * version)}_{kind}", version, binary)
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        gmsh.model.mesh.setOrder(1)
        gmsh.model.mesh.setOrder(order)
        # Gmsh writes the name it is given into the heading.
        with contextlib.chdir(FOLDER):
            gmsh.write(f"prism_{cell}_{order}.inp")
        gmsh.finalize()
        as_vtu(f"{cell}_{order}")
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    prism(gmsh, 1000.0, hexahedra=False)
    write(gmsh, "prism_tet_mm", 4.1, binary=False)
    gmsh.finalize()
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    prism(gmsh, 1.0, hexahedra=True)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    write(gmsh, "save_all_22", 2.2, binary=False)
    write(gmsh, "save_all_41", 4.1, binary=False)
    gmsh.finalize()
    unread(gmsh)


if __name__ == "__main__":
    main()
