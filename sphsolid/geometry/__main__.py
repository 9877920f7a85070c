"""Check a mesh file: ``python -m sphsolid.geometry FILE [--unit mm]``."""

from __future__ import annotations

import argparse
import sys
import warnings

from sphsolid.errors import InputError
from sphsolid.geometry.check_mesh import check_mesh
from sphsolid.geometry.mesh_file import MeshFile


def main(arguments: list[str] | None = None) -> int:
    """Print the report of a mesh file; 0, or 1 with one line on the standard error stream."""
    parser = argparse.ArgumentParser(
        prog="python -m sphsolid.geometry",
        description="Read a mesh file as a particle body would be, and say what it is worth.",
    )
    parser.add_argument("file", help="Gmsh .msh, VTK .vtu or Abaqus .inp")
    parser.add_argument(
        "--unit",
        help="m (taken if none is given), cm, mm, um, in, ft, or metres to a unit of the file",
    )
    given = parser.parse_args(arguments)
    try:
        with warnings.catch_warnings():
            # What they say is printed with the report.
            warnings.simplefilter("ignore")
            found = MeshFile(given.file, _unit(given.unit or "m")).read()
        report = check_mesh(
            found.mesh,
            unused_vertices=found.unused_vertices,
            midside_vertices=found.midside_vertices,
            unit_given=given.unit is not None,
        )
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(f"{given.file}, lengths in {given.unit or 'm'}")
    if found.left_handed:
        print("all cells of the file were inverted; they have been mirrored")
    for note in found.notes:
        print(note)
    print(report)
    return 0


def _unit(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


if __name__ == "__main__":
    sys.exit(main())
