"""Sets of Abaqus that overlap or share a name: a tag is whole, or refused when it is asked for."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile
from sphsolid.geometry.integrals import area_vectors
from sphsolid.geometry.mesh import Mesh, copied
from sphsolid.geometry.mesh_file import Reading
from sphsolid.geometry.refine import refined

#: Four by four by two cells; nodes and elements count from one.
MESH = Box(upper=(1.0, 1.0, 0.5)).mesh(0.25)
LOW, HIGH = (np.flatnonzero(MESH.vertices[:, 2] == z) + 1 for z in (0.0, 0.5))
CENTRE = MESH.vertices[MESH.cells].mean(axis=1)
BELOW = np.flatnonzero(CENTRE[:, 2] < 0.25) + 1
#: Half of the cells below, and the nodes of theirs at the bottom.
HALF = np.flatnonzero((CENTRE[:, 2] < 0.25) & (CENTRE[:, 0] < 0.5)) + 1
HALF_NODES = np.flatnonzero((MESH.vertices[:, 2] == 0.0) & (MESH.vertices[:, 0] <= 0.5)) + 1


def rows(numbers) -> str:
    return "".join(f"{n}\n" for n in numbers)


def table(lines, first: int = 1) -> str:
    return "".join(
        f"{k}, " + ", ".join(map(str, line)) + "\n" for k, line in enumerate(lines, first)
    )


BODY = f"*NODE\n{table(MESH.vertices.tolist())}*ELEMENT, TYPE=C3D8, ELSET=ALL\n" + table(
    (MESH.cells + 1).tolist()
)
QUADS = (MESH.faces["Z-"] + 1).tolist()
FIX = f"*NSET, NSET=FIX\n{rows(LOW)}"
TOP = f"*NSET, NSET=TOP\n{rows(HIGH)}"
PRESS = f"*ELSET, ELSET=H\n{rows(HALF)}*SURFACE, NAME=PRESS\nH, S1\n"
BOTTOM = f"*ELSET, ELSET=B\n{rows(BELOW)}*SURFACE, NAME=BOTTOM\nB, S1\n"
SKIN = f"*ELEMENT, TYPE=S4, ELSET=SKIN\n{table(QUADS[:4], 901)}"
PART = f"*NSET, NSET=PART\n{rows(HALF_NODES)}"


def read(tmp_path: Path, more: str, body: str = BODY) -> tuple[Reading, list[str]]:
    path = tmp_path / "body.inp"
    path.write_text(body + more)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = MeshFile(path).read()
    return found, [str(warning.message).split("body.inp: ")[1] for warning in caught]


def sizes(mesh: Mesh) -> dict[str, int]:
    assert sum(map(len, mesh.faces.values())) == len(mesh.boundary) == 64
    np.testing.assert_allclose(area_vectors(mesh, mesh.boundary).sum(axis=0), 0.0, atol=1e-15)
    return {name: len(facets) for name, facets in mesh.faces.items() if name != "boundary"}


#: What stands in the file, the tags and their facets, and how each other name is refused.
OVERLAPS = {
    "a node set and a surface of part of it": (
        FIX + PRESS, {"PRESS": 8}, {"FIX": "node set 'FIX' .* 8 of its 16 .*surface 'PRESS'"},
    ),
    "the surface first": (
        PRESS + FIX, {"PRESS": 8}, {"FIX": "8 of its 16 facets.* surface 'PRESS'"},
    ),
    "a node set and a skin of shells": (
        FIX + SKIN, {"SKIN": 4}, {"FIX": "4 of its 16 facets, .* element set 'SKIN'"},
    ),
    "a part of a surface": (
        BOTTOM + PART, {"BOTTOM": 16}, {"PART": "8 of its 8 facets, .* surface 'BOTTOM'"},
    ),
    "two surfaces": (
        BOTTOM + PRESS, {"BOTTOM": 16},
        {"PRESS": "surface 'PRESS' .* 8 of its 8 facets.* surface 'BOTTOM', and a facet can have"},
    ),
    "a set of a set": (
        FIX + f"*NSET, NSET=BOTH\nFIX\n{rows(HIGH)}",
        {"FIX": 16}, {"BOTH": "16 of its 32 facets, .* node set 'FIX'"},
    ),
    "a second name": (
        FIX + FIX.replace("FIX", "HOLD"), {"FIX": 16},
        {"HOLD": "node set 'HOLD' has the facets of node set 'FIX', .* use the name 'FIX'"},
    ),
    "the copy that CAE makes of a set": (
        FIX + "*SURFACE, TYPE=NODE, NAME=FIX_CNS_, INTERNAL\nFIX, 1.\n", {"FIX": 16},
        {"FIX_CNS_": "surface of nodes 'FIX_CNS_' has the facets of node set 'FIX'"},
    ),
    "an internal set before that of a user": (
        FIX.replace("=FIX", "=_PickedSet4, INTERNAL") + PART, {"PART": 8},
        {"_PickedSet4": "'_PickedSet4' .* 8 of its 16 facets, .* node set 'PART'"},
    ),
    "an internal set alone": (FIX.replace("=FIX", "=_P4, INTERNAL"), {"_P4": 16}, {}),
    "a surface and a node set of one name": (
        BOTTOM.replace("BOTTOM", "A") + TOP.replace("TOP", "A"), {},
        {"A": "'A' names two things of different facets, surface .16 facets. and node set .16.*"
              "give each a name of its own"},
    ),
    "a surface of nodes and a node set of one name": (
        FIX.replace("FIX", "A") + TOP + "*SURFACE, TYPE=NODE, NAME=A\nTOP\n", {"TOP": 16},
        {"A": "'A' names two things .* node set .16 facets. and surface of nodes"},
    ),
    "an element set and a surface of one name": (
        SKIN.replace("SKIN", "A") + BOTTOM.replace("BOTTOM", "A"), {},
        {"A": "'A' names two things of different facets, surface .16 facets. and element set .4."},
    ),
    "one name, the same facets": (
        BOTTOM.replace("BOTTOM", "FIX") + FIX, {"FIX": 16}, {},
    ),
    "a name that the rest of the boundary would take": (
        BOTTOM + PART.replace("PART", "boundary"), {"BOTTOM": 16, "untagged": 48},
        {"boundary": "node set 'boundary' .* 8 of its 8 facets"},
    ),
    "sets that are no part of the boundary": (
        FIX + "*NSET, NSET=pin\n1\n*NSET, NSET=every, ELSET=ALL\n", {"FIX": 16},
        {"pin": "node set 'pin' is no part of the boundary: it has all vertices of no facet",
         "every": "'every' is no part .* 9 of its 75 vertices lie inside"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", OVERLAPS)
def test_a_tag_is_whole_or_refused_by_its_name(tmp_path, name):
    text, tags, others = OVERLAPS[name]
    found, said = read(tmp_path, text)
    mesh = found.mesh
    assert sizes(mesh) == tags
    assert list(found.notes) == [f"{tmp_path / 'body.inp'}: {note}" for note in said]
    for other, named in others.items():
        # Nor is the reason lost on the way to a solver.
        for each in (mesh, copied(mesh), replace(mesh, spacing=1.0), refined(mesh)):
            with pytest.raises(InputError, match=named) as caught:
                each.face(other)
            assert "body.inp" in str(caught.value)
            assert "\n" not in str(caught.value)
        silent = "no part of the boundary" in str(caught.value)
        assert [f"{other!r} (" in note for note in said] == ([] if silent else [True])


def test_the_cause_of_an_unknown_name_is_still_that(tmp_path):
    mesh = read(tmp_path, FIX)[0].mesh
    with pytest.raises(InputError, match=r"tag 'other' is unknown .* \['FIX', 'boundary'\]"):
        mesh.face("other")


def test_a_note_names_some_of_many(tmp_path):
    more = "".join(FIX.replace("=FIX", f"=N{k}") for k in range(12))
    found, said = read(tmp_path, more)
    assert sizes(found.mesh) == {"N0": 16}
    assert len(found.mesh.unusable) == 11
    assert len(said) == 1
    assert said[0].endswith("'N6' ('N0') and 5 more")


#: The exposed faces of elements: what a line of a surface without a face means.
EXPOSED = {
    "of the whole body": ("ALL,", 64),
    "without a comma": ("ALL", 64),
    "of a set that other elements cover": ("B,", 16 + 16),
    "of one element at a corner": ("1,", 3),
    "of a set, and a face that is named": ("B,\n1, S1", 32),
}


@pytest.mark.parametrize("name", EXPOSED)
def test_a_surface_without_faces_is_that_of_the_exposed_ones(tmp_path, name):
    line, count = EXPOSED[name]
    below = f"*ELSET, ELSET=B\n{rows(BELOW)}"
    mesh = read(tmp_path, f"{below}*SURFACE, NAME=A\n{line}\n")[0].mesh
    assert sizes(mesh) == {"A": count}
    shells = f"*ELEMENT, TYPE=S4, ELSET=SKIN\n{table(QUADS, 901)}*SURFACE, NAME=A\nSKIN,\n"
    assert sizes(read(tmp_path, shells)[0].mesh)["A"] == 16
