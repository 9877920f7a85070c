"""Closed surfaces: what they enclose, how they are turned, and one clear error for each defect."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box, Surface
from sphsolid.geometry.inside import distance_to_surface, solid_angles, winding_numbers
from tests.oracles.surfaces import boundary, cylinder, sphere

L_BLOCK = Blocks((((0, 0, 0), (3, 10, 3)), ((3, 0, 0), (6, 3, 3))))
CUBE = boundary(Box(), 0.25)


def hollow() -> Surface:
    """A cube of edge 3 with a cubic hole of edge 1, both turned outward when given."""
    outer, inner = boundary(Box((-1.5,) * 3, (1.5,) * 3), 0.5), boundary(Box(), 0.5)
    count = len(outer.vertices)
    return Surface.closed(
        vertices=np.concatenate([outer.vertices, inner.vertices - 0.5]),
        faces={"outside": outer.triangles, "hole": inner.triangles + count},
    )


def test_volume_and_moments_are_exact() -> None:
    assert CUBE.volume == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(CUBE.first_moments, 0.5, rtol=1e-14)
    block = boundary(L_BLOCK, 0.75)
    assert block.volume == pytest.approx(117.0, rel=1e-14)
    np.testing.assert_allclose(block.first_moments, [256.5, 490.5, 175.5], rtol=1e-14)
    shell = hollow()
    assert shell.volume == pytest.approx(26.0, rel=1e-14)
    np.testing.assert_allclose(shell.first_moments, 0.0, atol=1e-13)


def test_a_body_far_from_the_origin_keeps_its_digits() -> None:
    shift = np.array([1e4, -2e4, 3e4])
    far = Surface.closed(vertices=CUBE.vertices + shift, faces=CUBE.faces)
    assert far.volume == pytest.approx(1.0, rel=1e-11)
    np.testing.assert_allclose(far.first_moments, 0.5 + shift, rtol=1e-11)


def test_the_sphere_is_approached_at_second_order() -> None:
    defect = [4.0 * np.pi / 3.0 - sphere(h).volume for h in (0.4, 0.2, 0.1)]
    assert np.all(np.log2(np.divide(defect[:-1], defect[1:])) > 1.8)


def test_triangles_are_turned_consistently_and_outward() -> None:
    random = np.random.default_rng(1)
    mixed = CUBE.triangles.copy()
    turned = random.random(len(mixed)) < 0.5
    mixed[turned] = mixed[turned][:, ::-1]
    for triangles in (mixed, CUBE.triangles[:, ::-1]):
        surface = Surface.closed(vertices=CUBE.vertices, faces=triangles)
        assert surface.volume == pytest.approx(1.0, rel=1e-14)
        assert list(surface.faces) == ["surface"]


def test_a_hole_is_turned_inward_and_an_island_in_it_outward() -> None:
    shell = hollow()
    inner = shell.vertices[shell.faces["hole"]]
    normal = np.cross(inner[:, 1] - inner[:, 0], inner[:, 2] - inner[:, 0])
    assert np.all(np.einsum("nd,nd->n", normal, inner.mean(axis=1)) < 0.0)
    count = len(shell.vertices)
    nested = Surface.closed(
        vertices=np.concatenate([shell.vertices, 0.4 * (CUBE.vertices - 0.5)]),
        faces={**shell.faces, "island": CUBE.triangles + count},
    )
    assert nested.volume == pytest.approx(26.0 + 0.4**3, rel=1e-14)


def test_unused_vertices_are_left_out_and_quadrilaterals_cut() -> None:
    mesh = Box().mesh(0.5)
    assert len(mesh.vertices) == 27
    surface = Surface.closed(vertices=mesh.vertices, faces=mesh.faces)
    assert len(surface.vertices) == 26
    assert len(surface.faces["X+"]) == 2 * len(mesh.faces["X+"])


@pytest.mark.parametrize(
    "surface", [CUBE, boundary(L_BLOCK, 1.5), sphere(0.4), cylinder(0.4), hollow()]
)
def test_rays_count_what_solid_angles_measure(surface: Surface) -> None:
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    random = np.random.default_rng(0)
    points = random.uniform(low - 0.2 * (high - low), high + 0.2 * (high - low), (2000, 3))
    winding = winding_numbers(points, surface.vertices, surface.triangles)
    measured = solid_angles(points, surface.vertices, surface.triangles)
    np.testing.assert_allclose(winding, measured, atol=1e-9)
    assert 0.15 < np.mean(winding == 1.0) < 0.8
    share = np.mean(winding) * np.prod(1.4 * (high - low))
    assert share == pytest.approx(surface.volume, rel=0.15)


def test_points_in_line_with_vertices_and_on_the_surface() -> None:
    axis = np.linspace(-0.25, 1.25, 7)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    inside = np.all((grid > 0.0) & (grid < 1.0), axis=1)
    np.testing.assert_array_equal(CUBE.contains(grid), inside)
    points = np.array([[0.0, 0.4, 0.3], [0.0, 0.0, 0.3], [0.0, 0.0, 0.0]])
    winding = winding_numbers(points, CUBE.vertices, CUBE.triangles)
    np.testing.assert_allclose(winding, [0.5, 0.25, 0.125], atol=1e-6)


def test_distance_to_a_cube() -> None:
    points = np.random.default_rng(2).uniform(-0.5, 1.5, (500, 3))
    q = np.abs(points - 0.5) - 0.5
    exact = np.linalg.norm(np.maximum(q, 0.0), axis=1) - np.minimum(q.max(axis=1), 0.0)
    found = CUBE.distance(points, resolution=0.02)
    np.testing.assert_allclose(found.length, exact, atol=1e-3)
    near = distance_to_surface(
        points, CUBE.vertices, CUBE.triangles, resolution=0.02, reach=0.1
    ).length
    np.testing.assert_array_equal(near[exact < 0.1], found.length[exact < 0.1])
    assert np.all(near[exact > 0.13] == np.inf)


@pytest.mark.parametrize("binary", [True, False])
def test_stl_is_merged_and_scaled(tmp_path: Path, binary: bool) -> None:
    path = tmp_path / "cube.stl"
    loose = 1000.0 * CUBE.vertices[CUBE.triangles].reshape(-1, 3)
    # Written by a program that rounds each triangle on its own.
    loose = loose + np.random.default_rng(0).uniform(-1e-4, 1e-4, loose.shape)
    cells = [("triangle", np.arange(len(loose)).reshape(-1, 3))]
    meshio.stl.write(path, meshio.Mesh(loose, cells), binary=binary)
    surface = Surface.read(path, unit="mm")
    assert len(surface.vertices) == len(CUBE.vertices)
    assert surface.volume == pytest.approx(1.0, rel=1e-6)
    assert sorted(surface.faces) == ["surface"]


@pytest.mark.parametrize("kind", ["ply", "obj", "vtu"])
def test_other_files_keep_every_digit(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"body.{kind}"
    meshio.write(path, meshio.Mesh(CUBE.vertices, [("triangle", CUBE.triangles)]))
    assert Surface.read(path).volume == pytest.approx(1.0, rel=1e-12)


def test_physical_names_of_gmsh_become_tags(tmp_path: Path) -> None:
    path = tmp_path / "body.msh"
    names = sorted(CUBE.faces)
    numbers = [np.full(len(CUBE.faces[name]), k + 1) for k, name in enumerate(names)]
    meshio.write(
        path,
        meshio.Mesh(
            CUBE.vertices,
            [("triangle", CUBE.faces[name]) for name in names],
            cell_data={"gmsh:physical": numbers, "gmsh:geometrical": numbers},
            field_data={name: np.array([k + 1, 2]) for k, name in enumerate(names)},
        ),
        file_format="gmsh22",
    )
    surface = Surface.read(path)
    assert sorted(surface.faces) == names
    top = surface.vertices[surface.faces["Z+"]]
    assert np.all(top[:, :, 2] == 1.0)
    assert surface.volume == pytest.approx(1.0, rel=1e-14)


def moved(vertices: np.ndarray, index: int, to: object) -> np.ndarray:
    result = vertices.copy()
    result[index] = to
    return result


TWO = np.concatenate([CUBE.vertices, CUBE.vertices + np.array([1.0, 1.0, 0.0])])
ON_SIDE = np.concatenate([CUBE.vertices, CUBE.vertices + np.array([1.0, 0.1, 0.1])])
ONCE, WHERE = np.unique(TWO, axis=0, return_inverse=True)
COUNT = len(CUBE.vertices)
BOTH = np.concatenate([CUBE.triangles, CUBE.triangles + COUNT])
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def klein_bottle() -> tuple[np.ndarray, np.ndarray]:
    """A torus of triangles whose last ring is joined in reverse, its vertices anywhere."""
    n = 6
    ring = np.arange(n * n).reshape(n, n)
    ring = np.concatenate([ring, ring[:1, np.r_[0, n - 1 : 0 : -1]]])
    ring = np.concatenate([ring, ring[:, :1]], axis=1)
    a, b, c, d = ring[:-1, :-1], ring[1:, :-1], ring[1:, 1:], ring[:-1, 1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return np.random.default_rng(0).uniform(size=(n * n, 3)), triangles


@pytest.mark.parametrize(
    ("vertices", "triangles", "named"),
    [
        (CUBE.vertices, CUBE.triangles[1:], "open: 3 edges"),
        (CUBE.vertices, CUBE.triangles[:0], "no triangles"),
        (moved(CUBE.vertices, 5, np.nan), CUBE.triangles, "not finite"),
        (moved(CUBE.vertices, 5, CUBE.vertices[6]), CUBE.triangles, "same place"),
        (CUBE.vertices, CUBE.triangles + 1, "there are 0 to"),
        (CUBE.vertices[:, :2], CUBE.triangles, "shape"),
        (CUBE.vertices, CUBE.triangles.astype(float), "integers"),
        (CORNERS, np.concatenate([TETRAHEDRON, [[0, 0, 1]]]), "a vertex twice"),
        (moved(CORNERS, 3, [2.0, 0.0, 0.0]), TETRAHEDRON, "no area"),
        # Two cubes that share an edge, each with its own vertices there and with common ones.
        (TWO, BOTH, "same place"),
        (ONCE, WHERE.ravel()[BOTH], "in an edge"),
        # Two tetrahedra that share a corner.
        (
            np.concatenate([CORNERS, -CORNERS[1:]]),
            np.concatenate([TETRAHEDRON, np.array([0, 4, 5, 6])[TETRAHEDRON]]),
            "in 1 vertices",
        ),
        # A corner pulled through the opposite side; cubes that overlap; one that rests on another.
        (moved(CUBE.vertices, 0, [1.3, 1.2, 1.4]), CUBE.triangles, "crosses itself"),
        (np.concatenate([CUBE.vertices, CUBE.vertices + 0.43]), BOTH, "crosses itself"),
        (ON_SIDE, BOTH, "crosses itself"),
        (*klein_bottle(), "one side only"),
    ],
)
def test_a_defect_is_one_clear_error(vertices: object, triangles: object, named: str) -> None:
    with pytest.raises(InputError, match=named):
        Surface.closed(vertices=vertices, faces=triangles)  # type: ignore[arg-type]


def test_an_open_surface_says_where() -> None:
    corner = np.flatnonzero(np.any(np.all(CUBE.vertices[CUBE.triangles] == 1.0, axis=2), axis=1))
    with pytest.raises(InputError, match=r"at X = \[(0\.\d+|1\.0), "):
        Surface.closed(vertices=CUBE.vertices, faces=np.delete(CUBE.triangles, corner[:1], axis=0))


def test_files_that_are_no_surface(tmp_path: Path) -> None:
    def refused(name: str, content: bytes, named: str) -> None:
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(InputError, match=named) as error:
            Surface.read(path)
        assert name in str(error.value)

    with pytest.raises(InputError, match="no such file"):
        Surface.read(tmp_path / "absent.stl")
    refused("body.step", b"ISO-10303-21;", "kind .step")
    refused("empty.stl", b"", "STL|no triangles")
    half = b"solid x\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n"
    refused("half.stl", half, "STL|no triangles")
    refused("words.ply", b"this is not a ply file", "cannot be read as PLY")
    refused("points.obj", b"v 0 0 0\nv 1 0 0\n", "triangles")
    refused("body.msh", b"hello", "MeshFormat")
    path = tmp_path / "open.stl"
    meshio.stl.write(path, meshio.Mesh(CUBE.vertices, [("triangle", CUBE.triangles[3:])]))
    with pytest.raises(InputError, match=r"open\.stl: the surface is open"):
        Surface.read(path)
    with pytest.raises(InputError, match="unit = 'feet'"):
        Surface.read(path, unit="feet")
