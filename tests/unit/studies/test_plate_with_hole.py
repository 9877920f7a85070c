"""The plate study: recovery on Kirsch's field, the plane reference, verdicts."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import AsMeshed, MeshFile
from studies import plate_with_hole as study
from studies.engine.results import Results
from studies.meshes import MESHES
from studies.methods import B_BAR, SUPG
from studies.plate_with_hole import at_cells, fitted, plane_stress_over_pull


def kirsch(X, a=0.1):
    """Stress ``(n, 3, 3)`` in an infinite plate pulled along Y by one."""
    r, angle = np.hypot(X[:, 0], X[:, 1]), np.arctan2(X[:, 1], X[:, 0])
    q, turn = (a / r) ** 2, 2.0 * (angle - 0.5 * np.pi)
    rr = 0.5 * (1 - q) + 0.5 * (1 - 4 * q + 3 * q**2) * np.cos(turn)
    tt = 0.5 * (1 + q) - 0.5 * (1 + 3 * q**2) * np.cos(turn)
    rt = -0.5 * (1 + 2 * q - 3 * q**2) * np.sin(turn)
    c, s = np.cos(angle), np.sin(angle)
    R = np.stack([np.stack([c, -s], 1), np.stack([s, c], 1)], 1)
    out = np.zeros((len(X), 3, 3))
    polar = np.stack([np.stack([rr, rt], 1), np.stack([rt, tt], 1)], 1)
    out[:, :2, :2] = R @ polar @ np.swapaxes(R, 1, 2)
    return out


@pytest.mark.parametrize(("name", "exact", "corners"), [("hex", 3.024, 3.022), ("tet", 3.0, 2.973)])
def test_what_the_fit_makes_of_kirsch(name, exact, corners):
    mesh = MeshFile(MESHES / f"plate_with_hole_{name}.msh").mesh(AsMeshed())
    centre, edge = mesh.vertices[mesh.cells].mean(axis=1), np.array([[0.1, 0.0]])
    assert fitted(centre, kirsch(centre), edge)[0, 1, 1] == pytest.approx(exact, abs=2e-3)
    averaged = at_cells(kirsch(mesh.vertices), mesh.cells)
    assert fitted(centre, averaged, edge)[0, 1, 1] == pytest.approx(corners, abs=2e-3)


def test_the_plane_reference_converges_and_meets_kirsch_for_a_small_hole():
    peaks = [plane_stress_over_pull(cells=n)[1][:, 1, 1].max() for n in (12, 24)]
    assert peaks[1] == pytest.approx(peaks[0], rel=2e-3)
    assert peaks[1] == pytest.approx(3.360, abs=5e-3)
    wide = plane_stress_over_pull(cells=80, radius=0.02)[1][:, 1, 1].max()
    assert wide == pytest.approx(3.0, rel=0.02)


@pytest.mark.parametrize(
    ("off", "folded", "verdict"),
    [(0.02, False, "met"), (-0.04, False, "not met"), (0.02, True, "not met")],
)
def test_claims(off, folded, verdict):
    nothing = dict.fromkeys(study.COMPARED, np.nan) | {"folded": folded}
    runs = [
        {"method": SUPG.name, "key": "a", **nothing, "against_fit": off},
        {"method": B_BAR.name, "key": "b", **nothing, "against_fit": 0.0},
    ]
    [claim] = study.claims({"table": pd.DataFrame(runs)})
    assert claim.verdict == verdict
    # Where the number alone would do, the report says why it does not.
    assert claim.shown == f"{off:+.2%}" + ("; folded or diverged" if folded else "")


def planted(method, edge, highest, ring):
    """Rows of a run in plane strain with these concentrations."""
    common = {"key": method.name, "method": method.name, "mesh": "hex", "thickness": "free"}
    value = {"kind": "value", "edge_fit": edge, "highest_fit": edge, "edge_particles": edge,
             "highest_particles": highest, "folded": False}  # fmt: skip
    curve = [{"kind": "ring", "angle": float(k), "stress": ring + k} for k in (1, 0)]
    return [common | row for row in (value, *curve)]


def test_differences_are_relative_to_the_elements():
    rows = [*planted(B_BAR, 3.0, 3.0, 1.0), *planted(SUPG, 3.3, 3.6, 1.1)]
    table = study.tables(rows)["table"].set_index("method")
    assert table.loc[B_BAR.name, list(study.COMPARED)].isna().all()
    found = table.loc[SUPG.name, list(study.COMPARED)].astype(float)
    np.testing.assert_allclose(found, [0.1, 0.1, 0.2, 0.05])


@pytest.mark.parametrize("method", [B_BAR, SUPG], ids=lambda method: method.name)
def test_a_short_pull_from_end_to_end(method, tmp_path):
    """Too short to reach the hole, long enough for every number of the report to be there."""
    rows = study.run_plate(
        method=method, mesh="hex", thickness="plane_strain", rise=0.02, hold=0.02
    )
    kinds = pd.Series([row["kind"] for row in rows]).value_counts()
    assert kinds["value"] == 1
    assert kinds["ligament"] > 10
    assert kinds["ring"] > 10
    value = rows[0]
    assert value["steps"] >= study.INSTANTS
    assert np.isfinite(value["edge_fit"])
    assert np.isfinite(value["edge_particles"]) == (method == SUPG)
    # The end that is pulled is at 5 radii: nothing has arrived at the hole.
    assert abs(value["edge_fit"]) < 1e-3
    tables = study.tables(rows)
    assert np.isfinite(tables["ligament"]["stress"]).all()
    mesh = study.mesh_of("hex").mesh(AsMeshed())
    assert tables["front"]["vertex"].tolist() == mesh.face_particles("front").tolist()
    nothing = tables | {"front": tables["front"][:0]}
    assert study.plate_figure(Results(tmp_path, tables, pd.DataFrame(), {}))
    with pytest.raises(InputError, match=r"front\.csv is empty"):
        study.plate_figure(Results(tmp_path, nothing, pd.DataFrame(), {}))
