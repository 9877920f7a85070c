"""Pictures of bodies: what faces the viewer, what hides what, and the colour it has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from sphsolid.errors import InputError
from sphsolid.look import surface
from sphsolid.look.surface import Surface, seen_faces
from sphsolid.look.view import Around, angled_view, flat_view
from tests.oracles.frames import box_shot, horseshoe, twisted

PLAIN = Surface(lines=0.0, shading=0.0, detail=20000)


def picture(shot, view, drawing, scale, *, pixels=400, name="pressure"):
    """The drawing alone, ``pixels`` high; gives RGB and the position of pixel centres [m]."""
    window = Around().of([shot.x], view)
    size = (window.width / window.height, 1.0)
    figure = Figure(figsize=size, dpi=pixels)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    (left, right), (bottom, top) = window.limits(view.project(shot.x))
    axes.set(xlim=(left, right), ylim=(bottom, top))
    drawing.draw(axes, shot, view, scale, name)
    canvas.draw()
    rgb = np.asarray(canvas.buffer_rgba())[..., :3].astype(float) / 255.0
    height, width = rgb.shape[:2]
    across = left + (np.arange(width) + 0.5) / width * (right - left)
    upward = top - (np.arange(height) + 0.5) / height * (top - bottom)
    return rgb, across, upward


def test_a_cube_shows_the_three_faces_it_turns_to_the_viewer():
    shot = box_shot(spacing=0.25)
    for up in "xyz":
        view = angled_view(up=up, azimuth=25.0, elevation=30.0)
        faces = seen_faces(shot, view, shot.value("pressure").astype(float), pieces=2)
        assert len(faces.loops) == 3 * 16
        assert len(faces.corners) == 4 * 3 * 16
        # Positive area (counter-clockwise) of all, and together the area of the silhouette.
        a = faces.corners[:, 2, :2] - faces.corners[:, 0, :2]
        b = faces.corners[:, 3, :2] - faces.corners[:, 1, :2]
        area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        assert np.all(area > 0.0)
        assert area.sum() == pytest.approx(np.abs(view.rotation[2]).sum(), rel=1e-6)
        outward = np.unique(np.round(faces.normals @ np.array(view.rotation), 6), axis=0)
        np.testing.assert_allclose(outward, np.eye(3)[::-1] * np.sign(view.rotation[2]), atol=1e-6)


def test_faces_that_look_away_are_left_out_whichever_way_the_body_is_turned():
    shot = box_shot(spacing=0.5)
    inside_out = box_shot(spacing=0.5, move=lambda X: X * [-1.0, 1.0, 1.0])
    view = flat_view()
    values = shot.value("pressure").astype(float)
    front = seen_faces(shot, view, values)
    assert np.all(front.corners[..., 2] == pytest.approx(0.0)), "the face Y = 0 is nearest"
    back = seen_faces(inside_out, view, values)
    assert np.all(back.corners[..., 2] == pytest.approx(-1.0)), "a mirrored body shows its back"


def depth_seen(shot, view, across, upward):
    """Nearest depth under every pixel, by brute force: no sorting, no culling."""
    n = 60
    cut = (np.arange(n) + 0.5) / n
    points = surface._bilinear(view.project(shot.x[shot.quads]), cut).reshape(-1, 3)
    column = np.rint((points[:, 0] - across[0]) / (across[1] - across[0])).astype(int)
    row = np.rint((points[:, 1] - upward[0]) / (upward[1] - upward[0])).astype(int)
    depth = np.full((len(upward), len(across)), -np.inf)
    np.maximum.at(depth, (row, column), points[:, 2])
    return depth


def share_of_wrong_pixels(move, view):
    """Depth drawn as colour, against brute force."""
    towards = np.array(view.rotation[2])
    shot = box_shot(
        (-0.5, 0.0, -0.5), (0.5, 6.0, 0.5), spacing=0.25, move=move, field=lambda x: x @ towards
    )
    span = np.ptp(shot.value("pressure"))
    low = shot.value("pressure").min()
    rgb, across, upward = picture(
        shot, view, PLAIN, ScalarMappable(Normalize(low, low + span), "gray"), pixels=200
    )
    depth = depth_seen(shot, view, across, upward)
    body = np.isfinite(depth)
    # Away from outlines, where a pixel is half one face and half another.
    for axis in (0, 1):
        for step in (-1, 1):
            near = np.roll(depth, step, axis=axis)
            jump = np.abs(np.where(np.isfinite(near), near, 1e9) - np.where(body, depth, 0.0))
            body &= jump < 0.02 * span
    assert body.sum() > 3000
    drawn = low + span * rgb.mean(axis=2)
    return float(np.mean(np.abs(drawn - depth)[body] > 0.06 * span))


def test_the_nearest_face_is_the_one_seen(monkeypatch):
    """On a column twisted by a whole turn, and on a horseshoe whose one arm hides the other."""
    behind = angled_view(up="z", azimuth=20.0, elevation=15.0)
    assert share_of_wrong_pixels(twisted(1.05), angled_view(up="y")) < 2e-3
    assert share_of_wrong_pixels(horseshoe(0.8), behind) < 2e-3
    # Planted: painted from near to far.
    argsort = np.argsort
    monkeypatch.setattr(surface.np, "argsort", lambda a, **k: argsort(-np.asarray(a), **k))
    assert share_of_wrong_pixels(horseshoe(0.8), behind) > 0.1


def test_a_linear_field_has_exactly_its_colours():
    slope = np.array([2.0, -1.0, 0.5])
    shot = box_shot(spacing=0.25, field=lambda x: x @ slope)
    view = angled_view(up="z", azimuth=30.0, elevation=35.0)
    faces = seen_faces(shot, view, shot.value("pressure").astype(float), pieces=3)
    centres = faces.corners.mean(axis=1) @ np.array(view.rotation)
    np.testing.assert_allclose(faces.values, centres @ slope, atol=1e-6)

    scale = ScalarMappable(Normalize(-1.0, 2.5), "gray")
    shot = box_shot(spacing=0.25, field=lambda x: 2.0 * x[:, 0] - 0.5 * x[:, 2])
    rgb, across, upward = picture(shot, flat_view(), PLAIN, scale)
    inside = rgb[10:-10:13, 10:-10:13].mean(axis=2) < 1.0
    field = 2.0 * across[None, 10:-10:13] - 0.5 * upward[10:-10:13, None]
    drawn = -1.0 + 3.5 * rgb[10:-10:13, 10:-10:13].mean(axis=2)
    within = inside & (np.abs(across[None, 10:-10:13] - 0.5) < 0.49)
    within &= np.abs(upward[10:-10:13, None] - 0.5) < 0.49
    assert within.sum() > 500
    # A piece of 1/32 m has one colour: half of it, and half a grey, is what there may be between.
    assert np.abs(drawn - field)[within].max() < 2.5 / 64 + 3.5 / 255


def test_shading_darkens_and_never_colours():
    shot = box_shot(field=lambda x: np.zeros(len(x)))
    view = angled_view(up="z", azimuth=30.0, elevation=35.0)
    scale = ScalarMappable(Normalize(-1.0, 1.0), "gray")
    rgb, *_ = picture(shot, view, Surface(lines=0.0, shading=0.3), scale)
    assert np.ptp(rgb, axis=2).max() < 1e-9
    # The flat parts of the picture: white paper and three faces; outlines are a few pixels.
    greys, counts = np.unique(rgb[..., 0], return_counts=True)
    greys = greys[counts > 0.02 * rgb[..., 0].size]
    assert len(greys) == 4
    assert greys[-1] == 1.0
    assert np.all(greys[:-1] <= 0.51)
    assert np.all(greys[:-1] >= 0.5 * 0.7 - 0.01)


def test_lines_are_drawn_once_and_only_where_seen():
    shot = box_shot(spacing=0.5)
    axes = Figure().add_subplot()
    Surface(lines=1.5, detail=1).draw(
        axes, shot, flat_view(), ScalarMappable(Normalize(0, 1), "gray"), "pressure"
    )
    collection = axes.collections[0]
    lines = np.asarray(collection.get_linewidths()) == 1.5
    assert lines.sum() == 12, "a 2 x 2 face has twelve edges"
    assert (~lines).sum() == 4


def test_a_triangle_is_a_quadrilateral_whose_last_corners_are_one():
    shot = box_shot(spacing=0.5, field=lambda x: x @ [2.0, 0.0, -1.0])
    halves = np.concatenate([shot.quads[:, [0, 1, 2, 2]], shot.quads[:, [0, 2, 3, 3]]])
    cut = replace(shot, quads=halves.astype(np.int32))
    view, values = angled_view(up="z", azimuth=25.0), shot.value("pressure").astype(float)
    areas = []
    for each in (shot, cut):
        faces = seen_faces(each, view, values, pieces=4)
        a = faces.corners[:, 2, :2] - faces.corners[:, 0, :2]
        b = faces.corners[:, 3, :2] - faces.corners[:, 1, :2]
        areas.append(0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
        centres = faces.corners.mean(axis=1) @ np.array(view.rotation)
        np.testing.assert_allclose(faces.values, centres @ [2.0, 0.0, -1.0], atol=1e-6)
    assert areas[1] == pytest.approx(areas[0], rel=1e-6)
    edges = surface._lines(view.project(cut.x[cut.quads]), 1)
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).min() > 0.1


def test_only_the_faces_that_are_seen_are_needed():
    """What is left draws the same picture."""
    shot = box_shot(spacing=0.25, move=horseshoe(0.8), field=lambda x: x[:, 1])
    view = angled_view(up="z", azimuth=20.0, elevation=15.0)
    seen = seen_faces(shot, view, np.zeros(len(shot.x))).seen
    less = shot.only(seen, ["pressure"])
    assert len(less.quads) == seen.sum() < 0.6 * len(shot.quads)
    assert less.x.dtype == less.V.dtype == less.value("pressure").dtype == np.float32
    pictures = [
        picture(each, view, Surface(detail=1), ScalarMappable(Normalize(0, 1), "gray"))[0]
        for each in (shot, less)
    ]
    np.testing.assert_array_equal(*pictures)


def test_what_is_not_finite_is_left_out():
    shot = box_shot(spacing=0.5)
    shot.x[0] = np.nan
    values = shot.value("pressure").astype(float)
    faces = seen_faces(shot, flat_view(), values)
    assert len(faces.corners) == 3
    assert np.isfinite(faces.corners).all()


def test_wrong_options_are_refused():
    for make in (
        lambda: Surface(detail=0),
        lambda: Surface(shading=1.5),
        lambda: Surface(lines=-1.0),
        lambda: box_shot().value("temperature"),
    ):
        with pytest.raises(InputError):
            make()
