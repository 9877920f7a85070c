"""Decks for CalculiX, what is read back, what is compared, and small runs where it is installed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from sphsolid import MooneyRivlin, NeoHookean, SaintVenantKirchhoff
from sphsolid.continuum.tensor import split
from sphsolid.errors import InputError
from sphsolid.scenes import (
    Box,
    Constraint,
    HeldVelocity,
    OnCylinder,
    PlaneClamp,
    Scene,
    Traction,
    csm3,
    csm3_spacing,
    l_shaped_block,
    punch,
    twisting_column,
)
from studies import outside as study
from studies.engine.results import Results
from studies.methods import B_BAR, PACKAGE
from studies.outside import claims as judged
from studies.outside.calculix import installed, read, read_frequencies, solve, version
from studies.outside.deck import Frequencies, Implicit, deck
from studies.outside.figures import beam_figure, sequences_figure
from studies.outside.hexahedra import face_shapes, quadratic
from studies.outside.nodal_loads import nodal_history
from studies.outside.problems import PROBLEMS, Beam, mesh_of
from studies.outside.sequences import CALCULIX, column_reference, comparison
from studies.outside.states import State, corners_height, displacement, highest, turned

needs_ccx = pytest.mark.skipif(not installed(), reason="CalculiX is not installed")
STEPS = Implicit(step=1e-3, until=4e-3, every=2e-3)


def cards(text: str) -> dict[str, list[str]]:
    """Data lines by card; cards that repeat are numbered."""
    found: dict[str, list[str]] = {}
    name = ""
    for line in text.splitlines():
        if line.startswith("*") and not line.startswith("**"):
            name = line if line not in found else f"{line} again"
            found[name] = []
        elif name:
            found[name].append(line)
    return found


# --- the mesh and the deck ------------------------------------------------------------------------


def test_twenty_nodes_an_element_shared_along_edges():
    mesh = Box(upper=(2.0, 1.0, 1.0)).mesh(1.0)
    made = quadratic(mesh)
    assert made.cells.shape == (2, 20)
    assert len(made.nodes) == 12 + 20
    assert len(np.unique(made.nodes, axis=0)) == len(made.nodes)
    for cell in made.cells:
        corner, middle = made.nodes[cell[:8]], made.nodes[cell[8:]]
        np.testing.assert_allclose(middle[0], (corner[0] + corner[1]) / 2)
        np.testing.assert_allclose(middle[7], (corner[7] + corner[4]) / 2)
        np.testing.assert_allclose(middle[11], (corner[3] + corner[7]) / 2)
    [loop] = made.faces["X+"]
    assert np.all(made.nodes[loop, 0] == 2.0)
    ends = made.nodes[[loop[:4], np.roll(loop[:4], -1)]]
    np.testing.assert_allclose(made.nodes[loop[4:]], ends.mean(axis=0))


def test_the_shapes_of_a_face():
    places = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]])
    np.testing.assert_allclose([face_shapes(*p)[0] for p in places], np.eye(8), atol=1e-15)
    N, slope = face_shapes(0.3, -0.6)
    assert N.sum() == pytest.approx(1.0)
    e = 1e-6
    for axis, step in enumerate(np.eye(2) * e):
        ahead, behind = (face_shapes(*(np.array([0.3, -0.6]) + s))[0] for s in (step, -step))
        np.testing.assert_allclose(slope[:, axis], (ahead - behind) / (2 * e), atol=1e-9)


def test_the_deck_of_the_column():
    scene = twisting_column()
    made = deck(scene, scene.body.mesh(1.0), STEPS)
    found = cards(made.text)
    assert len(found["*NODE,NSET=ALL"]) == len(made.elements.nodes)
    c10, d1 = map(float, found["*HYPERELASTIC,NEO HOOKE"][0].split(","))
    assert (c10, d1) == pytest.approx((scene.material.mu / 2, 2 / scene.material.kappa))
    held = [line.split(",") for line in found["*BOUNDARY"]]
    assert len(held) == 3 * 8
    assert {made.elements.nodes[int(node) - 1, 1] for node, *_ in held} == {0.0}
    assert found["*DYNAMIC,DIRECT,ALPHA=0"] == ["0.001,0.004"]
    _, v = scene.initial_state(made.elements.nodes)
    for line in found["*INITIAL CONDITIONS,TYPE=VELOCITY"]:
        node, axis, value = line.split(",")
        assert float(value) == pytest.approx(v[int(node) - 1, int(axis) - 1])
    assert found["*NODE PRINT,NSET=ALL,FREQUENCY=2"] == ["U"]


def test_the_beam_has_weight_rollers_and_a_linear_law():
    scene = csm3(points=3)
    found = cards(deck(scene, scene.body.mesh(csm3_spacing(3)), STEPS).text)
    assert found["*DLOAD"] == ["BODY,GRAV,2,0,-1,0"]
    assert [float(x) for x in found["*ELASTIC"][0].split(",")] == pytest.approx([1.4e6, 0.4])
    axes = {line.split(",")[1] for line in found["*BOUNDARY"]}
    assert axes == {"1", "2", "3"}


def test_a_traction_becomes_forces_of_nodes_and_an_amplitude():
    scene = l_shaped_block(jitter=0.0)
    mesh = scene.body.mesh(3.0)
    times = np.array([0.0, 1.0, 2.5, 4.0, 6.0])
    first = scene.tractions[0]
    load = nodal_history(scene, first, quadratic(mesh), times)
    np.testing.assert_allclose(load.amplitude, np.array([0.0, 1.0, 2.5, 1.0, 0.0]) / 2.5)
    np.testing.assert_allclose(load.force.sum(axis=0), 9.0 * 2.5 * np.array([150, 300, 450]))
    # One square: a corner has -1/12 of the force, the middle of a side 1/3.
    shares = np.sort(load.force[:, 0]) / load.force[:, 0].sum()
    np.testing.assert_allclose(shares, [-1 / 12] * 4 + [1 / 3] * 4)
    moving = replace(scene, tractions=(Traction("X+", lambda X, N, t: X * t + X**2),))
    with pytest.raises(InputError, match="no product"):
        nodal_history(moving, moving.tractions[0], quadratic(mesh), times)


@pytest.mark.parametrize(
    ("scene", "word"),
    [
        (punch(press=HeldVelocity()), "prescribed"),
        (replace(twisting_column(), material=MooneyRivlin.from_young(
            young_modulus=1e6, poisson_ratio=0.3, density=1e3, cofactor_share=0.5)),
            "MooneyRivlin"),
        (replace(twisting_column(), initial_displacement=lambda X: 0.1 * X), "displaced"),
        (replace(twisting_column(), body_force=lambda X, t: 0.0 * X + t), "varies"),
        (replace(csm3(clamp=OnCylinder()), constraints=(Constraint("X-", "normal"),)), "across"),
    ],
)  # fmt: skip
def test_what_a_deck_cannot_say_is_refused(scene, word):
    spacing = 0.01 if scene.name == "csm3" else 0.5
    with pytest.raises(InputError, match=word):
        deck(scene, scene.body.mesh(spacing), STEPS)


@pytest.mark.parametrize(
    "given", [{"step": 0.0}, {"until": 3.5e-3}, {"every": 1.5e-3}, {"alpha": 0.1}]
)
def test_times_that_do_not_fit_are_refused(given):
    with pytest.raises(InputError, match="Implicit"):
        Implicit(**({"step": 1e-3, "until": 4e-3, "every": 2e-3} | given))


# --- reading --------------------------------------------------------------------------------------

DAT = """
 displacements (vx,vy,vz) for set ALL and time  0.1000000E-01

         1  1.000000E+00  0.000000E+00 -2.000000E+00
         2  0.000000E+00  0.000000E+00  5.000000E-01

 total internal energy for set BODY and time  0.1000000E-01

        6.250000E+02

 total kinetic energy for set BODY and time  0.1000000E-01

        5.000000E+02
