"""Colours of fields: which map, which range, and the bar that says so.

Pressure (positive in tension) and ``J`` have a value that means "nothing": they get a diverging
map, symmetric about it.  Von Mises stress starts from zero and gets a sequential one that is
perceptually uniform.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import FixedLocator, FuncFormatter

from sphsolid.errors import InputError, require
from sphsolid.look.frame import Frame, Shot
from sphsolid.look.percentiles import weighted_percentile
from sphsolid.look.scalars import CELL, scalar


@dataclass(frozen=True)
class FieldLook:
    """How a field is shown: its name, SI unit (empty: a number), colour map and middle value.

    ``middle`` is nan where no value means "nothing": colours go from the least to the largest.
    """

    name: str
    unit: str
    colour_map: str
    middle: float
    diverging: bool


_POINTS = {
    "pressure": FieldLook("pressure,\ntension +", "Pa", "RdBu_r", 0.0, diverging=True),
    "von_mises": FieldLook("von Mises\nstress", "Pa", "viridis", 0.0, diverging=False),
    "J": FieldLook("volume\nratio J", "", "PuOr_r", 1.0, diverging=True),
}
#: Of the values that a method has at the vertices, and of means over cells, which the bar says.
LOOKS = _POINTS | {
    CELL + name: replace(look, name=f"{look.name},\ncell means") for name, look in _POINTS.items()
}
_VECTORS = {
    "u": ("displace-\nment", "m"), "v": ("velocity", "m/s"), "p": ("momentum", "kg/(m²s)"),
}  # fmt: skip
_TENSORS = {"cauchy": ("Cauchy\nstress", "Pa"), "P": ("first Piola\nstress", "Pa"), "F": ("F", "")}
_ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_PREFIX = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (0.0, ""))
_ARROWS = {(False, False): "neither", (True, False): "min", (False, True): "max"}


def look_of(field: str) -> FieldLook:
    """How a field is shown; that of a user's own term under its name alone."""
    if field in LOOKS:
        return LOOKS[field]
    name = field.removeprefix(CELL)
    try:
        what = scalar(name)
    except InputError:
        return FieldLook(name, "", "viridis", math.nan, diverging=False)
    if what.is_size:
        label, unit = _VECTORS[what.base]
        return FieldLook(f"{label}\n|{name}|", unit, "viridis", 0.0, diverging=False)
    component = name.rpartition("_")[2]
    label, unit = (_TENSORS if what.is_of_law else _VECTORS)[what.base]
    middle = 1.0 if what.base == "F" and len(set(component)) == 1 else 0.0
    suffix = ",\ncell means" if field.startswith(CELL) else ""
    return FieldLook(f"{label} {component}{suffix}", unit, "RdBu_r", middle, diverging=True)


@dataclass(frozen=True)
class ColourRange:
    """``field`` from ``low`` to ``high`` (SI); ``beyond``: there are values below, above it."""

    field: str
    low: float
    high: float
    beyond: tuple[bool, bool] = (False, False)

    def __post_init__(self) -> None:
        look_of(self.field)
        require(
            bool(np.isfinite([self.low, self.high]).all()) and self.low < self.high,
            f"colours of {self.field}: the range {self.low} .. {self.high} is empty or not finite",
        )

    @property
    def look(self) -> FieldLook:
        """Name, unit and colour map."""
        return look_of(self.field)

    def scale(self) -> ScalarMappable:
        """Maps values [SI] to colours."""
        return ScalarMappable(Normalize(self.low, self.high), self.look.colour_map)

    def draw_bar(self, figure: Any, axes: Any) -> None:
        """A colour bar in ``axes``, five ticks, unit above; arrows where values go beyond."""
        extend: Any = _ARROWS.get(self.beyond, "both")
        bar = figure.colorbar(self.scale(), cax=axes, extend=extend, extendfrac=0.04)
        factor, unit = 1.0, self.look.unit
        if unit == "Pa":
            size = max(abs(self.low), abs(self.high))
            factor, prefix = next((f or 1.0, p) for f, p in _PREFIX if size >= f)
            unit = prefix + unit
        bar.locator = FixedLocator(np.linspace(self.low, self.high, 5).tolist())
        bar.formatter = FuncFormatter(lambda value, _: f"{value / factor:.4g}".replace("-", "−"))
        bar.update_ticks()
        bar.outline.set_linewidth(0.5)
        axes.tick_params(labelsize=8, width=0.5, length=2.5)
        axes.grid(False)
        title = f"{self.look.name}\n[{unit or '-'}]"
        size = 8.5
        if math.isnan(self.look.middle):
            # A name of a user's own: its unit is not known, and it may be long.
            title, size = self.look.name, min(size, 85.0 / len(self.look.name))
        axes.set_title(title, fontsize=size, loc="left", pad=9)


def limits(
    frames: Iterable[Any], *, field: str = "pressure", percentile: float = 99.0
) -> ColourRange:
    """A common range: ``percentile`` by volume of the pooled values, rounded up to a round number.

    ``frames`` may be nested (rows of a grid); panels without a frame are passed over.  Symmetric
    about the middle for a diverging field, from zero for von Mises, with both ends by percentile
    for a field of a user's own.  Pooling means that one spike, or one corner, does not wash out all
    others.  Raises ``InputError`` for a percentile
    outside (0, 100] or when there is nothing to look at.
    """
    require(0.0 < percentile <= 100.0, f"limits: percentile = {percentile} is outside (0, 100]")
    look = look_of(field)
    shots = [shot for shot in _flat(frames) if isinstance(shot, Shot)]
    pooled = np.concatenate([np.zeros(0), *(shot.value(field).astype(float) for shot in shots)])
    volume = np.concatenate([np.zeros(0), *(shot.V.astype(float) for shot in shots)])
    finite = np.isfinite(pooled)
    pooled, volume = pooled[finite], volume[finite]
    require(len(pooled) > 0, f"limits: no frame has a finite value of {field}")
    if math.isnan(look.middle):
        low, high = weighted_percentile(pooled, volume, [100.0 - percentile, percentile])
        if not low < high:
            low, high = low - 0.5 * abs(low) - 0.5, high + 0.5 * abs(high) + 0.5
        beyond = (bool(pooled.min() < low), bool(pooled.max() > high))
        return ColourRange(field, float(low), float(high), beyond)
    ends = weighted_percentile(np.abs(pooled - look.middle), volume, [percentile])
    size = _round_up(float(ends[0]))
    low = look.middle - size if look.diverging else look.middle
    high, slack = look.middle + size, 1e-6 * size
    beyond = (bool(pooled.min() < low - slack), bool(pooled.max() > high + slack))
    return ColourRange(field, low, high, beyond)


def _flat(frames: Iterable[Any]) -> Iterable[Frame]:
    for item in frames:
        if isinstance(item, Iterable):
            yield from _flat(item)
        else:
            yield item


def _round_up(size: float) -> float:
    if size <= 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(size))
    return float(next((m * power for m in _ROUND if m * power >= size * (1.0 - 1e-9)), 10 * power))
