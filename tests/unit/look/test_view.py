"""Views keep lengths, and look from where they say."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.look.view import Around, angled_view, flat_view


@pytest.mark.parametrize("view", [flat_view(), angled_view(), angled_view(up="z", azimuth=200.0)])
def test_a_view_is_a_rotation(view):
    rows = np.array(view.rotation)
    np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rows) == pytest.approx(1.0)


def test_the_flat_view_looks_along_y_at_the_plane_of_x_and_z():
    view = flat_view()
    np.testing.assert_allclose(view.project([2.0, 3.0, 4.0]), [2.0, 4.0, -3.0])
    assert flat_view(right="x", up="y").rotation[2] == (0.0, 0.0, 1.0)


def test_the_angled_view_stands_where_it_says():
    s = np.sqrt(0.5)
    np.testing.assert_allclose(angled_view(up="z", azimuth=0, elevation=0).rotation[2], [1, 0, 0])
    np.testing.assert_allclose(
        angled_view(up="z", azimuth=90, elevation=45).rotation[2], [0, s, s], atol=1e-15
    )
    np.testing.assert_allclose(
        angled_view(up="y", azimuth=90, elevation=0).rotation[2], [1, 0, 0], atol=1e-15
    )
    for up, axis in (("x", 0), ("y", 1), ("z", 2)):
        right, upward, _ = angled_view(up=up, azimuth=33.0, elevation=20.0).project(np.eye(3)[axis])
        assert right == pytest.approx(0.0)
        assert upward == pytest.approx(np.cos(np.radians(20.0)))


def test_windows_hold_the_bodies():
    still = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 2.0]])
    away = still + np.array([10.0, 0.0, 0.0])
    fixed = Around(margin=0.0).of([still, away], flat_view())
    assert (fixed.width, fixed.height, fixed.centre) == (11.0, 2.0, (5.5, 1.0))
    assert fixed.limits(still) == ((0.0, 11.0), (0.0, 2.0))
    follow = Around(follow=True, margin=0.0).of([still, away], flat_view())
    assert (follow.width, follow.height) == (1.0, 2.0)
    assert follow.limits(flat_view().project(away)) == ((10.0, 11.0), (0.0, 2.0))
    assert Around(margin=0.1).of([still], flat_view()).width == pytest.approx(1.4)
    gone = np.full((2, 3), np.nan)
    assert Around(margin=0.0).of([gone, still], flat_view()).width == 1.0


def test_wrong_views_are_refused():
    for make in (
        lambda: flat_view(right="x", up="x"),
        lambda: flat_view(right="u"),
        lambda: angled_view(elevation=90.0),
        lambda: Around().of([], flat_view()),
        lambda: Around().of([np.full((2, 3), np.nan)], flat_view()),
    ):
        with pytest.raises(InputError):
            make()