"""
MODES = """
     E I G E N V A L U E   O U T P U T

 MODE NO    EIGENVALUE                       FREQUENCY
                                     REAL PART            IMAGINARY PART
                           (RAD/TIME)      (CYCLES/TIME     (RAD/TIME)

      1   0.9000000E+01   0.3000000E+01   0.4774648E+00   0.0000000E+00
      2   0.1600000E+02   0.4000000E+01   0.6366198E+00   0.0000000E+00

     P A R T I C I P A T I O N   F A C T O R S

      1   0.1   0.2   0.3   0.4
"""


def test_what_calculix_wrote_is_read():
    found = read(DAT, nodes=2)
    np.testing.assert_array_equal(found.time, [0.01])
    np.testing.assert_array_equal(found.u, [[[1.0, 0.0, -2.0], [0.0, 0.0, 0.5]]])
    assert (found.strain_energy[0], found.kinetic_energy[0]) == (625.0, 500.0)
    np.testing.assert_array_equal(read_frequencies(MODES), [3.0, 4.0])
    for text, nodes in ((DAT, 3), (DAT.partition(" total")[0], 2)):
        with pytest.raises(InputError, match="CalculiX"):
            read(text, nodes=nodes)
    with pytest.raises(InputError, match="eigenvalues"):
        read_frequencies(DAT)


# --- what is compared -----------------------------------------------------------------------------


def rotated(angle: float, lift: float = 0.0) -> State:
    X = Box((-0.5, 0.0, -0.5), (0.5, 6.0, 0.5)).mesh(0.5).vertices
    c, s = np.cos(angle), np.sin(angle)
    x = X @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) + [0.1, lift, 0.2]
    return State(angle, X, x, 1.0)


def test_turns_heights_and_peaks():
    angles = [1.0, 3.5, 6.0, 8.0]
    states = [rotated(angle, lift=0.25) for angle in angles]
    found = turned(states)
    # From X to Z, which is against +Y.
    np.testing.assert_allclose(found, -np.array(angles))
    assert corners_height(states[0]) == pytest.approx(6.25)
    X = (0.0, 6.0, 0.0)
    np.testing.assert_allclose(displacement(states[0], X), [0.1, 0.25, 0.2], atol=1e-12)
    # Between four points: their mean.
    np.testing.assert_allclose(
        displacement(states[0], (0.25, 6.0, 0.25))[1], 0.25, atol=1e-12
    )
    t = np.linspace(0.0, 1.0, 11)
    assert highest(t, 3.0 - (t - 0.43) ** 2) == pytest.approx((0.43, 3.0))
    assert highest(t, t) == (1.0, 1.0)


def planted(off: float = 0.0) -> dict[str, pd.DataFrame]:
    """Tables of beams whose errors are ``off`` plus second order, and of one more problem."""
    calculix, ours = [], []
    for problem in (judged.PLANE, judged.CYLINDER):
        for level in (1, 2, 4):
            calculix.append({
                "problem": problem, "level": level, "elements": 10, "nodes": 99, "step_ms": 2.5,
                "alpha": 0.0, "version": "CalculiX 2.20", "wall_s": 1.0, "quantity": judged.TIP,
                "value": -128.5 + 0.1 / level**4,
            })  # fmt: skip
        for method in (PACKAGE, B_BAR):
            for level in (4, 8, 16, 32):
                ours.append({
                    "problem": problem, "method": method.name, "level": level, "points": 10,
                    "survived": True, "folded": False, "steps": 9, "wall_s": 1.0,
                    "quantity": judged.TIP, "value": -128.5 * (1 + off + 0.5 / level**2),
                })  # fmt: skip
    frames = {"calculix": pd.DataFrame(calculix), "ours": pd.DataFrame(ours)}
    table = comparison(frames["calculix"], frames["ours"])
    beside = study.beside_particles(frames["ours"], frames["calculix"])
    return frames | {"table": table, "particles": beside}


def test_limits_are_compared():
    table = planted(off=0.02)["table"]
    own = table[table["method"] == PACKAGE.name].iloc[0]
    assert own["off_limit"] == pytest.approx(0.02, abs=1e-4)
    assert own["left"] == pytest.approx(0.5 / 32**2 / 1.02, rel=1e-3)
    assert table[table["method"] == CALCULIX]["off_limit"].abs().max() < 1e-12
    assert (table["levels"] == [3, 4, 4] * 2).all()


@pytest.mark.parametrize(("off", "verdict"), [(0.0, "met"), (0.02, "not met")])
def test_verdicts(off, verdict):
    tables = planted(off)
    found = {(c.what, c.where): c.verdict for c in judged.claims(tables)}
    what = "limits of the lattices within the share asked for of CalculiX"
    assert found[what, PACKAGE.name] == verdict
    at = f"{judged.PLANE}: error at 17 points, against CalculiX"
    assert found[at, B_BAR.name] == verdict
    far = judged.explained(tables)
    assert len(far) == (0 if verdict == "met" else 4)
    assert not far["covered"].any()
    clamps = judged.of_the_clamp(tables)
    assert clamps["what"].str.startswith("published").sum() == 2


def test_runs_that_were_lost_or_folded_do_not_count():
    tables = planted()
    ours = tables["ours"].assign(folded=lambda frame: frame["level"] == 16)
    again = comparison(tables["calculix"], ours)
    own = again[again["method"] == PACKAGE.name].iloc[0]
    assert own["levels"] == 3


def test_the_stored_table_stands_where_nothing_was_made(tmp_path):
    made = planted()["calculix"]
    path = tmp_path / "calculix.csv"
    made.to_csv(path, index=False)
    now = made[(made["level"] == 4)].assign(value=-1.0)
    both = study.with_stored(now, path)
    assert len(both) == len(made)
    assert (both[both["level"] == 4]["value"] == -1.0).all()
    assert (study.with_stored(made[:0], path)["value"] == made["value"]).all()
    assert study.with_stored(now, tmp_path / "none.csv") is now
    # A frequency has no step.
    still = made.assign(step_ms=np.nan)
    still.to_csv(path, index=False)
    assert len(study.with_stored(still, path)) == len(still)


def test_the_columns_table_has_the_form_of_the_other_study():
    from studies.twisting_column import outside as other

    rows = [
        {"problem": "column", "level": n, "step_ms": 0.5, "quantity": q, "value": 1.0}
        for n in (2, 3) for q in ("twist at 100 ms [rad]", "top corners at 100 ms [m]", "energy")
    ]  # fmt: skip
    made = column_reference(pd.DataFrame(rows), "column")
    assert list(made.columns) == list(other.figures().columns)
    assert made["elements"].tolist() == ["2x12x2"] * 2 + ["3x18x3"] * 2
    assert set(made["quantity"]) == {"twist", "corners"}


def test_every_published_figure_has_a_source():
    frame = pd.read_csv(study.PUBLISHED, comment="#")
    assert frame["source"].notna().all()
    assert (frame["low"] <= frame["high"]).all()
    names = {problem.name for problem in PROBLEMS}
    assert set(frame["problem"]) <= names


def test_figures_are_drawn(tmp_path):
    results = Results(tmp_path, planted(), pd.DataFrame(), {})
    assert len(study.words(planted())["main"]) == 6
    assert sequences_figure(results).axes
    assert beam_figure(results).axes


def test_every_problem_has_a_deck():
    for problem in PROBLEMS:
        level = problem.outside[0]
        steps = replace(problem.implicit, until=2 * problem.implicit.every)
        made = deck(problem.scene(level), mesh_of(problem, level), steps)
        assert made.text.endswith("*END STEP\n")


# --- small runs -----------------------------------------------------------------------------------


def bar(law, **more) -> Scene:
    sides = tuple(Constraint(face, "normal") for face in ("X-", "Y-", "Y+", "Z-", "Z+"))
    return Scene("bar", Box(), law, 1.0, constraints=sides, **more)


@needs_ccx
def test_one_element_stretched_has_the_stress_of_the_law():
    """So light that it is at rest at every moment."""
    law = NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1e-3)
    pull = Traction("X+", lambda X, N, t: 4e5 * min(t, 1.0) * N)
    scene = bar(law, tractions=(pull,))
    made = deck(scene, scene.body.mesh(1.0), Implicit(0.1, 2.0, 0.1, alpha=-0.3))
    text, _ = solve(made)
    found = read(text, len(made.elements.nodes))
    stretch = 1.0 + found.u[-1][made.elements.nodes[:, 0] == 1.0, 0].mean()
    F = np.diag([stretch, 1.0, 1.0])
    from sphsolid.continuum.neo_hookean import energy, first_piola

    J = float(np.linalg.det(F))
    tensors = (split(F), split(J * np.linalg.inv(F).T))
    assert first_piola(law, *tensors, J)[0] == pytest.approx(4e5, rel=1e-3)
    at_rest = energy(law, split(np.eye(3)), split(np.eye(3)), 1.0)
    assert found.strain_energy[-1] == pytest.approx(energy(law, *tensors, J) - at_rest, rel=1e-2)


@needs_ccx
def test_the_frequency_of_a_bar():
    """``c_p / 4 L`` of a bar that is held at its sides."""
    law = SaintVenantKirchhoff.from_young(young_modulus=1e6, poisson_ratio=0.0, density=1e3)
    scene = bar(law)
    text, _ = solve(deck(scene, scene.body.mesh(0.25), Frequencies(1)))
    speed = np.sqrt(1e6 / 1e3)
    assert read_frequencies(text)[0] == pytest.approx(2 * np.pi * speed / 4, rel=1e-4)


@needs_ccx
def test_a_short_run_has_every_column():
    assert version()
    beam = Beam(PlaneClamp(), step=0.25)
    from studies.outside.runs import OUTSIDE, run_outside

    class Short(Beam):
        implicit = Implicit(0.005, 0.02, 0.005)  # type: ignore[assignment]

    rows = run_outside(problem=Short(beam.clamp), level=1)
    assert {*OUTSIDE, "quantity", "value"} <= set(rows[0])
    assert rows[0]["value"] < 0.0
