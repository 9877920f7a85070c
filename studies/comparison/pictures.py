"""Panels of deformed bodies with every method, after Figs. 10, 11 and 15 of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import pandas as pd

from sphsolid.look.colours import ColourRange
from sphsolid.look.frame import Absent
from sphsolid.look.panels import Layout
from sphsolid.look.scalars import CELL
from sphsolid.look.view import flat_view
from studies.comparison.contenders import (
    CLASSICAL,
    CONTROLLED,
    DEFAULT,
    ELEMENTS,
    JSTS,
    LIMITED,
    NODAL,
    PAPERS,
    PETROV,
    PETROV_HEX,
    PLAIN,
    PRINTED,
    QUADRATIC,
    SELF_ADJOINT,
    SHIPPED,
    TOUCH,
    UPWINDS,
    Contender,
)
from studies.comparison.runs import EARLY, column_case, punch_case
from studies.comparison.tables import COLUMN_AT, NU, OMEGA, PUNCH_AT
from studies.engine.results import Tables
from studies.measures.tables import select
from studies.pictures.picture import Panel, Picture, Plan

#: Ends of the colour bars of the punch and of the column [Pa].
PRESSURE, COLUMN_PRESSURE = 4.0e6, 3.0e6

#: Fig. 15, then the methods that the paper does not have.
FIG_15 = (PAPERS, JSTS, PETROV, TOUCH, ELEMENTS, QUADRATIC, DEFAULT, SELF_ADJOINT)
BESIDE_15 = (PRINTED, UPWINDS, LIMITED, CONTROLLED, SHIPPED, CLASSICAL, PLAIN, NODAL)
#: Fig. 10: what a scheme without enough dissipation does to the pressure, over time.
FIG_10 = (CLASSICAL, PLAIN, PAPERS, DEFAULT)
#: Fig. 11, then the others.
FIG_11 = (
    JSTS, PAPERS, PRINTED, DEFAULT, SELF_ADJOINT, UPWINDS, LIMITED, CONTROLLED, SHIPPED, ELEMENTS,
    QUADRATIC, NODAL, PETROV, PETROV_HEX, TOUCH,
)  # fmt: skip
PICTURED = tuple(dict.fromkeys((*FIG_15, *BESIDE_15, *FIG_10, *FIG_11)))


def short(one: Contender) -> str:
    """A name in two lines."""
    words = one.name.replace(" SPH", "").replace("hourglass-controlled", "hourglass control")
    middle = len(words) // 2
    spaces = [k for k, letter in enumerate(words) if letter == " "]
    if not spaces or len(words) < 12:
        return words
    at = min(spaces, key=lambda k: abs(k - middle))
    return f"{words[:at]}\n{words[at + 1 :]}"


def _panel(tables: Tables, case: str, one: Contender, time: float) -> Panel | Absent:
    """The frame of a run, or that there was none."""
    if len(select(tables["runs"], case=case, method=one.name)) == 0:
        return Absent(short(one), time)
    return Panel(short(one), f"{case}: {one.name}", time)


def _columns(shown: Sequence[Contender], tables: Tables) -> Plan:
    runs = select(tables["runs"], omega=OMEGA, nu=NU)
    case = column_case(OMEGA, NU, _cells(runs, COLUMN_AT))
    return [[_panel(tables, case, one, 0.1) for one in shown]]


def _cells(runs: pd.DataFrame, usual: int) -> int:
    """The usual lattice, or the coarsest there is: that of the short form."""
    known = set(runs["cells"].dropna().astype(int))
    return usual if usual in known or not known else min(known)


def _of_punch(tables: Tables) -> str:
    return punch_case(_cells(select(tables["runs"], scene="punch"), PUNCH_AT))


def _punches(tables: Tables) -> Plan:
    case, across = _of_punch(tables), 3
    panels = [_panel(tables, case, one, EARLY[-1]) for one in FIG_11]
    return [panels[k : k + across] for k in range(0, len(panels), across)]


def _evolution(tables: Tables) -> Plan:
    case = _of_punch(tables)
    return [[_panel(tables, case, one, time) for time in EARLY] for one in FIG_10]


_FLAT = flat_view(right="x", up="z")
_COLOURS = ColourRange(CELL + "pressure", -PRESSURE, PRESSURE, (True, True))
_OF_COLUMN = ColourRange(CELL + "pressure", -COLUMN_PRESSURE, COLUMN_PRESSURE, (True, True))
PICTURES = {
    "column": Picture(
        partial(_columns, FIG_15), colours=_OF_COLUMN, layout=Layout(width=9.5, height=5.2)
    ),
    "column_beside": Picture(
        partial(_columns, BESIDE_15), colours=_OF_COLUMN, layout=Layout(width=9.5, height=5.2)
    ),
    "punch": Picture(_punches, CELL + "pressure", _COLOURS, _FLAT, layout=Layout(dpi=120)),
    "punch_evolution": Picture(
        _evolution, "pressure", ColourRange("pressure", -PRESSURE, PRESSURE, (True, True)), _FLAT,
        layout=Layout(dpi=120),
    ),
}  # fmt: skip
