"""Legal and illegal spellings of one body in Abaqus: each is read right, or refused by its name."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile
from sphsolid.geometry.integrals import area_vectors

#: Eight cubes of edge 1/2 in the cube of edge 1; nodes and elements count from one.
MESH = Box().mesh(0.5)
CENTRE = MESH.vertices[MESH.cells].mean(axis=1)
RIGHT = (1 + np.flatnonzero(CENTRE[:, 0] > 0.5)).tolist()
END = (1 + np.flatnonzero(MESH.vertices[:, 0] == 1.0)).tolist()


def row(numbers) -> str:
    return ", ".join(str(n) for n in numbers) + "\n"


def nodes(points=MESH.vertices, form="{!r}") -> str:
    return "".join(
        f"{k}, " + ", ".join(form.format(x) for x in point) + "\n"
        for k, point in enumerate(points.tolist(), 1)
    )


def cells(first=1) -> str:
    return "".join(row([k, *(cell + 1)]) for k, cell in enumerate(MESH.cells, first))


FLAT = f"*NODE\n{nodes()}*ELEMENT, TYPE=C3D8\n{cells()}"
SET = f"*ELSET, ELSET=right\n{row(RIGHT)}"
SURFACE = "*SURFACE, NAME=end\nright, S4\n"
TAGGED = FLAT + SET + SURFACE
PART = f"*PART, NAME=P\n{FLAT}{SET}*NSET, NSET=side\n{row(END)}*END PART\n"


def assembly(*lines: str, parts: str = PART) -> str:
    return f"{parts}*ASSEMBLY, NAME=A\n{''.join(lines)}*END ASSEMBLY\n"


ONE = "*INSTANCE, NAME=P-1, PART=P\n*END INSTANCE\n"
#: The part again, two to the right, and once turned by 90 degrees about Z through (5, 0, 0).
TWO = "*INSTANCE, NAME=P-2, PART=P\n2.,\n*END INSTANCE\n"
TURNED = "*INSTANCE, NAME=P-3, PART=P\n5.\n5., 0., 0., 5., 0., 1., 90.\n*END INSTANCE\n"

#: Files that are read: what they say, and the tags of the cube with their area vectors.
X_END = (1.0, 0.0, 0.0)
READ: dict[str, tuple[str | bytes, dict[str, tuple]]] = {
    "plain": (TAGGED, {"end": X_END}),
    "lower case": (TAGGED.lower(), {"end": X_END}),
    "mixed case": (TAGGED.title(), {"End": X_END}),
    "tabs and blanks": (TAGGED.replace(", ", "\t,\t ").replace("*", "  *"), {"end": X_END}),
    "CRLF": (TAGGED.replace("\n", "\r\n").encode(), {"end": X_END}),
    "lines that end with CR": (TAGGED.replace("\n", "\r").encode(), {"end": X_END}),
    "byte order mark": (b"\xef\xbb\xbf" + TAGGED.encode(), {"end": X_END}),
    "UTF-16": (TAGGED.encode("utf-16"), {"end": X_END}),
    "a name in Latin-1": (TAGGED.replace("end", "Fläche").encode("latin-1"), {"Fläche": X_END}),
    "a comment in Latin-1": (b"** Pr\xfcfung\n" + TAGGED.encode(), {"end": X_END}),
    "comments within data": (
        TAGGED.replace("\n2, ", "\n** 2, 9, 9, 9\n2, ").replace("*SURFACE", "**\n\n*SURFACE"),
        {"end": X_END},
    ),
    "no last line break after elements": (FLAT.rstrip("\n"), {}),
    "no last line break after a surface": (TAGGED.rstrip("\n"), {"end": X_END}),
    "no last line break after a step": (TAGGED + "*STEP\n*STATIC\n*END STEP", {"end": X_END}),
    "Fortran exponents": (TAGGED.replace("0.5", "5.0D-01").replace("1.0\n", "0.1d1\n"),
                          {"end": X_END}),
    "a blank coordinate": (TAGGED.replace("0.0", " "), {"end": X_END}),
    "directions of a normal": (TAGGED.replace("\n27, 1.0, 1.0, 1.0\n",
                                              "\n27, 1.0, 1.0, 1.0, 0., 0., 1.\n"), {"end": X_END}),
    "cylindrical": (
        TAGGED.replace("*NODE\n", "*NODE, SYSTEM=C\n").replace(
            nodes(),
            nodes(np.stack([np.hypot(*MESH.vertices[:, :2].T),
                            np.degrees(np.arctan2(*MESH.vertices[:, 1::-1].T)),
                            MESH.vertices[:, 2]], axis=1)),
        ),
        {"end": X_END},
    ),
    "Cartesian, said": (TAGGED.replace("*NODE\n", "*NODE, SYSTEM=R, NSET=all\n"), {"end": X_END}),
    "a set before its members": (SURFACE + SET + FLAT, {"end": X_END}),
    "GENERATE": (
        FLAT + "*ELSET, ELSET=right, GENERATE\n5, 8, 1\n" + SURFACE, {"end": X_END}
    ),
    "GEN, without a step": (FLAT + "*ELSET, ELSET=right, GEN\n5, 8\n" + SURFACE, {"end": X_END}),
    "sets of sets": (
        FLAT + "*ELSET, ELSET=right\nlow, 7\nhigh\n*ELSET, ELSET=low\n5, 6\n*ELSET, ELSET=high\n8\n"
        + SURFACE, {"end": X_END},
    ),
    "a set in parts": (FLAT + "*ELSET, ELSET=right\n5,6,\n*Elset, elset=RIGHT\n7,\n8\n" + SURFACE,
                       {"end": X_END}),
    "a surface of single elements": (
        FLAT + "*SURFACE, NAME=end\n5, S4\n6, S4\n7, S4\n8, S4\n", {"end": X_END}
    ),
    "a name with a comma in quotes": (
        TAGGED.replace("=right", '="far, right"').replace("\nright,", '\n"far, right",'),
        {"end": X_END},
    ),
    "a keyword that goes on": (TAGGED.replace("*SURFACE, ", "*SURFACE,\n** so\nTYPE=ELEMENT, "),
                               {"end": X_END}),
    "a comma at the end of a keyword": (
        TAGGED.replace("NAME=end", "NAME=end,\n*STEP,\n*SURFACE, NAME=end"), {"end": X_END}
    ),
    "axes of their own, left again": (TAGGED.replace("*NODE\n", "*SYSTEM\n*NODE\n"),
                                      {"end": X_END}),
    "elements over two lines": (
        TAGGED.replace(cells(), "".join(row([k, *(c[:5] + 1)])[:-1] + ",\n" + row(c[5:] + 1)
                                        for k, c in enumerate(MESH.cells, 1))), {"end": X_END},
    ),
    "a surface of nodes": (FLAT + f"*NSET, NSET=n\n{row(END[:4])}"
                           f"*SURFACE, TYPE=NODE, NAME=end\nn, 1.\n"
                           + "".join(f"{n},\n" for n in END[4:]), {"end": X_END}),
    "nodes of elements": (
        FLAT + "*NSET, NSET=end, ELSET=skin\n*ELEMENT, TYPE=SFM3D4, ELSET=skin\n"
        + "".join(row([50 + k, *(q + 1)]) for k, q in enumerate(MESH.faces["X+"])),
        {"skin": X_END},
    ),
    "materials, steps and output": (
        TAGGED + "*SOLID SECTION, ELSET=right, MATERIAL=rubber\n1.,\n*MATERIAL, NAME=rubber\n"
        "*HYPERELASTIC, NEO HOOKE\n1., 0.\n*DENSITY\n1100.,\n*TRANSFORM, NSET=n\n1,0,0,0,1,0\n"
        "*STEP, NAME=pull\n*DYNAMIC, EXPLICIT\n, 1.\n*BOUNDARY\n1, 1, 3\n*DSLOAD\nend, P, 1.\n"
        "*OUTPUT, FIELD\n*NODE OUTPUT\nU, V\n*ElementOutput\nS\n*END STEP\n", {"end": X_END},
    ),
    "contact that comes and goes": (
        TAGGED + "*STEP\n*MODEL CHANGE, TYPE=CONTACT PAIR, REMOVE\na, b\n"
        "*ModelChange, type=contact pair, add\na, b\n*END STEP\n", {"end": X_END},
    ),
    "steps of CalculiX": (
        TAGGED + "*STEP\n*CHANGE SOLID SECTION, ELSET=right, MATERIAL=m\n*CHANGE CONTACT TYPE, "
        "TO MASSLESS\n*CRACK PROPAGATION\n*FACE PRINT, SURFACE=end\n*CFD\n*BOUNDARYF\n"
        "*TRANSFORMF\n*ROBUST DESIGN\n*GREEN\n*END STEP\n", {"end": X_END},
    ),
    "a part and one instance": (assembly(ONE), {"side": X_END}),
    "a surface of P-1.right": (assembly(ONE, SURFACE.replace("right", "P-1.right")),
                               {"end": X_END}),
    "a surface of A.P-1.right": (assembly(ONE, SURFACE.replace("right", "A.P-1.right")),
                                 {"end": X_END}),
    "a set of an instance": (
        assembly(ONE, SET.replace("right", "right, INSTANCE=P-1, INTERNAL"), SURFACE),
        {"end": X_END},
    ),
    "elements P-1.5 to P-1.8": (
        assembly(ONE, "*SURFACE, NAME=end\n", *(f"P-1.{k}, S4\n" for k in RIGHT)), {"end": X_END}
    ),
    "a reference point": (
        assembly(ONE, "*NODE\n1, 2., 0.5, 0.5\n*NSET, NSET=RP\n1\n"), {"side": X_END}
    ),
    "a mesh in its instance": (
        f"*PART, NAME=P\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=P\n{TAGGED}"
        "*END INSTANCE\n*END ASSEMBLY\n", {"end": X_END},
    ),
    "a part alone": (PART, {"side": X_END}),
    "an instance that is moved": (assembly(ONE.replace("=P\n", "=P\n5., -3., .5\n")),
                                  {"side": X_END}),
    "an instance that is turned": (
        assembly(ONE.replace("=P\n", "=P\n, ,\n0, 0, 0, 0, 0, 2, 90.\n")),
        {"side": (0.0, 1.0, 0.0)},
    ),
}  # fmt: skip


def write(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "body.inp"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


@pytest.mark.parametrize("name", READ)
def test_it_is_read_right(tmp_path, name):
    text, tags = READ[name]
    mesh = MeshFile(write(tmp_path, text)).read().mesh
    assert len(mesh.cells) == 8
    assert MeshFile(tmp_path / "body.inp").volume == pytest.approx(1.0, rel=1e-14)
    assert set(mesh.faces) == {*tags, "boundary"}
    for tag, vector in tags.items():
        assert len(mesh.faces[tag]) == 4
        area = area_vectors(mesh, mesh.faces[tag]).sum(axis=0)
        np.testing.assert_allclose(area, vector, atol=1e-14)


#: What is said of a number that 64 bits do not hold, and of one that Python itself does not read.
TOO_LARGE = (r"the number 9+ is too large; they go up to 9223372036854775807", "digits")

#: Files that are refused: what they say, and what must be said of them.
REFUSED: dict[str, tuple[str | bytes, str]] = {
    "nodes of another file": (
        TAGGED.replace("*NODE", "*NODE, INPUT=n.txt"), r"\*NODE: INPUT=n.txt is not .* put the l"
    ),
    "elements of another file": (
        TAGGED.replace("C3D8", "C3D8, INPUT=e.txt"), r"\*ELEMENT: INPUT=e.txt is not .* put the l"
    ),
    "a system there is not": (
        TAGGED.replace("*NODE", "*NODE, SYSTEM=T"), r"\*NODE: SYSTEM=T is not read .*CYLINDRICAL"
    ),
    "a parameter of the nodes": (
        TAGGED.replace("*NODE", "*NODE, SCALE=2"), r"\*NODE: its parameter SCALE=2 .* NSET, SYSTEM"
    ),
    "an offset of the elements": (
        TAGGED.replace("C3D8", "C3D8, OFFSET=9"), r"\*ELEMENT: OFFSET=9 is not followed"
    ),
    "a surface made of others": (
        TAGGED + "*SURFACE, NAME=b, COMBINE=UNION\nend\n", r"\*SURFACE: COMBINE=UNION is not .*list"
    ),
    "an analytical surface": (
        TAGGED + "*SURFACE, TYPE=CYLINDER, NAME=b\n", r"\*SURFACE: TYPE=CYLINDER is not read here"
    ),
    "a surface of edges": (
        FLAT + "*ELEMENT, TYPE=S4, ELSET=s\n" + row([9, *(MESH.faces["X+"][0] + 1)])
        + "*SURFACE, NAME=b\ns, E1\n", "'E1' are edges of surface elements",
    ),
    "a set without its name": (TAGGED + "*NSET\n1, 2\n", r"\*NSET: its parameters do not say NSET"),
    "a type without its name": (
        TAGGED.replace("*ELEMENT, TYPE=C3D8", "*ELEMENT"), r"\*ELEMENT: its .* do not say TYPE"
    ),
    "a slip in a keyword": (TAGGED + "*ELSETT, ELSET=a\n1\n", r"\*ELSETT: this is no keyword"),
    **{
        keyword: (TAGGED + f"*{keyword}\n1, 2\n", rf"\*{keyword}: .*; write the mesh as one flat f")
        for keyword in ("NGEN", "NFILL, NSET=a", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM",
                        "INCLUDE, INPUT=a.inp", "IMPERFECTION, FILE=a", "IMPORT", "ADJUST",
                        "SYMMETRIC MODEL GENERATION")
    },
    "parameters": (TAGGED + "*PARAMETER\na = 1\n", r"\*PARAMETER: .* write them out"),
    "elements taken out in a step": (
        TAGGED + "*STEP\n*MODEL CHANGE, REMOVE\nright\n", r"\*MODEL CHANGE: it takes elements out"
    ),
    **{
        f"elements {kind}": (
            TAGGED + f"*ELEMENT, TYPE={kind}\n90, 1, 2, 3, 4, 5, 6, 7, 8\n",
            rf"1 lines of elements of type {kind} \({what}.*\) are not read: ",
        )
        for kind, what in (("COH3D8", "cohesive"), ("C3D6", "wedges"), ("C3D5", "pyramids"),
                           ("SC8R", "continuum shells"), ("CIN3D8", "infinite"), ("B31", "beams"),
                           ("AC3D8", "acoustic"), ("EC3D8R", "Eulerian"), ("CAX4R", "elements of"),
                           ("GK3D8", "gasket"), ("U1", "user elements"))
    },
    "a shell of its own": (
        TAGGED.replace("*ELEMENT", "28, 3, 0, 0\n*ELEMENT") + "*ELEMENT, TYPE=S3R\n90, 1, 2, 28\n",
        "1 elements S3R are no facets of the solid body: shells",
    ),
    "a plane model": (
        "*NODE\n1,0,0,\n2,1,0,\n3,0,1,\n*ELEMENT, TYPE=CPE3\n1,1,2,3\n", "no cells of a volume .1 t"
    ),
    "elements of order three": (
        FLAT.replace("TYPE=C3D8", "TYPE=C3D4"),
        "C3D4 need 4 nodes and element 1 has 8; elements of an order above two .* order 1 or 2",
    ),
    "surface elements of order three": (
        FLAT + "*ELEMENT, TYPE=CPS4\n" + row([50, *range(1, 17)]),
        "CPS4 need 4 nodes and element 50 has 16; elements of an order above two",
    ),
    "an element whose line goes on too far": (
        FLAT + "*ELEMENT, TYPE=C3D8\n50, 1, 2, 3, 4,\n5, 6, 7, 8, 9, 10\n",
        "C3D8 need 8 nodes and element 50 has 10",
    ),
    "a node that there is not": (
        FLAT.replace("\n27, 1.0, 1.0, 1.0\n", "\n"),
        r"line 28, \*ELEMENT: elements use 1 nodes .* node 27 of element \d+: add it to the",
    ),
    "elements that come and go": (
        TAGGED + "*STEP\n*MODEL CHANGE, TYPE=ELEMENT, REMOVE\nright\n", r"\*MODEL CHANGE: it takes"
    ),
    "a superscript for a number": (FLAT + "*NSET, NSET=a\n1, ²\n", "set '²' is not defined"),
    "digits of another script": (FLAT.replace("\n10, ", "\n١٠, "), "not a number: '١٠'"),
    "a number that is missing": (
        FLAT.replace("\n1, 1, ", "\n1, ", 1), "C3D8 need 8 nodes and element 1 has 7; complete it"
    ),
    "two elements that make up for each other": (
        FLAT.replace(row([1, *(MESH.cells[0] + 1)]), row([1, *(MESH.cells[0, :7] + 1)])).replace(
            row([2, *(MESH.cells[1] + 1)]), row([2, *(MESH.cells[1] + 1), 27])
        ), "C3D8 need 8 nodes and element 1 has 7",
    ),
    "an underscore": (FLAT.replace("\n10, ", "\n1_0, "), "not a number: '1_0'"),
    "a set of itself": (
        TAGGED + "*ELSET, ELSET=a\nb\n*ELSET, ELSET=b\na\n", "the set 'a' contains itself"
    ),
    "a set of a part that there is not": (
        assembly(ONE, SURFACE.replace("right", "P-2.right")), "'P-2.right' is not def.*'P-1.right'"
    ),
    "an instance of no part": (
        assembly(ONE.replace("PART=P", "PART=Q")), r"\*INSTANCE: there is no part 'Q'; .*\['P'\]"
    ),
    "an instance of a library": (
        assembly(ONE.replace("=P\n", "=P, LIBRARY=old\n")), r"LIBRARY=old is not followed here"
    ),
    "numbers without their instance": (
        assembly(ONE, SET, SURFACE), "no elements of the assembly, .*; say which INSTANCE="
    ),
    "a mesh in an instance that is moved": (
        f"*PART, NAME=P\n*END PART\n*ASSEMBLY\n*INSTANCE, NAME=P-1, PART=P\n1., 0., 0.\n{FLAT}"
        "*END INSTANCE\n*END ASSEMBLY\n", "has elements of its own and is moved",
    ),
    "two parts without an assembly": (
        PART + PART.replace("NAME=P", "NAME=Q"), "2 parts and no .INSTANCE"
    ),
    "two instances in one place": (
        assembly(ONE, TWO.replace("2.,\n", "")), "pairs of vertices lie on the same point"
    ),
    "an axis of no length": (
        assembly(ONE.replace("=P\n", "=P\n, ,\n1, 0, 0, 1, 0, 0, 90.\n")), "axis of its turn are"
    ),
    "a part without its end": (PART.replace("*END PART\n", ""), r"truncated: \*PART has no \*END"),
    "data before a keyword": ("1, 2\n" + TAGGED, "line 1 stands before the first .KEYWORD"),
    "faces of springs": (
        TAGGED + "*ELEMENT, TYPE=SPRINGA, ELSET=k\n9, 1, 2\n*SURFACE, NAME=b\nk, S1\n",
        "elements without a volume or area have no face 'S1'",
    ),
    "fewer than 27 nodes": (
        TAGGED + "*ELEMENT, TYPE=C3D27\n9, " + row(range(1, 22)), "C3D27 with fewer than 27 nodes"
    ),
    "an end of nothing": (TAGGED + "*END PART\n", "there is nothing open that it ends"),
    "cut in an element": (FLAT[:-4], "is truncated: it ends in the middle of line 37"),
    "cut in a set": (
        FLAT + "*NSET, NSET=n\n1, 2, 1", "line 39, the last one, has no line break, .* cut there"
    ),
    "not a text": (b"*NODE\n\0\1\2\0", "it is no text"),
    "two faces on a line": (
        FLAT + "*SURFACE, NAME=s\n2, S2, 4, S2\n",
        r"line \d+, \*SURFACE: the line '2, S2, 4, S2' has more than an element set and a face; "
        "write one such pair a line",
    ),
    "two faces on a second line": (
        FLAT + "*SURFACE, NAME=s\n1, S2\n2, S2,, 4\n", "the line '2, S2,, 4' has more than"
    ),
    "three nodes on a line of a surface": (
        FLAT + "*SURFACE, NAME=s, TYPE=NODE\n1, 2, 3\n", "'1, 2, 3' has more than a node set and"
    ),
    "two node sets on a line of a surface": (
        FLAT + "*NSET, NSET=a\n1\n*NSET, NSET=b\n2\n*SURFACE, NAME=s, TYPE=NODE\na, b\n",
        "the line 'a, b' has more than a node set and an area",
    ),
    "two nodes on a line": (
        FLAT + "*NODE\n90, 0., 0., 0., 91, 0., 1., 0.\n", r"\*NODE: the line '90, .* write one node"
    ),
    **{
        f"a number of {digits} digits in {where}": (
            text.replace("BIG", "9" * digits),
            rf"line \d+, \*{where.split()[0]}: .*{TOO_LARGE[digits > 4300]}",
        )
        for digits in (19, 20, 300, 5000)
        for where, text in (
            ("NODE", FLAT + "*NODE\nBIG, 0., 0., 0.\n"),
            ("ELEMENT", FLAT + "*ELEMENT, TYPE=C3D8\nBIG, 1, 2, 3, 4, 5, 6, 7, 8\n"),
            ("ELEMENT of a mass", FLAT + "*ELEMENT, TYPE=MASS\nBIG, 1\n"),
            ("NSET", FLAT + "*NSET, NSET=a\n1, BIG\n"),
            ("ELSET", FLAT + "*ELSET, ELSET=a\n1, BIG\n"),
            ("ELSET with GENERATE", FLAT + "*ELSET, ELSET=a, GENERATE\n1, BIG, 1\n"),
            ("SURFACE", FLAT + "*SURFACE, NAME=a\nBIG, S1\n"),
        )
    },
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_by_its_name(tmp_path, name):
    text, named = REFUSED[name]
    with pytest.raises(InputError) as caught:
        MeshFile(write(tmp_path, text)).read()
    said = str(caught.value)
    assert re.search(named.replace(", NSET=a", "").replace(", INPUT=a.inp", "")
                     .replace(", FILE=a", ""), said), said  # fmt: skip
    assert "\n" not in said
    assert ("truncated" in said) == (
        name in ("a part without its end", "cut in an element")
    )


def test_there_are_enough_of_them():
    assert len(READ) >= 40
    assert len(REFUSED) >= 40


def test_a_quarter_of_a_ring_and_an_eighth_of_a_shell(tmp_path):
    """Radii 1 to 2; between longitude 0 and 90 in steps of 45 degrees chords, not arcs."""
    r, a, z = MESH.vertices.T
    for system, last, exact in (("C", z, 1.5 * np.sin(np.pi / 4) * 2), ("S", 60 * z - 30, None)):
        text = FLAT.replace("*NODE\n", f"*NODE, SYSTEM={system}\n").replace(
            nodes(), nodes(np.stack([1 + r, 90 * a, last], axis=1))
        )
        mesh = MeshFile(write(tmp_path, text)).read().mesh
        if exact:
            assert MeshFile(tmp_path / "body.inp").volume == pytest.approx(exact, rel=1e-13)
            X = np.stack([(1 + r) * np.cos(a * np.pi / 2), (1 + r) * np.sin(a * np.pi / 2), z], 1)
        else:
            # Latitude from -30 to 30 degrees, counted from the plane Z = 0.
            flat = (1 + r) * np.cos(np.radians(last))
            X = np.stack([flat * np.cos(a * np.pi / 2), flat * np.sin(a * np.pi / 2),
                          (1 + r) * np.sin(np.radians(last))], axis=1)  # fmt: skip
        np.testing.assert_allclose(mesh.vertices, X, atol=1e-15)


def test_two_instances_keep_their_names_and_places_apart(tmp_path):
    """Sets of a part are ``P-1.side``; a set of the assembly may hold both."""
    both = "*NSET, NSET=both\nP-1.side\n*NSET, NSET=both, INSTANCE=P-2\nside\n"
    text = assembly(ONE, TWO, TURNED, "*SURFACE, NAME=far\nP-3.right, S4\n")
    mesh = MeshFile(write(tmp_path, text)).read().mesh
    assert set(mesh.faces) == {"P-1.side", "P-2.side", "far", "boundary"}
    low, high = (f(mesh.vertices, axis=0) for f in (np.min, np.max))
    np.testing.assert_allclose([low, high], [(0, 0, 0), (5, 1, 1)], atol=1e-14)
    for tag, vector, x in (
        ("P-1.side", (1, 0, 0), 1.0), ("P-2.side", (1, 0, 0), 3.0), ("far", (0, 1, 0), 4.5)
    ):  # fmt: skip
        facets = mesh.faces[tag]
        np.testing.assert_allclose(area_vectors(mesh, facets).sum(axis=0), vector, atol=1e-14)
        assert mesh.vertices[np.unique(facets), 0].mean() == pytest.approx(x)
    # A set that shares facets with a tag is none, and refused when it is asked for.
    with pytest.warns(UserWarning, match=r"'both' \(4 of 8 facets with 'P-1\.side'\)"):
        mesh = MeshFile(write(tmp_path, assembly(ONE, TWO, both))).read().mesh
    with pytest.raises(InputError, match=r"node set 'both' .* it shares 4 of its 8 .*'P-1\.side'"):
        mesh.face("both")
    bare = PART.replace(f"*NSET, NSET=side\n{row(END)}", f"*NSET, NSET=side\n{row([END[0]])}")
    moved = both.replace("P-1.side", "\n".join(f"P-1.{n}" for n in END)).replace(
        "\nside", "\n" + row(END)
    )
    mesh = MeshFile(write(tmp_path, assembly(ONE, TWO, moved, parts=bare))).read().mesh
    assert {tag: len(facets) for tag, facets in mesh.faces.items()} == {"both": 8, "boundary": 40}


def test_a_part_and_the_assembly_may_use_a_name_twice(tmp_path):
    text = assembly(ONE, SURFACE.replace("end", "side").replace("right, S4", "P-1.right, S6"))
    with pytest.raises(InputError, match=r"'side': 4 of its 4 facets .* between two cells"):
        MeshFile(write(tmp_path, text)).read()
    text = text.replace("S6", "S4").replace("NSET=side", "NSET=other")
    assert set(MeshFile(write(tmp_path, text)).read().mesh.faces) == {"side", "boundary"}


def test_what_is_left_out_is_said_once(tmp_path):
    """Masses, springs and ties are not read; the curves that Gmsh writes are no news."""
    more = (
        "*ELEMENT, TYPE=T3D2, ELSET=Line1\n50, 1, 2\n*ELEMENT, TYPE=MASS, ELSET=m\n51, 1\n52, 2\n"
        "*MASS, ELSET=m\n1.,\n*ELEMENT, TYPE=SPRINGA\n53, 1, 2\n*TIE, NAME=t\na, b\n"
    )
    with pytest.warns(UserWarning, match="not read") as caught:
        found = MeshFile(write(tmp_path, TAGGED + more)).read()
    said = [str(warning.message).split("body.inp: ")[1] for warning in caught]
    assert said == [
        "*TIE is not read: the parts that it joins stay apart",
        "2 elements MASS are not read",
        "1 elements SPRINGA are not read",
    ]
    assert [note.split("body.inp: ")[1] for note in found.notes] == said
    assert set(found.mesh.faces) == {"end", "boundary"}
