"""What the keywords of Abaqus may say here: read, without an effect on the mesh, or refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card
from sphsolid.geometry.abaqus_skipped import NOT_READ_BUT_SAID, SKIPPED


@dataclass(frozen=True)
class Parameters:
    """The parameters of a keyword that is read.

    ``needed`` and ``read`` are followed, ``harmless`` change nothing here, ``refused`` are known
    with a way out.  ``values``: those allowed of a parameter, where not all are.
    """

    needed: tuple[str, ...] = ()
    read: tuple[str, ...] = ()
    harmless: tuple[str, ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def known(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.needed, *self.read, *self.harmless, *self.refused)


_INLINE = "put the lines of that file after this one"
_OF_SETS = ("GENERATE", "INSTANCE")
_IN_SETS = ("INTERNAL", "UNSORTED")
READ: dict[str, Parameters] = {
    "NODE": Parameters(
        read=("NSET", "SYSTEM"),
        refused={"INPUT": _INLINE},
        values={"SYSTEM": ("R", "C", "S", "RECTANGULAR", "CYLINDRICAL", "SPHERICAL")},
    ),
    "ELEMENT": Parameters(
        needed=("TYPE",),
        read=("ELSET",),
        refused={
            "INPUT": _INLINE,
            "FILE": "give the mesh itself, not a substructure",
            "OFFSET": "write out the numbers of the nodes",
        },
    ),
    "NSET": Parameters(needed=("NSET",), read=("ELSET", *_OF_SETS), harmless=_IN_SETS),
    "ELSET": Parameters(needed=("ELSET",), read=_OF_SETS, harmless=_IN_SETS),
    "SURFACE": Parameters(
        needed=("NAME",),
        read=("TYPE",),
        harmless=("INTERNAL", "NO THICK", "NO OFFSET", "SCALE THICK", "MAX RATIO", "PROPERTY"),
        refused={
            "COMBINE": "list the elements and faces of the surface",
            "CROP": "list the elements and faces of the surface",
            "TRIM": "list the elements and faces of the surface",
            "FILLET RADIUS": "remove the analytical surface",
        },
        values={"TYPE": ("ELEMENT", "NODE")},
    ),
    "PART": Parameters(needed=("NAME",)),
    "END PART": Parameters(),
    "ASSEMBLY": Parameters(read=("NAME",)),
    "END ASSEMBLY": Parameters(),
    "INSTANCE": Parameters(
        needed=("NAME", "PART"),
        refused=dict.fromkeys(
            ("LIBRARY", "INSTANCE"), "write the mesh of the earlier analysis into this file"
        ),
    ),
    "END INSTANCE": Parameters(),
}

_FLAT = "write the mesh as one flat file"
_MAKES = f"it makes, moves or fetches nodes or elements, which is not followed here; {_FLAT}"
#: Keywords that change what the body is, and why they are not followed, with the way out.
REFUSED: dict[str, str] = {
    **dict.fromkeys(
        (
            "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "INCLUDE", "MANIFEST",
            "IMPORT", "IMPORT ELSET", "IMPORT NSET", "IMPORT SURFACE", "IMPERFECTION", "ADJUST",
            "SYMMETRIC MODEL GENERATION", "PARTICLE GENERATOR", "PARAMETER SHAPE VARIATION",
            "SUBSTRUCTURE PATH", "MATRIX INPUT", "REFINE MESH",
        ),
        _MAKES,
    ),
    "PARAMETER": "numbers by the name of a parameter are not evaluated; write them out",
    **dict.fromkeys(
        ("MODEL CHANGE", "ACTIVATE ELEMENTS", "ELEMENT PROGRESSIVE ACTIVATION", "REMOVE"),
        "it takes elements out of the body or back into it, which is not followed here; give the "
        "mesh without the elements that are not there",
    ),
    "DISPLAY BODY": "an instance that is only shown is no body; remove it from the file",
}  # fmt: skip


def _bare(keyword: str) -> str:
    """Abaqus does not count the blanks in a keyword."""
    return keyword.replace(" ", "")


_NAMES = {_bare(name): name for name in (*READ, *REFUSED, *SKIPPED, *NOT_READ_BUT_SAID)}


def understood(where: str, card: Card) -> Card | None:
    """The card with the names of its parameters in full, or nothing where it is to be skipped.

    A parameter may be abbreviated to its first letters.  Raises ``InputError`` for a keyword that
    changes the mesh in a way that is not followed, one that is none, a parameter that is missing,
    and parameters and values that are not read.
    """
    name = _NAMES.get(_bare(card.keyword))
    if name is None:
        raise InputError(
            f"{where}: this is no keyword that is known here; correct it, or remove it if it has "
            "nothing to do with the mesh"
        )
    if name == "SYSTEM" and not any(card.words()):
        return None  # back to the axes that there are from the beginning
    if name == "MODEL CHANGE" and _bare(card.given.get("TYPE", "").upper()) == "CONTACTPAIR":
        return None  # no element comes or goes
    if name in REFUSED:
        raise InputError(f"{where}: {REFUSED[name]}")
    if name not in READ:
        return None
    allowed = READ[name]
    given: dict[str, str] = {}
    for key, value in card.given.items():
        full = _in_full(key, allowed)
        shown = f"{key}={value}" if value else key
        if full in allowed.refused:
            raise InputError(f"{where}: {shown} is not followed here; {allowed.refused[full]}")
        if full == "":
            raise InputError(
                f"{where}: its parameter {shown} is not read here; allowed are "
                f"{', '.join((*allowed.needed, *allowed.read)) or 'none'}: {_FLAT} without it"
            )
        values = allowed.values.get(full, (value.upper(),))
        if value.upper() not in values:
            raise InputError(
                f"{where}: {shown} is not read here; allowed are {', '.join(values)}: write it "
                "as one of these, or remove it if it is no part of the body"
            )
        given[full] = value
    missing = [key for key in allowed.needed if not given.get(key)]
    require(not missing, f"{where}: its parameters do not say {', '.join(missing)}; add it")
    return Card(name, given, card.line, card.data)


def _in_full(key: str, allowed: Parameters) -> str:
    if key in allowed.known:
        return key
    begin = [name for name in allowed.known if len(key) >= 3 and name.startswith(key)]
    return begin[0] if len(begin) == 1 else ""
