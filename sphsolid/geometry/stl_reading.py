"""Triangles out of an STL file, text or binary, with what its solids are called."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require

Array = NDArray[np.float64]
_HEADER = 84
_FACET = np.dtype([("numbers", "<f4", (12,)), ("attribute", "<u2")])
_WAY_OUT = "copy or save it again"
_NUMBER = rb"\s+([-+]?(?:[.\d]|nan|inf)\S*)"
_VERTEX = re.compile(rb"\bvertex" + 3 * _NUMBER, re.I)
_FACET_WORDS = (rb"facet", rb"endfacet")
_SOLID = re.compile(rb"^[ \t]*solid\b([^\n]*)", re.I | re.M)


def read_stl(path: Path) -> list[tuple[str, Array]]:
    """Name and corners ``(n, 3, 3)`` of each solid of the file, in its units.

    Text may be in upper or lower case and names in any encoding.  A binary file has one solid
    without a name.  Its normals and attributes are not read, nor is filling after the last facet.
    Raises ``InputError`` for a file that is cut, facets of more than three corners, and
    a binary file whose number of facets is not what follows.
    """
    data = path.read_bytes()
    if _is_text(data):
        return _solids(path, data)
    require(
        len(data) >= _HEADER,
        f"{path} is not an STL file, or is truncated: {len(data)} bytes, which do not begin with "
        f"solid, are less than the header of a binary file; {_WAY_OUT}",
    )
    (count,) = struct.unpack("<I", data[80:_HEADER])
    held = (len(data) - _HEADER) // _FACET.itemsize
    require(
        held >= count,
        f"{path} is truncated, or no STL file: it says {count} facets and has {held}; {_WAY_OUT}",
    )
    filling = data[_HEADER + count * _FACET.itemsize :]
    require(
        held == count or not filling.strip(b"\0 \r\n"),
        f"{path} says {count} facets, and {len(filling)} bytes follow the last of them, which is "
        f"room for {held - count} more (several binary solids in one file?); save them as one",
    )
    facets = np.frombuffer(data, _FACET, count, _HEADER)
    return [("", facets["numbers"][:, 3:].reshape(-1, 3, 3).astype(np.float64))]


def _is_text(data: bytes) -> bool:
    """Binary files may begin with ``solid``, too: but their length fits, or they have zeros."""
    if data.lstrip(b"\xef\xbb\xbf \t\r\n")[:5].lower() != b"solid":
        return False
    if len(data) >= _HEADER:
        (count,) = struct.unpack("<I", data[80:_HEADER])
        if len(data) == _HEADER + count * _FACET.itemsize:
            return False
    return b"\0" not in data


def _solids(path: Path, data: bytes) -> list[tuple[str, Array]]:
    data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r", b"\n")
    begins = [*_SOLID.finditer(data)]
    stops = [*(match.start() for match in begins[1:]), len(data)]
    found = []
    for match, stop in zip(begins, stops, strict=True):
        name = match.group(1).decode("utf-8", errors="replace").strip()
        if "\N{REPLACEMENT CHARACTER}" in name:
            name = match.group(1).decode("latin-1").strip()
        found.append((name, _corners(path, data[match.end() : stop], name)))
    return found


def _corners(path: Path, text: bytes, name: str) -> Array:
    end = re.search(rb"\bendsolid\b", text, re.I)
    if end is None:
        raise InputError(
            f"{path} is truncated: solid {name!r} of this STL has no endsolid; {_WAY_OUT}"
        )
    body = text[: end.start()]
    facets, ended = (len(re.findall(rb"\b%b\b" % word, body, re.I)) for word in _FACET_WORDS)
    words = _VERTEX.findall(body)
    require(
        len(words) <= 3 * facets,
        f"{path}: solid {name!r} has {len(words)} corners in {facets} facets: facets of more than "
        "three corners are not read; save it with triangles only",
    )
    require(
        facets == ended and len(words) == 3 * facets,
        f"{path} is damaged: solid {name!r} has {facets} facets, {ended} of them with an end, and "
        f"{len(words)} corners of three numbers; {_WAY_OUT}",
    )
    try:
        numbers = [[float(x.lower().replace(b"d", b"e")) for x in row] for row in words]
    except ValueError as error:
        raise InputError(f"{path}: solid {name!r}: a corner is no number ({error})") from error
    return np.array(numbers, dtype=np.float64).reshape(-1, 3, 3)
