"""Essential conditions as projectors, above all where faces meet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import HoledBlock, TetBox
from sphsolid.scenes import Box, Constraint, swinging_cube
from sphsolid.scenes.constraint import essential_parts, prescribed_parts, vertex_normals

X, Y, Z = np.eye(3)


def total(parts, mesh):
    """Sum of the projectors of every particle ``(N, 3, 3)``."""
    Q = np.zeros((len(mesh.vertices), 3, 3))
    for part in parts:
        Q[part.particles] += part.projector
    return Q


def at(mesh, *point):
    return int(np.argmin(np.sum((mesh.vertices - np.array(point)) ** 2, axis=1)))


def onto(*directions):
    """Projector on the span of unit axes."""
    return sum((np.outer(d, d) for d in directions), np.zeros((3, 3)))


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_projectors_are_orthogonal_and_share_no_direction(jitter):
    scene = swinging_cube(jitter=jitter)
    mesh = scene.body.mesh(0.25)
    parts = essential_parts(scene.constraints, mesh)
    seen = np.zeros((len(mesh.vertices), 3, 3))
    for part in parts:
        Q = part.projector
        np.testing.assert_allclose(Q, np.swapaxes(Q, 1, 2), atol=1e-14)
        np.testing.assert_allclose(Q @ Q, Q, atol=1e-13)
        np.testing.assert_allclose(Q @ seen[part.particles], 0.0, atol=1e-13)
        seen[part.particles] += Q
        assert part.is_fixed


def test_swinging_cube_at_faces_edges_and_corners():
    scene = swinging_cube()
    mesh = scene.body.mesh(0.25)
    Q = total(essential_parts(scene.constraints, mesh), mesh)
    expected = {
        (0.5, 0.5, 0.5): onto(),
        (0.0, 0.5, 0.5): onto(X),  # roller
        (0.5, 0.5, 0.0): onto(Z),
        (1.0, 0.5, 0.5): onto(Y, Z),  # tangentially fixed
        (0.5, 1.0, 0.5): onto(X, Z),
        (0.0, 0.0, 0.5): onto(X, Y),  # two rollers
        (0.0, 1.0, 0.5): onto(X, Z),  # roller X, tangential X and Z: X only once
        (1.0, 0.5, 0.0): onto(Y, Z),
        (1.0, 1.0, 0.5): onto(X, Y, Z),  # two tangential faces leave nothing
        (0.0, 0.0, 0.0): onto(X, Y, Z),
        (1.0, 0.0, 0.0): onto(Y, Z),  # two rollers, tangential in the same two: X is free
        (1.0, 1.0, 1.0): onto(X, Y, Z),
    }
    for point, projector in expected.items():
        np.testing.assert_allclose(Q[at(mesh, *point)], projector, atol=1e-13, err_msg=str(point))


@pytest.mark.parametrize(
    ("direction", "projector"),
    [("normal", onto(Z)), ("tangential", onto(X, Y)), ("all", onto(X, Y, Z))],
)
def test_directions(direction, projector):
    mesh = Box().mesh(0.5)
    [part] = essential_parts((Constraint("Z+", direction),), mesh)
    np.testing.assert_array_equal(part.particles, mesh.face_particles("Z+"))
    np.testing.assert_allclose(part.projector, np.broadcast_to(projector, (9, 3, 3)), atol=1e-14)


def test_a_later_constraint_adds_only_what_is_free():
    mesh = Box().mesh(0.5)

    def moving(X, t):
        return np.full_like(X, t)

    clamp, roller = Constraint("Y-", "all"), Constraint("X-", "normal", moving)
    first, second = essential_parts((clamp, roller), mesh)
    assert first.is_fixed
    assert not second.is_fixed
    on_both = np.isin(second.particles, first.particles)
    np.testing.assert_allclose(second.projector[on_both], 0.0, atol=1e-14)
    np.testing.assert_allclose(second.projector[~on_both], np.broadcast_to(onto(X), (6, 3, 3)))


def test_normals_are_unit_and_outward_on_a_disordered_face():
    [(particles, normal)] = vertex_normals(Box(jitter=0.4).mesh(0.25), "Y-")
    assert len(particles) == 25
    np.testing.assert_allclose(normal, np.broadcast_to(-Y, normal.shape), atol=1e-14)


def as_one_tag(mesh, *faces):
    """The mesh with one tag, ``skin``, over some of its faces."""
    return replace(mesh, faces={"skin": np.concatenate([mesh.faces[face] for face in faces])})


ALL_FACES = ("X-", "X+", "Y-", "Y+", "Z-", "Z+")


@pytest.mark.parametrize("body", [Box(), TetBox(upper=(1.0, 1.0, 0.5)), Box(jitter=0.3)])
@pytest.mark.parametrize("direction", ["normal", "tangential"])
def test_a_tag_round_an_edge_holds_what_its_sides_hold(body, direction):
    mesh = body.mesh(0.25)
    one = essential_parts((Constraint("skin", direction),), as_one_tag(mesh, *ALL_FACES))
    many = essential_parts(tuple(Constraint(face, direction) for face in ALL_FACES), mesh)
    held = [np.zeros((len(mesh.vertices), 3, 3)) for _ in range(2)]
    for taken, parts in zip(held, (one, many), strict=True):
        for part in parts:
            taken[part.particles] += part.projector
    np.testing.assert_allclose(held[0], held[1], atol=1e-12)
    corner = np.flatnonzero(np.all(np.isclose(mesh.vertices, 0.0), axis=1))
    np.testing.assert_allclose(held[0][corner], np.eye(3)[None], atol=1e-12)


def test_a_curved_tag_is_one_side():
    mesh = HoledBlock(upper=(4.0, 4.0, 1.0), radius=0.5).mesh(0.25)
    assert len(vertex_normals(mesh, "hole")) == 1


def test_bad_constraints_are_refused():
    with pytest.raises(InputError, match=r"'sideways'.*'normal'"):
        Constraint("X-", "sideways")
    with pytest.raises(InputError, match="'bottom'"):
        essential_parts((Constraint("bottom", "all"),), Box().mesh(0.5))


def pull(X, t):
    return np.ones_like(X)


def test_a_motion_that_nothing_is_left_of_is_refused():
    mesh, held = Box().mesh(0.5), Constraint("Z+", "all")
    for two in (
        (held, Constraint("Z+", "all", pull)),
        (Constraint("Z+", "all", pull), held),
        (held, Constraint("Z+", "normal", pull)),
    ):
        with pytest.raises(InputError, match=r"constraint on 'Z\+'.* on Z\+, prescribe all"):
            essential_parts(two, mesh)
    # What is held twice, and motions that share an edge, are fine.
    essential_parts((held, Constraint("Z+", "normal"), Constraint("X+", "all", pull)), mesh)
    essential_parts((Constraint("Z+", "normal"), Constraint("Z+", "tangential", pull)), mesh)


class Sheared:
    """A box whose side X+ leans over: it meets Z- and Z+ at half a right angle."""

    def mesh(self, spacing):
        mesh = Box().mesh(spacing)
        X = mesh.vertices.copy()
        X[:, 0] += X[:, 2]
        return replace(mesh, vertices=X)


def unit_normal_speed(X, t):
    return np.tile([1.0, 0.0, -1.0], (len(X), 1)) / np.sqrt(2.0)


@pytest.mark.parametrize("order", [("Z-", "X+"), ("X+", "Z-")])
def test_sides_at_any_angle_have_both_their_motions(order):
    """v.n = 1 on X+ and a roller on Z-: where they meet v = (sqrt 2, 0, 0), in either order."""
    mesh = Sheared().mesh(0.5)
    of = {"Z-": Constraint("Z-", "normal"), "X+": Constraint("X+", "normal", unit_normal_speed)}
    parts = essential_parts(tuple(of[name] for name in order), mesh)
    v = np.zeros_like(mesh.vertices)
    for rows, given in prescribed_parts(parts, mesh.vertices, 0.0):
        v[rows] += given
    np.testing.assert_allclose(v[at(mesh, 1.0, 0.5, 0.0)], [np.sqrt(2.0), 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(v[at(mesh, 1.5, 0.5, 0.5)], [0.5**0.5, 0.0, -(0.5**0.5)], atol=1e-12)
    np.testing.assert_allclose(v[at(mesh, 0.0, 0.5, 0.0)], 0.0, atol=1e-12)


def test_sides_at_right_angles_take_the_projected_motion_to_the_bit():
    mesh = Box().mesh(0.5)
    parts = essential_parts(
        (Constraint("X+", "normal", unit_normal_speed), Constraint("Z-", "all")), mesh
    )
    assert not any(part.is_oblique for part in parts)
    (rows, given), = prescribed_parts(parts, mesh.vertices, 0.0)
    np.testing.assert_array_equal(rows, parts[0].particles)
    np.testing.assert_array_equal(given[:, 1:], 0.0)
