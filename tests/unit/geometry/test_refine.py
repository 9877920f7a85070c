"""Refinement: the same body, the same tags, eight cells for one, and none of them worse."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import Box, GridMesh, Mesh, MeshFile, PointCloud, Surface, TetBox
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.delaunay import open_facets
from sphsolid.geometry.integrals import area_vectors, cell_volumes_and_centroids, vertex_volumes
from sphsolid.geometry.refine import Refined, refined
from studies.engine.sources import ROOT

MESHES = {
    "jittered": Box(upper=(1.0, 0.8, 1.2), jitter=0.5, seed=3).mesh(0.25),
    "lattice": Box().mesh(0.5),
    "tetrahedra": TetBox(seed=1).mesh(0.3),
    "plate of hexahedra": MeshFile(
        ROOT / "studies" / "meshes" / "plate_with_hole_hex.msh"
    ).mesh(AS_MESHED),
    "cylinder of tetrahedra": MeshFile(
        ROOT / "studies" / "meshes" / "cylinder_tet.msh"
    ).mesh(AS_MESHED),
}  # fmt: skip


@pytest.mark.parametrize("name", MESHES)
def test_children_fill_their_parents(name: str) -> None:
    mesh = MESHES[name]
    fine = refined(mesh)
    assert type(fine) is type(mesh)
    assert len(fine.cells) == 8 * len(mesh.cells)
    assert fine.spacing == 0.5 * mesh.spacing
    coarse_volume, coarse_centre = cell_volumes_and_centroids(mesh)
    volume, centre = cell_volumes_and_centroids(fine)
    assert volume.min() > 0.0
    # Eight children in a row: their volumes and moments are those of the parent.
    volume = volume.reshape(-1, 8)
    np.testing.assert_allclose(volume.sum(axis=1), coarse_volume, rtol=1e-12)
    moment = np.einsum("ck,ckd->cd", volume, centre.reshape(-1, 8, 3))
    np.testing.assert_allclose(moment, coarse_volume[:, None] * coarse_centre, atol=1e-13)
    assert vertex_volumes(fine).sum() == pytest.approx(vertex_volumes(mesh).sum(), rel=1e-13)


@pytest.mark.parametrize("name", MESHES)
def test_tags_keep_their_facets_areas_and_sides(name: str) -> None:
    mesh = MESHES[name]
    fine = refined(mesh)
    assert list(fine.faces) == sorted(mesh.faces)
    for tag, facets in mesh.faces.items():
        cut = fine.faces[tag]
        assert len(cut) == 4 * len(facets)
        before, after = area_vectors(mesh, facets), area_vectors(fine, cut)
        np.testing.assert_allclose(after.sum(axis=0), before.sum(axis=0), atol=1e-14)
        # First moments too: the children lie where their parents did.
        np.testing.assert_allclose(
            after.T @ fine.vertices, before.T @ mesh.vertices, atol=1e-13
        )


def _pairs(mesh: Mesh) -> set[tuple[int, ...]]:
    """Facets that belong to one cell only, as sorted corners."""
    corners = np.sort(mesh.cells[:, mesh.shape.facets].reshape(-1, mesh.shape.facets.shape[1]))
    facets, count = np.unique(corners, axis=0, return_counts=True)
    assert count.max() == 2
    return {tuple(row) for row in facets[count == 1].tolist()}


@pytest.mark.parametrize("name", MESHES)
def test_cells_meet_face_to_face_and_old_vertices_keep_their_numbers(name: str) -> None:
    mesh = MESHES[name]
    fine = refined(mesh)
    assert _pairs(fine) == {tuple(row) for row in np.sort(fine.boundary, axis=1).tolist()}
    np.testing.assert_array_equal(fine.vertices[: len(mesh.vertices)], mesh.vertices)
    assert len(np.unique(fine.vertices.round(12), axis=0)) == len(fine.vertices)
    assert np.array_equal(np.unique(fine.cells), np.arange(len(fine.vertices)))


def test_a_lattice_stays_one() -> None:
    fine, direct = refined(MESHES["lattice"]), Box().mesh(0.25)
    assert isinstance(fine, GridMesh)
    assert fine.widest == pytest.approx(direct.widest, rel=1e-15)
    assert fine.is_lattice
    for mesh in (fine, direct):
        mesh.vertices.sort(axis=0)
    np.testing.assert_array_equal(fine.vertices, direct.vertices)


def _quality(mesh: Mesh) -> float:
    """Worst volume of a tetrahedron over that of the regular one with its root-mean edge."""
    corner = mesh.vertices[mesh.cells]
    square = np.mean(
        [np.sum((corner[:, a] - corner[:, b]) ** 2, axis=1)
         for a, b in itertools.combinations(range(4), 2)], axis=0
    )  # fmt: skip
    volume = cell_volumes_and_centroids(mesh)[0]
    return float(np.min(volume * 6.0 * np.sqrt(2.0) / square**1.5))


def test_tetrahedra_do_not_degenerate() -> None:
    """The shortest diagonal bounds the quality however often it is done."""
    mesh: Mesh = TetBox(seed=2).mesh(0.5)
    first = _quality(mesh)
    found = []
    for _ in range(3):
        mesh = refined(mesh)
        found.append(_quality(mesh))
    assert found[-1] == pytest.approx(found[0], rel=1e-9)
    assert found[0] > 0.4 * first
    assert len(open_facets(mesh.cells)[0]) == len(mesh.boundary)


def test_a_refined_body_is_a_body() -> None:
    body = Refined(TetBox(), 2)
    mesh = body.mesh(0.5)
    assert body.volume == 1.0
    assert mesh.spacing == pytest.approx(0.125)
    assert len(mesh.cells) == 64 * len(TetBox().mesh(0.5).cells)
    assert len(Refined(Box(), 0).mesh(0.5).cells) == 8


@pytest.mark.parametrize("times", [-1, 7])
def test_absurd_refinements_are_refused(times: int) -> None:
    with pytest.raises(InputError, match=r"outside \[0, 6\]"):
        Refined(Box(), times)


def test_points_cannot_be_refined() -> None:
    box = Box().mesh(0.25)
    surface = Surface.closed(vertices=box.vertices, faces=box.faces)
    cloud = PointCloud.fill(surface=surface, spacing=0.25)
    with pytest.raises(InputError, match="points cannot be refined"):
        refined(cloud.mesh(AS_MESHED))
