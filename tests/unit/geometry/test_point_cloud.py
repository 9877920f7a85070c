"""Bodies from points and a surface: exact volumes and moments, tags, and clear refusals."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree

from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box, PointCloud, Region, Surface, Tagged, interior_lattice
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.dual_volumes import corner_parts, dual_parts
from sphsolid.geometry.integrals import (
    area_vectors,
    cell_volumes_and_centroids,
    layers_from_boundary,
    vertex_volumes,
)
from sphsolid.geometry.point_mesh import PointMesh, point_mesh
from tests.oracles.surfaces import boundary, cylinder, sphere

L_BLOCK = Blocks((((0, 0, 0), (3, 10, 3)), ((3, 0, 0), (6, 3, 3))))
BOX = Box()


def filled(kind: str, jitter: float) -> tuple[Surface, PointCloud]:
    surface, spacing = {
        "cube": (boundary(BOX, 0.125), 0.125),
        "L": (boundary(L_BLOCK, 0.75), 0.75),
        "ball": (sphere(0.25), 0.2),
        "cylinder": (cylinder(0.25), 0.2),
        "hollow": (hollow(), 0.25),
    }[kind]
    return surface, PointCloud.fill(surface=surface, spacing=spacing, jitter=jitter, seed=3)


def hollow() -> Surface:
    outer, inner = boundary(Box((-1.0,) * 3, (1.0,) * 3), 0.25), sphere(0.5)
    count = len(outer.vertices)
    return Surface.closed(
        vertices=np.concatenate([outer.vertices, 0.5 * inner.vertices]),
        faces={**outer.faces, "hole": inner.triangles + count},
    )


@pytest.mark.parametrize("jitter", [0.0, 0.3])
@pytest.mark.parametrize("kind", ["cube", "L", "ball", "cylinder", "hollow"])
def test_volumes_and_moments_are_those_of_the_surface(kind: str, jitter: float) -> None:
    surface, cloud = filled(kind, jitter)
    mesh = cloud.mesh(AS_MESHED)
    volume, size = surface.volume, np.ptp(surface.vertices)
    assert cloud.volume == volume
    V = vertex_volumes(mesh)
    assert V.min() > 0.05 * mesh.spacing**3
    assert V.sum() == pytest.approx(volume, rel=1e-13)
    np.testing.assert_allclose(
        V @ mesh.vertices, surface.first_moments, rtol=0, atol=1e-13 * volume * size
    )
    areas = area_vectors(mesh, mesh.boundary)
    np.testing.assert_allclose(areas.sum(axis=0), 0.0, atol=1e-13 * size**2)
    np.testing.assert_allclose(
        areas.T @ mesh.vertices, volume * np.eye(3), atol=1e-13 * volume * max(1.0, size)
    )
    cells, centroid = cell_volumes_and_centroids(mesh)
    assert cells.min() > 0.0
    assert cells.sum() == pytest.approx(volume, rel=1e-13)
    np.testing.assert_allclose(
        cells @ centroid, surface.first_moments, rtol=0, atol=1e-13 * volume * size
    )
    assert mesh.largest_change < (1e-5 if kind in ("cube", "L", "cylinder") else 0.01)
    assert sorted(mesh.faces) == sorted(surface.faces)


def test_a_lattice_gets_the_volumes_of_its_hexahedra() -> None:
    """However its cubes are cut into tetrahedra; quarters of those would scatter by 30 %."""
    hexes = BOX.mesh(0.125)
    surface = Surface.closed(vertices=hexes.vertices, faces=hexes.faces)
    mesh = PointCloud(hexes.vertices, surface).mesh(AS_MESHED)
    assert mesh.spacing == pytest.approx(0.125, rel=1e-12)
    _, same = cKDTree(hexes.vertices).query(mesh.vertices)
    expected = vertex_volumes(hexes)[same]
    np.testing.assert_allclose(vertex_volumes(mesh), expected, rtol=1e-10)
    inner = layers_from_boundary(mesh) > 0
    volume = cell_volumes_and_centroids(mesh)[0]
    quarters = np.bincount(mesh.cells.ravel(), weights=np.repeat(volume / 4.0, 4))
    assert np.std(quarters[inner]) > 0.2 * np.mean(quarters[inner])


def test_volumes_of_inner_particles_are_voronoi_s() -> None:
    """Measured by samples: the share of the room that is nearer to a particle than to others."""
    points = Box(jitter=0.5, seed=5).mesh(0.25).vertices
    surface = Surface.closed(vertices=points, faces=BOX.mesh(0.25).faces)
    mesh = PointCloud(points, surface).mesh(AS_MESHED)
    axis = (np.arange(80) + 0.5) / 80
    samples = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    _, owner = cKDTree(mesh.vertices).query(samples)
    share = np.bincount(owner, minlength=len(mesh.vertices)) / len(samples)
    inner = layers_from_boundary(mesh) > 0
    np.testing.assert_allclose(vertex_volumes(mesh)[inner], share[inner], rtol=0.02)


def test_parts_of_a_cell_add_up_and_quarters_replace_bad_ones() -> None:
    random = np.random.default_rng(0)
    points = random.uniform(size=(40, 4, 3)).reshape(-1, 3)
    cells = np.arange(160).reshape(-1, 4)
    corner = points[cells]
    volume = np.linalg.det(corner[:, 1:] - corner[:, :1]) / 6.0
    cells[volume < 0.0] = cells[volume < 0.0][:, [0, 2, 1, 3]]
    np.testing.assert_allclose(dual_parts(points, cells).sum(axis=1), np.abs(volume), rtol=1e-9)
    assert np.any(dual_parts(points, cells) < 0.0)
    parts = corner_parts(points, cells)
    assert np.all(parts >= np.abs(volume)[:, None] / 16.0 * (1.0 - 1e-12))
    regular = np.array([[0.0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]])
    np.testing.assert_allclose(dual_parts(regular, np.array([[0, 2, 1, 3]])), 1.0 / 12.0)


def test_faces_are_the_triangles_of_the_surface_and_can_be_split() -> None:
    surface, cloud = filled("L", 0.0)
    mesh = cloud.mesh(AS_MESHED)
    for name, face in surface.faces.items():
        np.testing.assert_array_equal(mesh.vertices[mesh.face(name)], surface.vertices[face])
    tagged = Tagged(cloud, (Region("tip", "X+", lambda X: X[:, 2] > 1.5),)).mesh(AS_MESHED)
    assert len(tagged.faces["tip"]) + len(tagged.faces["X+"]) == len(surface.faces["X+"])
    np.testing.assert_array_equal(vertex_volumes(tagged), vertex_volumes(mesh))


def test_points_of_the_boundary_layer_are_left_out() -> None:
    """On a vertex, on a triangle, a little outside a chord of the sphere: the surface stands for
    all of them; a point well outside is an error."""
    surface = sphere(0.25)
    inner = interior_lattice(surface=surface, spacing=0.2)
    on = surface.vertices[surface.triangles].mean(axis=1)
    on /= np.linalg.norm(on, axis=1)[:, None]
    assert not np.any(surface.contains(on))
    full = PointCloud(np.concatenate([inner, surface.vertices, on]), surface).mesh(AS_MESHED)
    plain = PointCloud(inner, surface).mesh(AS_MESHED)
    np.testing.assert_array_equal(full.vertices, plain.vertices)
    astray = PointCloud(np.concatenate([inner, [[1.2, 0, 0], [0, 2, 0]]]), surface)
    with pytest.raises(InputError, match=rf"2 of {len(inner) + 2} points lie outside.*\[1\.2"):
        astray.mesh(AS_MESHED)


def test_interior_lattice_keeps_its_distance() -> None:
    surface = boundary(BOX, 0.125)
    points = interior_lattice(surface=surface, spacing=0.125)
    np.testing.assert_allclose(
        np.unique(points, axis=0), np.unique(BOX.mesh(0.125).vertices[
            np.all((BOX.mesh(0.125).vertices > 0) & (BOX.mesh(0.125).vertices < 1), axis=1)
        ], axis=0), atol=1e-12,
    )  # fmt: skip
    ball = sphere(0.2)
    inner = interior_lattice(surface=ball, spacing=0.2, jitter=0.5, seed=1)
    assert ball.distance(inner).length.min() >= 0.099
    other = interior_lattice(surface=ball, spacing=0.2, jitter=0.5, seed=2)
    assert np.all(inner[0] != other[0])
    np.testing.assert_array_equal(
        inner, interior_lattice(surface=ball, spacing=0.2, jitter=0.5, seed=1)
    )


@pytest.mark.parametrize("kind", ["csv", "xyz", "npy", "vtu", "named.csv"])
def test_points_and_surface_from_files(tmp_path: Path, kind: str) -> None:
    """In millimetres, to a body in metres."""
    surface = boundary(BOX, 0.25)
    inner = 1000.0 * interior_lattice(surface=surface, spacing=0.25)
    cells = [("triangle", surface.triangles)]
    meshio.write(tmp_path / "s.ply", meshio.Mesh(1000.0 * surface.vertices, cells))
    path = tmp_path / f"points.{kind}"
    if kind == "npy":
        np.save(path, inner)
    elif kind == "vtu":
        meshio.write(path, meshio.Mesh(inner, [("vertex", np.arange(len(inner))[:, None])]))
    elif kind == "named.csv":
        rows = [f"{k}, {z!r}, {x!r}, {y!r}" for k, (x, y, z) in enumerate(inner.tolist())]
        path.write_text("\n".join(["id, Z, X, Y", *rows]))
    else:
        separator = "," if kind == "csv" else " "
        np.savetxt(path, inner, delimiter=separator, header="by hand", fmt="%.17g")
    body = PointCloud(path, tmp_path / "s.ply", unit="mm")
    assert body.volume == pytest.approx(1.0, rel=1e-12)
    mesh = body.mesh(AS_MESHED)
    assert len(mesh.vertices) == 125
    np.testing.assert_allclose(mesh.vertices[98:], inner / 1000.0, rtol=1e-14)
    assert mesh.face("surface").shape == (192, 3)


def test_bad_points_are_refused(tmp_path: Path) -> None:
    surface = boundary(BOX, 0.25)
    inner = interior_lattice(surface=surface, spacing=0.25)

    def refused(points: object, named: str) -> None:
        with pytest.raises(InputError, match=named):
            PointCloud(points, surface).mesh(AS_MESHED)  # type: ignore[arg-type]

    broken = inner.copy()
    broken[4, 1] = np.nan
    refused(broken, r"1 points are not finite.*4")
    refused(np.concatenate([inner, inner[3:5]]), "2 pairs of points coincide")
    refused(inner[:, :2], r"shape \(n, 3\)")
    refused(1000.0 * inner, r"27 of 27 points lie outside.*same unit")
    refused(tmp_path / "absent.csv", "no such file")
    for name, text, named in (
        ("a.csv", "1,2,3\n4,5\n", "line 2"),
        ("b.csv", "a,b,c\n1,2,3\n", "line 1.*x, y, z"),
        ("c.csv", "7,1,2,3\n", "line 1"),
        ("d.xyz", "# nothing\n", "no points"),
        ("e.step", "", "kind .step"),
        ("f.npy", "not an array", "NumPy"),
    ):
        (tmp_path / name).write_text(text)
        refused(tmp_path / name, named)
    np.save(tmp_path / "g.npy", inner[:, :2])
    refused(tmp_path / "g.npy", r"shape \(27, 2\)")


def test_the_spacing_belongs_to_the_points() -> None:
    surface, cloud = filled("cube", 0.0)
    with pytest.raises(InputError, match="brings its own points"):
        cloud.mesh(0.125)
    with pytest.raises(InputError, match="does not fit the surface"):
        PointCloud.fill(surface=surface, spacing=0.01)
    with pytest.raises(InputError, match="spacing = 0"):
        PointCloud.fill(surface=surface, spacing=0.0)
    with pytest.raises(InputError, match="no point of a lattice"):
        interior_lattice(surface=surface, spacing=2.0)


def test_cells_that_miss_the_surface_are_refused() -> None:
    """A prism twisted by 30 degrees (Schoenhardt's): no tetrahedra of its corners fill it."""
    turn = np.deg2rad([0, 120, 240, 30, 150, 270])
    corners = np.stack([np.cos(turn), np.sin(turn), np.repeat([0.0, 1.0], 3)], axis=1)
    ends, next_to = [[0, 1, 2], [3, 4, 5]], [1, 2, 0]
    one = [[k, next_to[k], k + 3] for k in range(3)]
    one += [[next_to[k], k + 3, next_to[k] + 3] for k in range(3)]
    other = [[k, next_to[k], next_to[k] + 3] for k in range(3)]
    other += [[k, k + 3, next_to[k] + 3] for k in range(3)]
    thin, thick = sorted(
        (Surface.closed(vertices=corners, faces=[*ends, *sides]) for sides in (one, other)),
        key=lambda surface: surface.volume,
    )
    none = np.empty((0, 3))
    assert vertex_volumes(point_mesh(thick, none)).sum() == pytest.approx(thick.volume, rel=1e-13)
    with pytest.raises(InputError, match=r"hold 1\.366\d* m\^3 and the surface encloses 0\.866"):
        point_mesh(thin, none)


def test_a_planted_fault_in_the_shares_is_seen() -> None:
    """The exactness test fails for the plain cells of a curved body, so it can tell."""
    surface, cloud = filled("ball", 0.3)
    mesh = cloud.mesh(AS_MESHED)
    plain = PointMesh(
        mesh.vertices, mesh.cells, mesh.faces, mesh.spacing, False,
        shares=np.ones(len(mesh.cells)), corner_shares=np.ones(mesh.cells.shape),
        largest_change=0.0,
    )  # fmt: skip
    assert abs(vertex_volumes(plain).sum() / surface.volume - 1.0) > 1e-4
