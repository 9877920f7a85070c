"""Tables of points: read right, or refused by what kind of table they are."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry.point_file import read_points

POINTS = np.array([[0.5, 1.0, -2.0], [1e-3, 0.0, 7.25]])
COMMAS = "0.5,1.0,-2.0\n0.001,0,7.25\n"
READ: dict[str, tuple[str, bytes]] = {
    "commas": ("a.csv", COMMAS.encode()),
    "blanks": ("a.txt", COMMAS.replace(",", "  ").encode()),
    "tabs": ("a.xyz", COMMAS.replace(",", "\t").encode()),
    "line ends of Windows": ("a.csv", COMMAS.replace("\n", "\r\n").encode()),
    "no last line break": ("a.csv", COMMAS.rstrip("\n").encode()),
    "a byte order mark": ("a.csv", b"\xef\xbb\xbfx,y,z\n" + COMMAS.encode()),
    "a comment in Latin-1": ("a.csv", b"# L\xe4nge\n" + COMMAS.encode()),
    "names in another order": (
        "a.csv", b"id,Z,y,X\n1,-2.0,1.0,0.5\n2,7.25,0,0.001\n"
    ),
    "names in quotes": ("a.csv", b'"x","y","z"\n' + COMMAS.encode()),
    "names of ParaView": (
        "a.csv", b'"T","Points:0","Points:1","Points:2"\n9,0.5,1.0,-2.0\n9,0.001,0,7.25\n'
    ),
    "exponents of Fortran": ("a.txt", b"5.0D-01 1.0d0 -0.2D+01\n1.D-03 0 7.25\n"),
    "numbers in quotes": ("a.csv", b'"0.5","1.0","-2.0"\n"0.001","0","7.25"\n'),
    "blank lines": ("a.csv", b"\n" + COMMAS.replace("\n", "\n\n").encode()),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_a_table_is_read_right(tmp_path: Path, name: str) -> None:
    file, data = READ[name]
    (tmp_path / file).write_bytes(data)
    np.testing.assert_allclose(read_points(tmp_path / file), POINTS, rtol=1e-15)


REFUSED: dict[str, tuple[str, bytes, str]] = {
    "semicolons": ("a.csv", b"0,5;1,0;-2,0\n", "separated by semicolons .*decimal points"),
    "commas under .txt": ("a.txt", COMMAS.encode(), "separated by commas; name it .csv"),
    "tabs under .csv": ("a.csv", COMMAS.replace(",", "\t").encode(), "by tabs; name it .txt"),
    "atoms": ("a.xyz", b"2\nwater\nO 0 0 0\nH 0 0 1\n", "XYZ file of atoms"),
    "UTF-16": ("a.csv", COMMAS.encode("utf-16"), "UTF-16; save it as UTF-8"),
    "letters": ("a.csv", b"0,0,0\n1,2,three\n", "line 2: '1,2,three'; wanted are 3 numbers"),
    "an underscore": ("a.csv", b"1_0,0,0\n", "line 1: .* wanted are 3 numbers"),
    "a row too short": ("a.csv", b"x,y,z,T\n1,2,3\n", "line 2: .* wanted are 4 numbers"),
    "two names of three": ("a.csv", b"x,y\n1,2\n", "line 1: .* the names x, y, z"),
    "nothing": ("a.csv", b"x,y,z\n", "holds no points"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_table_is_refused_by_its_kind(tmp_path: Path, name: str) -> None:
    file, data, named = REFUSED[name]
    (tmp_path / file).write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_points(tmp_path / file)
    assert re.search(named, str(caught.value)), caught.value
