"""Colour ranges: common, robust, round; and a bar with units."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from sphsolid.errors import InputError
from sphsolid.look.colours import LOOKS, ColourRange, limits
from sphsolid.look.frame import Absent
from tests.oracles.frames import box_shot


def shot(values):
    made = box_shot(spacing=0.1)
    for name in made.values:
        made.values[name][:] = np.resize(np.asarray(values, dtype=np.float32), len(made.x))
    return made


def test_pressure_is_symmetric_and_round():
    found = limits([shot([-2.9e6, 1.0e6]), shot([0.0])])
    assert (found.low, found.high) == (-3.0e6, 3.0e6)
    assert found.beyond == (False, False)
    rgba = found.scale().to_rgba([-1e6, 0.0, 1e6])
    assert rgba[0][2] > rgba[0][0], "compression is blue"
    assert rgba[2][0] > rgba[2][2], "tension is red"
    assert min(rgba[1][:3]) > 0.95, "none is white"


def test_other_fields_have_their_own_middle():
    found = limits([shot([0.97, 1.01])], field="J")
    assert (found.low, found.high) == pytest.approx((0.97, 1.03))
    found = limits([shot([1.0, 7.0e5])], field="von_mises")
    assert (found.low, found.high) == pytest.approx((0.0, 8.0e5))


def test_von_mises_colours_grow_lighter_all_the_way():
    rgba = ColourRange("von_mises", 0.0, 1.0).scale().to_rgba(np.linspace(0, 1, 64))
    assert np.all(np.diff(rgba[:, :3] @ [0.2126, 0.7152, 0.0722]) > 0.0)


def test_a_spike_does_not_wash_out_the_rest():
    values = np.ones(1000)
    values[0] = 1e9
    spiked = limits([shot(values)], percentile=99.0)
    assert spiked.high == 1.0
    assert spiked.beyond == (False, True)
    assert limits([shot(values)], percentile=100.0).high == pytest.approx(1e9)


def test_colours_count_volume_and_not_points():
    """The rims of the faces of a cube: few points, and less of the volume."""
    made = box_shot(spacing=0.1)
    faces = np.isclose(made.x, 0.0, atol=1e-6) | np.isclose(made.x, 1.0)
    rim = faces.sum(axis=1) > 1
    made.values["pressure"][:] = np.where(rim, 5.0, 1.0)
    points, volume = rim.mean(), made.V[rim].sum() / made.V.sum()
    assert volume < 0.6 * points
    between = 100.0 - 50.0 * (points + volume)
    assert limits([made], percentile=between).high == 1.0
    assert limits([made], percentile=100.0 - 90.0 * volume).high == 5.0


def test_means_over_cells_say_so_at_the_bar():
    made = shot([2.0])
    found = limits([made], field="cell_pressure")
    assert found.high == 2.0
    assert "cell means" in found.look.name
    assert found.look.unit == "Pa"


def test_grids_are_looked_into_and_empty_panels_passed_over():
    grid = [[shot([1.0]), Absent("m", 0.0)], [shot([-4.0]), shot([np.nan])]]
    assert limits(grid).high == 4.0


def test_a_body_at_rest_has_a_range():
    assert limits([shot([0.0])]).high == 1.0


def test_what_has_no_range_is_refused():
    for make in (
        lambda: limits([Absent("m", 0.0)]),
        lambda: limits([shot([np.nan])]),
        lambda: limits([shot([1.0])], percentile=0.0),
        lambda: limits([shot([1.0])], field="heat"),
        lambda: ColourRange("pressure", 1.0, 1.0),
    ):
        with pytest.raises(InputError):
            make()


@pytest.mark.parametrize(
    ("field", "low", "high", "unit", "first", "last"),
    [
        ("pressure", -3.0e6, 3.0e6, "[MPa]", "−3", "3"),
        ("pressure", -250.0, 250.0, "[Pa]", "−250", "250"),
        ("von_mises", 0.0, 2.0e5, "[kPa]", "0", "200"),
        ("J", 0.98, 1.02, "[-]", "0.98", "1.02"),
    ],
)
def test_the_bar_says_unit_and_ends(field, low, high, unit, first, last):
    figure = Figure()
    axes = figure.add_axes((0.5, 0.1, 0.1, 0.8))
    ColourRange(field, low, high, (True, False)).draw_bar(figure, axes)
    figure.draw_without_rendering()
    assert axes.get_title(loc="left").endswith(unit)
    texts = [tick.get_text() for tick in axes.get_yticklabels()]
    assert (texts[0], texts[-1], len(texts)) == (first, last, 5)
    assert LOOKS[field].name in axes.get_title(loc="left")


def test_a_field_of_ones_own_goes_from_its_least_to_its_largest_value():
    made = shot([0.0])
    made.values["temperature"] = np.linspace(300.0, 310.0, len(made.x), dtype=np.float32)
    found = limits([made], field="temperature", percentile=100.0)
    assert (found.low, found.high) == pytest.approx((300.0, 310.0))
    made.values["temperature"][:] = 300.0
    found = limits([made], field="temperature")
    assert found.low < 300.0 < found.high
