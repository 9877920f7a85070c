"""STL, OBJ and PLY files: read right, or refused by what they have more."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, Surface

MESH = Box().mesh(0.5)
CORNERS = MESH.vertices[np.concatenate([MESH.boundary[:, [0, 1, 2]], MESH.boundary[:, [0, 2, 3]]])]


def stl_text(name: str = "a", corners: np.ndarray = CORNERS) -> str:
    facets = "".join(
        "  facet normal 0 0 0\n    outer loop\n"
        + "".join(f"      vertex {x:g} {y:g} {z:g}\n" for x, y, z in facet.tolist())
        + "    endloop\n  endfacet\n"
        for facet in corners
    )
    return f"solid {name}\n{facets}endsolid {name}\n"


def stl_binary(header: bytes = b"made here", count: int | None = None) -> bytes:
    facets = b"".join(struct.pack("<12fH", 0, 0, 1, *facet.ravel(), 7) for facet in CORNERS)
    return header.ljust(80) + struct.pack("<I", len(CORNERS) if count is None else count) + facets


TEXT, BINARY = stl_text(), stl_binary()
OTHER = stl_text("second part", CORNERS + np.array([3.0, 0.0, 0.0]))
STL_READ: dict[str, bytes] = {
    "text": TEXT.encode(),
    "upper case": TEXT.upper().encode(),
    "line ends of Windows": TEXT.replace("\n", "\r\n").encode(),
    "line ends of an old Mac": TEXT.replace("\n", "\r").encode(),
    "tabs, and no last line break": TEXT.replace("  ", "\t").rstrip("\n").encode(),
    "a byte order mark": b"\xef\xbb\xbf" + TEXT.encode(),
    "blank lines before it": b"\n  \n" + TEXT.encode(),
    "a name in Latin-1": TEXT.replace("solid a", "solid Gehäuse").encode("latin-1"),
    "a name in UTF-8": TEXT.replace("solid a", "solid Gehäuse").encode(),
    "no name": TEXT.replace("solid a", "solid").encode(),
    "a name like a keyword": TEXT.replace("solid a", "solid facet of vertex").encode(),
    "exponents of Fortran": TEXT.replace("0.5", "5.0D-01").encode(),
    "binary": BINARY,
    "binary that begins with solid": stl_binary(b"solid of a program"),
    "filling after the last facet": BINARY + b"\0" * 3,
    "filling to a block": BINARY + b"\0" * 500,
    "a line break after the last facet": BINARY + b"\r\n",
}


@pytest.mark.parametrize("name", STL_READ)
def test_an_stl_file_is_read_right(tmp_path: Path, name: str) -> None:
    path = tmp_path / "body.stl"
    path.write_bytes(STL_READ[name])
    surface = Surface.read(path)
    assert surface.volume == pytest.approx(1.0, rel=1e-14)
    assert (list(surface.faces), len(surface.triangles)) == (["surface"], 48)


def test_several_solids_name_their_faces(tmp_path: Path) -> None:
    path = tmp_path / "body.stl"
    path.write_text(TEXT + OTHER)
    surface = Surface.read(path, unit="cm")
    assert surface.volume == pytest.approx(2.0e-6, rel=1e-14)
    assert {name: len(face) for name, face in surface.faces.items()} == {"a": 48, "second part": 48}
    assert surface.vertices[surface.faces["second part"], 0].min() == pytest.approx(0.03)
    path.write_text(TEXT.replace("solid a", "solid") + OTHER.replace("solid second part", "solid"))
    assert list(Surface.read(path).faces) == ["surface"]


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (BINARY[:-20], r"is truncated, or no STL file: it says 48 facets and has 47"),
        (BINARY[:60], "less than the header"),
        (b"", "less than the header"),
        (stl_binary(count=40), "says 40 facets, and 400 bytes follow .* room for 8 more"),
        (stl_binary(count=0), "says 0 facets, and 2400 bytes follow"),
        (BINARY + BINARY, "several binary solids in one file"),
        (TEXT[:-12].encode(), "is truncated: solid 'a' of this STL has no endsolid"),
        ((TEXT[:-11] + OTHER).encode(), "is truncated: solid 'a' of this STL has no endsolid"),
        (TEXT.replace("    endloop", "      vertex 0 0 0\n    endloop").encode(),
         "192 corners in 48 facets: facets of more than three corners are not read"),
        (TEXT.replace("      vertex 1 1 1\n", "", 1).encode(), "is damaged: .* 143 corners"),
        (TEXT.replace("1 1 1", "1 1", 1).encode(), "is damaged: .* 143 corners of three numbers"),
        (b"solid a\nendsolid a\n", "holds no triangles"),
    ],
)  # fmt: skip
def test_an_stl_file_is_refused(tmp_path: Path, data: bytes, named: str) -> None:
    path = tmp_path / "body.stl"
    path.write_bytes(data)
    with pytest.raises(InputError, match=named) as caught:
        Surface.read(path)
    assert "\n" not in str(caught.value)


OBJ = (
    "".join(f"v {x} {y} {z}\n" for x, y, z in MESH.vertices.tolist())
    + "".join("f " + " ".join(str(k + 1) for k in quad) + "\n" for quad in MESH.boundary.tolist())
)
BACK = "".join(
    "f " + " ".join(str(k - 27) for k in quad) + "\n" for quad in MESH.boundary.tolist()
)
OBJ_READ = {
    "plain": OBJ,
    "textures and normals": OBJ[: OBJ.index("f ")] + "vt 0 0\nvn 0 0 1\nusemtl m\n" + "".join(
        "f " + " ".join(f"{k + 1}/1/1" for k in quad) + "\n" for quad in MESH.boundary.tolist()
    ),
    "groups and names": "o part\nmtllib a.mtl\n" + OBJ.replace("f ", "g one\ns off\nf ", 1),
    "colours": "".join(
        line + (" 0.5 0.5 0.5" if line.startswith("v") else "") + "\n" for line in OBJ.splitlines()
    ),
    "weights": "".join(
        line + (" 1.0" if line.startswith("v") else "") + "\n" for line in OBJ.splitlines()
    ),
    "counted from the end": OBJ[: OBJ.index("f ")] + BACK,
    "lines that go on": OBJ.replace("f ", "f \\\n"),
    "line ends of Windows": OBJ.replace("\n", "\r\n").replace("f ", "f \\\r\n"),
    "a byte order mark": "\ufeff" + OBJ,
    "a byte order mark, facets counted from the end": "\ufeff" + OBJ[: OBJ.index("f ")] + BACK,
    "comments": "# made here\n" + OBJ.replace("f ", "# next\nf ").replace("\nv", " # one\nv"),
}


@pytest.mark.parametrize("name", OBJ_READ)
def test_an_obj_file_is_read_right(tmp_path: Path, name: str) -> None:
    path = tmp_path / "body.obj"
    path.write_bytes(OBJ_READ[name].encode())
    surface = Surface.read(path)
    assert surface.volume == pytest.approx(1.0, rel=1e-14)
    assert len(surface.triangles) == 48


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (OBJ + "f 1 2 3 4 5\n", "line 52: facets of 5 corners are not read"),
        (OBJ + "f 1 2 99\n", "use vertices that the file does not have; it has 27"),
        (OBJ + "f 0 1 2\n", "line 52: vertex 0: OBJ counts from one"),
        (OBJ + "cstype bezier\n", "curved surfaces .cstype. are not read"),
        (OBJ + "v 1 2\n", "a vertex needs three coordinates"),
        (OBJ + "v 1 2 three\n", "'v 1 2 three' cannot be read"),
        (OBJ.replace("v", "v\0"), "is no text, or in UTF-16; save it as UTF-8"),
    ],
)
def test_an_obj_file_is_refused(tmp_path: Path, text: str, named: str) -> None:
    path = tmp_path / "body.obj"
    path.write_text(text)
    with pytest.raises(InputError, match=named):
        Surface.read(path)


def test_a_ply_file_with_a_byte_order_mark_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "body.ply"
    path.write_bytes(b"\xef\xbb\xbfply\nformat ascii 1.0\nend_header\n")
    with pytest.raises(InputError, match=r"begins with a byte order mark, .* save it without"):
        Surface.read(path)


def test_a_ply_file_of_polygons_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "body.ply"
    head = (
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_text(head + "0 0 0\n1 0 0\n1 1 0\n0.5 2 0\n0 1 0\n5 0 1 2 3 4\n")
    with pytest.raises(InputError, match=r"facets of kind polygon5?; save .* triangles only"):
        Surface.read(path)
