"""The mesh files of this folder, remade with Gmsh: ``python -m studies.meshes.make_meshes``.

Made with Gmsh 4.15 (not a dependency of this project: ``pip install gmsh`` to run this).  Lengths
are in metres; all named faces are physical surfaces.

- ``plate_with_hole_{hex,tet}.msh``: quarter of a square plate of half-width 0.5 and thickness 0.05
  with a hole of radius 0.1 about the Z axis.  ``hole``; ``symmetry_x`` in the plane X = 0,
  ``symmetry_y`` in Y = 0; ``pull`` at Y = 0.5, ``side`` at X = 0.5; ``back`` at Z = 0, ``front``.
- ``cylinder_{hex,tet}.msh``: radius 0.5, 0 <= Z <= 1.  ``bottom``, ``top``, ``wall``.
- ``cube_{tet_4,tet_8,hex_8}.msh``: unit cube at 1/4 and 1/8, unstructured (the hexahedra in X and
  Y, in layers along Z).  ``X- X+ Y- Y+ Z- Z+``.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Iterable
from typing import Any

from studies.meshes import MESHES as FOLDER

#: Half-width, thickness and radius of the hole of the plate; side of the block around the hole.
WIDTH, THICKNESS, HOLE, INNER = 0.5, 0.05, 0.1, 0.25
#: Radius of the cylinder, and of the corners of the square block in its middle.
RADIUS, MIDDLE = 0.5, 0.33

Axis = tuple[float, float]


def plate_with_hole_hex(gmsh: Any) -> None:
    """Structured: two blocks from the hole to a square, three around it, four layers."""
    across, along, layers = 10, 13, 4
    half = HOLE * math.sqrt(0.5)
    geo = gmsh.model.geo
    p = {
        name: geo.addPoint(x, y, 0.0)
        for name, (x, y) in {
            "centre": (0.0, 0.0), "h0": (HOLE, 0.0), "h1": (half, half), "h2": (0.0, HOLE),
            "i0": (INNER, 0.0), "i1": (INNER, INNER), "i2": (0.0, INNER),
            "o0": (WIDTH, 0.0), "o1": (WIDTH, INNER), "o2": (WIDTH, WIDTH),
            "o3": (INNER, WIDTH), "o4": (0.0, WIDTH),
        }.items()
    }  # fmt: skip
    arcs = [geo.addCircleArc(p[a], p["centre"], p[b]) for a, b in (("h0", "h1"), ("h1", "h2"))]
    spokes = [geo.addLine(p[f"h{k}"], p[f"i{k}"]) for k in range(3)]
    line = {
        a + b: geo.addLine(p[a], p[b])
        for a, b in (
            ("i0", "i1"), ("i1", "i2"), ("i0", "o0"), ("o0", "o1"), ("i1", "o1"),
            ("o1", "o2"), ("o2", "o3"), ("i1", "o3"), ("o3", "o4"), ("i2", "o4"),
        )
    }  # fmt: skip
    loops = [
        [spokes[0], line["i0i1"], -spokes[1], -arcs[0]],
        [spokes[1], line["i1i2"], -spokes[2], -arcs[1]],
        [line["i0o0"], line["o0o1"], -line["i1o1"], -line["i0i1"]],
        [line["i1o1"], line["o1o2"], line["o2o3"], -line["i1o3"]],
        [line["i1o3"], line["o3o4"], -line["i2o4"], -line["i1i2"]],
    ]
    surfaces = [geo.addPlaneSurface([geo.addCurveLoop(loop)]) for loop in loops]
    for curve in (*arcs, *line.values()):
        geo.mesh.setTransfiniteCurve(curve, across + 1)
    # Cells as long as they are wide at the hole and at the square.
    growth = (INNER * 4 / (math.pi * HOLE)) ** (1.0 / (along - 1))
    for curve in spokes:
        geo.mesh.setTransfiniteCurve(curve, along + 1, "Progression", growth)
    _extrude_structured(gmsh, surfaces, THICKNESS, layers)
    _name_plate(gmsh)


def plate_with_hole_tet(gmsh: Any) -> None:
    """Unstructured, graded from the hole outwards."""
    occ = gmsh.model.occ
    plate = occ.addBox(0.0, 0.0, 0.0, WIDTH, WIDTH, THICKNESS)
    hole = occ.addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, THICKNESS, HOLE)
    occ.cut([(3, plate)], [(3, hole)])
    occ.synchronize()
    size = gmsh.model.mesh.field
    size.add("MathEval", 1)
    size.setString(1, "F", f"Min(0.0245, 0.0095 + 0.06 * Max(0, Sqrt(x*x + y*y) - {HOLE}))")
    size.setAsBackgroundMesh(1)
    _name_plate(gmsh)


def _name_plate(gmsh: Any) -> None:
    def on_hole(x: float, y: float, z: float) -> bool:
        return math.hypot(x, y) < HOLE + 1e-6

    _name_faces(
        gmsh,
        {
            "hole": on_hole,
            "symmetry_x": lambda x, y, z: abs(x) < 1e-6,
            "symmetry_y": lambda x, y, z: abs(y) < 1e-6,
            "pull": lambda x, y, z: y > WIDTH - 1e-6,
            "side": lambda x, y, z: x > WIDTH - 1e-6,
            "back": lambda x, y, z: z < 1e-6,
            "front": lambda x, y, z: z > THICKNESS - 1e-6,
        },
    )


def cylinder_hex(gmsh: Any) -> None:
    """Structured: a square block in the middle, four around it."""
    across, along, layers = 8, 4, 14
    geo = gmsh.model.geo
    centre = geo.addPoint(0.0, 0.0, 0.0)
    inner, outer = (
        [
            geo.addPoint(math.sqrt(0.5) * r * x, math.sqrt(0.5) * r * y, 0.0)
            for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        ]
        for r in (MIDDLE, RADIUS)
    )
    spokes = [geo.addLine(a, b) for a, b in zip(inner, outer, strict=True)]
    sides = [geo.addLine(inner[k], inner[(k + 1) % 4]) for k in range(4)]
    arcs = [geo.addCircleArc(outer[k], centre, outer[(k + 1) % 4]) for k in range(4)]
    loops = [sides, *([spokes[k], arcs[k], -spokes[(k + 1) % 4], -sides[k]] for k in range(4))]
    surfaces = [geo.addPlaneSurface([geo.addCurveLoop(loop)]) for loop in loops]
    for curve in (*sides, *arcs):
        geo.mesh.setTransfiniteCurve(curve, across + 1)
    for curve in spokes:
        geo.mesh.setTransfiniteCurve(curve, along + 1)
    _extrude_structured(gmsh, surfaces, 1.0, layers)
    _name_cylinder(gmsh)


def cylinder_tet(gmsh: Any) -> None:
    """Unstructured, of one size."""
    gmsh.model.occ.addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, RADIUS)
    gmsh.model.occ.synchronize()
    _one_size(gmsh, 0.07)
    _name_cylinder(gmsh)


def _name_cylinder(gmsh: Any) -> None:
    _name_faces(
        gmsh,
        {
            "bottom": lambda x, y, z: z < 1e-6,
            "top": lambda x, y, z: z > 1.0 - 1e-6,
            "wall": lambda x, y, z: math.hypot(x, y) > RADIUS - 1e-6,
        },
    )


def cube_tet(size: float) -> Callable[[Any], None]:
    """Unstructured tetrahedra of one size."""

    def make(gmsh: Any) -> None:
        gmsh.model.occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
        gmsh.model.occ.synchronize()
        _one_size(gmsh, size)
        _name_cube(gmsh)

    return make


def cube_hex_8(gmsh: Any) -> None:
    """Unstructured quadrilaterals, eight layers of them."""
    occ = gmsh.model.occ
    square = occ.addRectangle(0.0, 0.0, 0.0, 1.0, 1.0)
    occ.extrude([(2, square)], 0.0, 0.0, 1.0, numElements=[8], recombine=True)
    occ.synchronize()
    gmsh.model.mesh.setRecombine(2, square)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 1)
    _one_size(gmsh, 0.125)
    _name_cube(gmsh)


def _name_cube(gmsh: Any) -> None:
    def side(axis: int, value: float) -> Callable[..., bool]:
        return lambda *X: abs(X[axis] - value) < 1e-6

    _name_faces(
        gmsh,
        {f"{'XYZ'[axis]}{sign}": side(axis, at) for axis in range(3) for sign, at in
         (("-", 0.0), ("+", 1.0))},
    )  # fmt: skip


def _one_size(gmsh: Any, size: float) -> None:
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)


def _extrude_structured(gmsh: Any, surfaces: Iterable[int], height: float, layers: int) -> None:
    geo = gmsh.model.geo
    for surface in surfaces:
        geo.mesh.setTransfiniteSurface(surface)
        geo.mesh.setRecombine(2, surface)
    geo.extrude(
        [(2, surface) for surface in surfaces], 0, 0, height, numElements=[layers], recombine=True
    )
    geo.synchronize()


def _name_faces(gmsh: Any, places: dict[str, Callable[[float, float, float], bool]]) -> None:
    """Physical surfaces: each outer surface belongs to the place that all its vertices are in."""
    gmsh.model.mesh.generate(3)
    model = gmsh.model
    volumes = model.getEntities(3)
    outer = [tag for _, tag in model.getBoundary(volumes, combined=True, oriented=False)]
    groups: dict[str, list[int]] = {name: [] for name in places}
    for surface in outer:
        _, coordinates, _ = model.mesh.getNodes(2, surface, includeBoundary=True)
        points = coordinates.reshape(-1, 3).tolist()
        (name,) = (name for name, at in places.items() if all(at(*point) for point in points))
        groups[name].append(surface)
    for name, found in groups.items():
        model.addPhysicalGroup(2, found, name=name)
    model.addPhysicalGroup(3, [tag for _, tag in volumes], name="body")


#: File -> what makes it, and the version of the format it is written in.
FILES: dict[str, tuple[Callable[[Any], None], float]] = {
    "plate_with_hole_hex": (plate_with_hole_hex, 4.1),
    "plate_with_hole_tet": (plate_with_hole_tet, 2.2),
    "cylinder_hex": (cylinder_hex, 4.1),
    "cylinder_tet": (cylinder_tet, 2.2),
    "cube_tet_4": (cube_tet(1 / 4), 4.1),
    "cube_tet_8": (cube_tet(1 / 8), 4.1),
    "cube_hex_8": (cube_hex_8, 4.1),
}


def main() -> None:
    """Write every file."""
    gmsh: Any = importlib.import_module("gmsh")
    for name, (make, version) in FILES.items():
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.Binary", 1)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        # Sizes are set above, for the whole body.
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.option.setNumber("Mesh.OptimizeNetgen", 1)
        make(gmsh)
        gmsh.write(str(FOLDER / f"{name}.msh"))
        gmsh.finalize()


if __name__ == "__main__":
    main()
