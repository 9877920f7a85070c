"""Parts that fill one space twice are refused; those that touch or lie in holes are not."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud
from sphsolid.errors import InputError
from sphsolid.geometry import Box, HexMesh, Mesh, MeshFile, PointCloud, Surface, TetBox, check_mesh
from sphsolid.geometry.overlap import refuse_overlap


def together(*meshes: Mesh) -> HexMesh:
    """Several meshes as one, nothing of them joined."""
    shift = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    joined = [mesh.boundary + by for mesh, by in zip(meshes, shift, strict=False)]
    return type(meshes[0])(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.cells + by for mesh, by in zip(meshes, shift, strict=False)]),
        {"boundary": np.concatenate(joined)}, meshes[0].spacing, is_lattice=False,
    )  # fmt: skip


def plain(mesh: Mesh) -> HexMesh:
    """A grid as any mesh of hexahedra."""
    return HexMesh(mesh.vertices, mesh.cells, mesh.faces, mesh.spacing, is_lattice=False)


def box(low, high, spacing=0.25) -> HexMesh:
    return plain(Box(low, high).mesh(spacing))


UNIT = box((0, 0, 0), (1, 1, 1))
OVERLAPPING = {
    "corner in the other": (box((0.9, 0.8, 0.7), (1.9, 1.8, 1.7)), 2.0),
    "same box": (box((0, 0, 0), (1, 1, 1), 0.2), 2.0),
    "one inside the other": (box((0.3, 0.3, 0.3), (0.7, 0.7, 0.7), 0.2), 1.064),
    "bars across each other": (box((-1, 0.4, 0.4), (2, 0.6, 0.6), 0.2), 1.12),
}


@pytest.mark.parametrize("name", OVERLAPPING)
def test_parts_that_overlap_are_refused(name: str) -> None:
    other, cells = OVERLAPPING[name]
    mesh = together(UNIT, other)
    with pytest.raises(InputError, match=rf"overlap, .* hold {cells:g} m\^3 in a space of about"):
        check_mesh(mesh)
    with pytest.raises(InputError, match="parts of the body overlap"):
        build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.Literal())


@pytest.mark.parametrize("gap", [0.0, 1.0e-6, 0.02, 3.0])
def test_parts_that_touch_or_do_not_are_taken(gap: float) -> None:
    refuse_overlap("x", together(UNIT, box((0.13, 0.0, 1.0 + gap), (1.13, 1.0, 2.0 + gap), 0.2)))


def test_a_body_in_the_hole_of_another_is_taken() -> None:
    grid = Box((0, 0, 0), (3, 3, 3)).mesh(1.0)
    hollow = grid.cells[np.arange(27) != 13]
    around = HexMesh(
        grid.vertices, hollow,
        {"boundary": np.concatenate([grid.boundary, _inward(grid.cells[13], grid)])},
        1.0, is_lattice=False,
    )  # fmt: skip
    refuse_overlap("x", together(around, box((1.2, 1.2, 1.2), (1.8, 1.8, 1.8), 0.3)))
    with pytest.raises(InputError, match="overlap"):
        refuse_overlap("x", together(around, box((1.2, 1.2, 1.2), (2.5, 1.8, 1.8), 0.3)))


def _inward(cell, grid):
    from sphsolid.geometry.facets import cell_facets

    return cell_facets(cell[None], grid.shape)[:, ::-1]


def test_a_file_with_two_parts_in_one_place_is_refused(tmp_path) -> None:
    one = TetBox().mesh(0.34)
    for shift, fine in ((0.53, False), (1.07, True)):
        cells = np.concatenate([one.cells, one.cells + len(one.vertices)])
        points = np.concatenate([one.vertices, one.vertices + np.array([shift, 0.017, 0.011])])
        path = tmp_path / f"{shift}.vtu"
        meshio.Mesh(points, [("tetra", cells)]).write(path)
        if fine:
            assert check_mesh(MeshFile(path).mesh(sph.geometry.body.AS_MESHED)).parts == 2
            continue
        with pytest.raises(InputError, match=r"vtu: parts of the body overlap, for instance at X"):
            MeshFile(path).read()


def test_surfaces_that_overlap_are_refused() -> None:
    one, two = Box().mesh(0.25), Box((0.6, 0.6, 0.6), (1.6, 1.6, 1.6)).mesh(0.25)
    with pytest.raises(InputError, match="touches or crosses itself"):
        Surface.closed(
            vertices=np.concatenate([one.vertices, two.vertices]),
            faces=np.concatenate([one.boundary, two.boundary + len(one.vertices)]),
        )


def test_a_ball_in_a_hollow_ball_is_a_body_of_its_own() -> None:
    """Three sheets, two bodies: the hole belongs to the outer one."""
    from sphsolid.geometry.body import AS_MESHED
    from sphsolid.geometry.integrals import vertex_volumes
    from tests.oracles.surfaces import sphere

    ball = sphere(0.25)
    count = len(ball.vertices)
    surface = Surface.closed(
        vertices=np.concatenate([2.0 * ball.vertices, ball.vertices, 0.7 * ball.vertices]),
        faces=np.concatenate([ball.triangles + k * count for k in range(3)]),
    )
    mesh = PointCloud.fill(surface=surface, spacing=0.3).mesh(AS_MESHED)
    V, r = vertex_volumes(mesh), np.linalg.norm(mesh.vertices, axis=1)
    inner = r < 0.85
    assert V[inner].sum() == pytest.approx(0.7**3 * ball.volume, rel=1e-12)
    assert V[~inner].sum() == pytest.approx(7.0 * ball.volume, rel=1e-12)
    assert np.all(inner[mesh.cells] == inner[mesh.cells[:, :1]])
