"""Stress concentration at a hole, from mesh files: ``python -m studies.plate_with_hole``.

A quarter plate read from Gmsh files is pulled slowly, by the package default and by self-adjoint
SUPG on hexahedra and on tetrahedra, and by B-bar finite elements on the same hexahedra.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshQuad,
    MeshQuad2,
    asm,
    condense,
    solve,
)
from skfem.helpers import ddot, sym_grad, trace

from sphsolid import Consistent
from sphsolid.defaults import default_operator
from sphsolid.errors import InputError
from sphsolid.geometry import Mesh, MeshFile
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.geometry.closed_surface import halves
from sphsolid.scenes import gross_concentration, plate_with_hole
from studies.engine.plotting import outside_legend, panels
from studies.engine.study import Case, Claim, Results, Row, Study, Tables, run_study
from studies.measures import folding
from studies.measures.tables import select
from studies.meshes import MESHES
from studies.methods import B_BAR, PACKAGE, SUPG, Method

# --- the plane problem by quadratic finite elements: what every method should come to -------------

Array = NDArray[np.float64]
_LAME = (1.5, 1.0)
#: Corners of the reference quadrilateral.
_CORNERS = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]])


def plane_stress_over_pull(
    *, cells: int, radius: float = 0.1, half_width: float = 0.5
) -> tuple[Array, Array]:
    """``sigma / S (n, 2, 2)`` at the corners ``X (n, 2)`` of ``cells x cells`` elements.

    Quadratic elements in geometry and displacement, linear elasticity; the mean of what the
    elements around a corner have there.  Neither Poisson's ratio nor stress or strain being plane
    changes the stress in the plane.
    """

    def place(s: Array) -> Array:
        """From the unit square (from the hole outwards, around it) to the quarter plate."""
        angle = 0.5 * np.pi * s[1]
        direction = np.stack([np.cos(angle), np.sin(angle)])
        outer = half_width / direction.max(axis=0)
        # Finer at the hole.
        out = s[0] * (0.35 + 0.65 * s[0])
        return (radius + (outer - radius) * out) * direction

    planes = np.linspace(0.0, 1.0, cells + 1)
    flat = MeshQuad2.from_mesh(MeshQuad.init_tensor(planes, planes))
    mesh = MeshQuad2(place(flat.doflocs), flat.t)
    element = ElementVector(ElementQuad2())
    lam, mu = _LAME

    @BilinearForm
    def stiffness(u, v, w):  # type: ignore[no-untyped-def]
        e, f = sym_grad(u), sym_grad(v)
        return lam * trace(e) * trace(f) + 2.0 * mu * ddot(e, f)

    @LinearForm
    def pull(v, w):  # type: ignore[no-untyped-def]
        return v[1]

    basis = Basis(mesh, element)
    top = mesh.facets_satisfying(lambda x: np.isclose(x[1], half_width), boundaries_only=True)
    fixed = np.concatenate(
        [
            basis.get_dofs(lambda x, axis=axis: np.isclose(x[axis], 0.0)).all(f"u^{axis + 1}")
            for axis in (0, 1)
        ]
    )
    u = solve(*condense(asm(stiffness, basis), asm(pull, FacetBasis(mesh, element, facets=top)),
                        D=fixed))  # fmt: skip
    corners = Basis(mesh, element, quadrature=(_CORNERS, np.ones(4)))
    e = sym_grad(corners.interpolate(u))
    sigma = 2.0 * mu * e + lam * trace(e) * np.eye(2)[:, :, None, None]
    X = np.asarray(corners.global_coordinates())
    key = np.round(X.reshape(2, -1).T / (1e-7 * half_width)).astype(np.int64)
    _, first, number = np.unique(key, axis=0, return_index=True, return_inverse=True)
    count = np.bincount(number.ravel())
    values = np.asarray(sigma).reshape(4, -1)
    mean = [np.bincount(number.ravel(), weights=row) / count for row in values]
    return X.reshape(2, -1).T[first], np.stack(mean, axis=1).reshape(-1, 2, 2)


# --- hoop stress at the edge, from particles or from the middle of cells --------------------------

#: Cells to a fit, ten columns of four layers on the mesh of hexahedra, and how many more at a time
#: where these do not determine a quadratic: condition number of the terms, in units of the patch.
PATCH, MORE, LARGEST_CONDITION = 40, 8, 100.0


def hoop(X: Array, stress: Array) -> Array:
    """``t . sigma t (n,)`` with ``t`` around the Z axis, ``stress (n, 3, 3)`` at ``X (n, 3)``."""
    r = np.hypot(X[:, 0], X[:, 1])
    t = np.stack([-X[:, 1] / r, X[:, 0] / r], axis=1)
    return np.asarray(np.einsum("ni,nij,nj->n", t, stress[:, :2, :2], t))


def at_cells(stress: Array, cells: NDArray[np.int64]) -> Array:
    """Means over the corners of cells ``(C, 3, 3)``: the interpolant in the middle of each."""
    return np.asarray(stress[cells].mean(axis=1))


def fitted(X: Array, stress: Array, at: Array) -> Array:
    """Stress ``(m, 3, 3)`` at places ``at (m, 2)``, a mean over the thickness.

    The complete quadratic in X and Y that fits best, in the least-squares sense, the ``PATCH``
    values nearest in the plane, or more where they are in too few rows: patch recovery
    [Zienkiewicz1992], which reaches the edge of the hole from the middles of the cells beside it.
    """
    tree = cKDTree(X[:, :2])
    out = np.empty((len(at), 3, 3))
    for k, place in enumerate(at):
        for size in range(min(PATCH, len(X)), len(X) + 1, MORE):
            _, patch = tree.query(place, k=size)
            d = X[patch, :2] - place
            x, y = (d / np.abs(d).max(axis=0)).T
            terms = np.stack([np.ones_like(x), x, y, x**2, x * y, y**2], axis=1)
            if np.linalg.cond(terms) <= LARGEST_CONDITION:
                break
        fit = np.linalg.lstsq(terms, stress[patch].reshape(size, 9), rcond=None)[0]
        out[k] = fit[0].reshape(3, 3)
    return out


# --- one face in colour ---------------------------------------------------------------------------


def draw_facets(
    ax: Axes,
    plane: Array,
    facets: NDArray[np.int64],
    values: Array,
    *,
    limits: tuple[float, float],
    colour_map: str,
) -> Any:
    """Colour facets ``(n, 3 or 4)`` by ``values (N,)`` at their vertices ``plane (N, 2)`` [m].

    Colours are linear between the vertices of a triangle; the edges of the facets are drawn.
    """
    drawn = ax.tripcolor(
        Triangulation(plane[:, 0], plane[:, 1], halves(facets)),
        values, shading="gouraud", cmap=colour_map, vmin=limits[0], vmax=limits[1],
        rasterized=True,
    )  # fmt: skip
    ax.add_collection(
        PolyCollection(
            list(plane[facets]), facecolors="none", edgecolors="black", linewidths=0.15, alpha=0.5
        )
    )
    ax.set(aspect="equal", xlabel="X [m]", ylabel="Y [m]")
    ax.grid(visible=False)
    return drawn


# --- the study ------------------------------------------------------------------------------------

CONSISTENT = SUPG.but(operator=Consistent(), marker="s")
#: Methods and meshes; the first run is the one that others are compared with.
RUNS = (
    (B_BAR, "hex"), (PACKAGE, "hex"), (PACKAGE, "tet"), (SUPG, "hex"), (SUPG, "tet"),
    (CONSISTENT, "hex"), (CONSISTENT, "tet"),
)  # fmt: skip
#: Those with the default operator.
USUAL = RUNS[:5]
WORDS = {"hex": "hexahedra", "tet": "tetrahedra"}
STRESS, RADIUS, HALF_WIDTH = 2.1e7, 0.1, 0.5
#: Instants of the hold whose stresses are averaged.
INSTANTS = 16
#: Angles [deg] from the X axis at which the edge of the hole is asked for its hoop stress.
ANGLES = np.linspace(0.0, 90.0, 19)
#: Elements along and around of the plane reference.
PLANE_CELLS = 48
#: Allowed distance from B-bar, in each way of comparing.
TOLERANCE = 0.03
COMPARED = {
    "against_fit": "edge, both by the same fit",
    "against_particles": "edge, particles against the elements' fit",
    "against_highest": "highest of all particles on the hole",
    "against_ring": "middles of the cells at the hole, largest",
}
#: Hoop stress over the pull at the ends of the colours.
COLOURS = (-1.5, 3.5)
_RUN = ["key", "method", "mesh", "thickness"]
_VALUES = [
    *_RUN, "particles", "edge_particles", "edge_spread", "edge_fit", "highest_particles",
    "highest_fit", "unrest", "kinetic_share", *folding.COLUMNS, "steps", "setup_s", "wall_s",
]  # fmt: skip


@dataclass(frozen=True)
class Held:
    """Mean of ``P / S (n, 3, 3)`` over the hold where the law is evaluated, and of what run."""

    stress: Array
    X: Array
    mesh: Mesh
    facts: Row

    @property
    def at_particles(self) -> bool:
        """Whether stress is known at the vertices, not in the middle of cells."""
        return len(self.X) == len(self.mesh.vertices)


def mesh_of(name: str) -> MeshFile:
    """The plate of ``hex`` or ``tet``."""
    return MeshFile(MESHES / f"plate_with_hole_{name}.msh")


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """All in plane strain, the default operator with a free face too; the quick form pulls faster.

    It has plane strain and the default operator only.
    """
    listed = []
    for thickness in ("plane_strain",) if options.quick else ("plane_strain", "free"):
        for method, mesh in USUAL if options.quick or thickness == "free" else RUNS:
            pull = (1.5, 0.75) if options.quick else (4.0, 1.0)
            listed.append(_case(method, mesh, thickness, *pull))
    return listed


def _case(method: Method, mesh: str, thickness: str, rise: float, hold: float) -> Case:
    arguments = {
        "method": method, "mesh": mesh, "thickness": thickness, "rise": rise, "hold": hold,
    }  # fmt: skip
    cost = 1.0 if method == B_BAR else 8.0
    return Case(f"{method.name}, {mesh}, {thickness}", run_plate, arguments, cost)


def run_plate(
    *, method: Method, mesh: str, thickness: str, rise: float, hold: float
) -> list[Row]:
    """A row ``kind = value``, one ``ligament`` per place on it, one ``ring`` per cell at the hole.

    One ``front`` a vertex of the plate's front is what a picture needs.
    """
    held = pull(method, mesh, thickness=thickness, rise=rise, hold=hold)
    names = (f"{method.name}, {mesh}, {thickness}", method.name, mesh, thickness)
    common = dict(zip(_RUN, names, strict=True))
    return [common | row for row in (*measured(held), *_front(held))]


def pull(method: Method, mesh: str, *, thickness: str, rise: float, hold: float) -> Held:
    """The run itself."""
    scene = plate_with_hole(
        body=mesh_of(mesh),
        thickness=thickness,  # type: ignore[arg-type]
        stress=STRESS,
        radius=RADIUS,
        half_width=HALF_WIDTH,
        rise=rise,
        hold=hold,
    )
    started = time.perf_counter()
    sim = method.simulation(scene, spacing=AS_MESHED)
    ready = time.perf_counter()
    length = scene.end_time * hold / (rise + hold)
    instants = []
    for n in range(INSTANTS):
        sim.run(until=scene.end_time - length * (1.0 - (n + 1) / INSTANTS))
        instants.append(sim.snapshot().P / STRESS)
    last = sim.snapshot()
    peaks = [float(stress[:, 1, 1].max()) for stress in instants]
    facts = {
        "particles": len(last.X),
        "steps": sim.step,
        "setup_s": ready - started,
        "wall_s": time.perf_counter() - ready,
        "kinetic_share": last.kinetic_energy / last.strain_energy,
        "unrest": (max(peaks) - min(peaks)) / float(np.mean(peaks)),
        **folding.folding(sim),
    }
    return Held(np.mean(instants, axis=0), last.stress_X, last.mesh, facts)


def measured(held: Held) -> list[Row]:
    """The concentration in every way, the ligament and the ring of cells at the hole."""
    cells = held.mesh.cells
    centre = held.mesh.vertices[cells].mean(axis=1)
    in_cells = at_cells(held.stress, cells) if held.at_particles else held.stress
    angle = np.radians(ANGLES)
    edge = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    around = hoop(edge, fitted(centre, in_cells, edge))
    value: Row = {
        "kind": "value", "edge_fit": float(around[0]), "highest_fit": float(around.max()),
        "edge_particles": np.nan, "edge_spread": np.nan, "highest_particles": np.nan,
    }  # fmt: skip
    if held.at_particles:
        on_hole = held.mesh.face_particles("hole")
        values = hoop(held.X[on_hole], held.stress[on_hole])
        at_side = values[np.isclose(held.X[on_hole, 1], 0.0, atol=1e-9)]
        value |= {
            "edge_particles": float(at_side.mean()), "edge_spread": float(np.ptp(at_side)),
            "highest_particles": float(values.max()),
        }  # fmt: skip
    rows = [value | held.facts, *_ligament(held, centre, in_cells)]
    if held.mesh.shape is HEXAHEDRON:
        rows += _ring(held.mesh, centre, in_cells)
    return rows


def _ligament(held: Held, centre: Array, in_cells: Array) -> list[Row]:
    """Means over the thickness of what particles have, fitted for the finite elements."""
    vertices = held.mesh.vertices
    on_line = held.mesh.face_particles("symmetry_y")
    place, number = np.unique(np.round(vertices[on_line, 0], 9), return_inverse=True)
    if held.at_particles:
        count = np.bincount(number)
        stress = np.bincount(number, weights=held.stress[on_line, 1, 1]) / count
    else:
        at = np.stack([place, np.zeros_like(place)], axis=1)
        stress = fitted(centre, in_cells, at)[:, 1, 1]
    return _curve("ligament", X=place, stress=stress)


def _ring(mesh: Mesh, centre: Array, in_cells: Array) -> list[Row]:
    """Hoop stress in the middle of the cells at the hole, a mean over the layers."""
    beside = np.flatnonzero(np.isin(mesh.cells, mesh.face_particles("hole")).any(axis=1))
    values = hoop(centre[beside], in_cells[beside])
    angle = np.degrees(np.arctan2(centre[beside, 1], centre[beside, 0]))
    place, number = np.unique(np.round(angle, 6), return_inverse=True)
    mean = np.bincount(number, weights=values) / np.bincount(number)
    return _curve("ring", angle=place, stress=mean)


def _front(held: Held) -> list[Row]:
    """Hoop stress at the vertices of the front, in their order, fitted for finite elements."""
    X, front = held.mesh.vertices, held.mesh.face_particles("front")
    stress = held.stress[front] if held.at_particles else fitted(held.X, held.stress, X[front, :2])
    return _curve("front", vertex=front, stress=hoop(X[front], stress))


def _curve(kind: str, **columns: NDArray[Any]) -> list[Row]:
    frame = pd.DataFrame({"kind": kind, **columns})
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


def warm_up(options: argparse.Namespace) -> Sequence[Case]:
    """Short pulls; they also leave the operators in the cache."""
    return [_case(method, mesh, "plane_strain", 0.01, 0.01) for method, mesh in USUAL]


def tables(rows: list[Row]) -> Tables:
    """``table``: a row a run; ``ligament``, ``ring``, ``front``: curves; ``plane``: the reference.

    ``against_*`` are relative differences from B-bar of the same reading of the thickness.
    """

    def of(kind: str, *columns: str) -> pd.DataFrame:
        return pd.DataFrame([row for row in rows if row["kind"] == kind], columns=list(columns))

    ring = of("ring", "key", "angle", "stress")
    X, stress = plane_stress_over_pull(
        cells=PLANE_CELLS, radius=RADIUS, half_width=HALF_WIDTH
    )
    on_line = np.flatnonzero(np.isclose(X[:, 1], 0.0, atol=1e-9))
    on_line = on_line[np.argsort(X[on_line, 0])]
    plane = pd.DataFrame({"X": X[on_line, 0], "stress": stress[on_line, 1, 1]})
    strip = gross_concentration(radius=RADIUS, half_width=HALF_WIDTH)
    gross = np.array([3.0, strip, plane["stress"].iloc[0]])
    net = gross * np.array([1.0, *2 * [1.0 - RADIUS / HALF_WIDTH]])
    what = ["infinite plate", "long strip", "this plate, plane reference"]
    return {
        "table": _compared(of("value", *_VALUES), ring),
        "ligament": of("ligament", "key", "X", "stress"),
        "ring": ring,
        "front": of("front", "key", "vertex", "stress"),
        "plane": plane,
        "known": pd.DataFrame({"what": what, "concentration": gross, "net": net}),
    }


def _compared(value: pd.DataFrame, ring: pd.DataFrame) -> pd.DataFrame:
    table = value.assign(**dict.fromkeys(COMPARED, np.nan))
    for _, runs in value.groupby("thickness"):
        elements = select(runs, method=B_BAR.name)
        if len(elements) == 0:
            continue
        reference = elements.iloc[0]
        for index, run in runs[runs["method"] != B_BAR.name].iterrows():
            over = {
                "against_fit": run["edge_fit"] / reference["edge_fit"],
                "against_particles": run["edge_particles"] / reference["edge_fit"],
                "against_highest": run["highest_particles"] / reference["highest_fit"],
                "against_ring": 1.0 + _apart(ring, run["key"], reference["key"]),
            }
            for name, ratio in over.items():
                table.loc[index, name] = ratio - 1.0
    return table


def _apart(ring: pd.DataFrame, key: str, reference: str) -> float:
    """Largest difference in the ring over the largest value, or nan without a common ring."""
    by_angle = ring.sort_values("angle")
    a, b = (select(by_angle, key=name)["stress"].to_numpy() for name in (key, reference))
    if len(a) == 0 or len(a) != len(b):
        return float("nan")
    return float(np.abs(a - b).max() / np.abs(b).max())


def claims(tables: Tables) -> list[Claim]:
    """One claim per run and way of comparing; what was not compared has none."""
    return [
        Claim(
            what, abs(run[column]), "<=", TOLERANCE, where=run["key"], sound=not run["folded"],
            said=f"{run[column]:+.2%}", format=".0%",
        )
        for run in tables["table"].to_dict("records") for column, what in COMPARED.items()
        if run["method"] != B_BAR.name and np.isfinite(run[column])
    ]  # fmt: skip


def plate_figure(results: Results) -> Figure:
    """Front of the plate with the hoop stress, plane strain."""
    figure, axes = panels(1, len(USUAL), width=2.3, height=2.4)
    drawn: Any = None
    for ax, (method, mesh) in zip(axes.flat, USUAL, strict=True):
        ax.set_title(f"{method.name},\n{WORDS[mesh]}")
        run = select(results.tables["front"], key=f"{method.name}, {mesh}, plane_strain")
        if len(run) == 0:
            ax.text(0.5, 0.5, "not run", ha="center", va="center")
            continue
        face = mesh_of(mesh).mesh(AS_MESHED)
        used, number = np.unique(face.face("front"), return_inverse=True)
        drawn = draw_facets(
            ax, face.vertices[used, :2], number.reshape(face.face("front").shape),
            run["stress"].to_numpy(), limits=COLOURS, colour_map="viridis",
        )  # fmt: skip
    if drawn is None:
        raise InputError("front.csv is empty: run python -m studies.plate_with_hole")
    bar = figure.colorbar(drawn, ax=axes.ravel().tolist(), shrink=0.8)
    bar.set_label("hoop stress / pull [-]")
    return figure


def ligament_figure(results: Results) -> Figure:
    """Ligament (left), near the hole (middle) and ring of cells at the hole (right)."""
    ligament, ring, plane = (results.tables[name] for name in ("ligament", "ring", "plane"))
    figure, axes = panels(1, 3, width=3.2, height=2.9)
    for ax in axes.flat[:2]:
        ax.plot(plane["X"], plane["stress"], color="0.6", linewidth=2.5, label="plane reference")
    for method, mesh in RUNS:
        key, label = f"{method.name}, {mesh}, plane_strain", f"{method.name}, {WORDS[mesh]}"
        look = method.look | {"markersize": 3.2, "linewidth": 0.9, "label": label}
        if method == CONSISTENT:
            look["markerfacecolor"] = "white"
        if mesh == "tet":
            # Particles on the line of a cloud of tetrahedra are at different heights: no line.
            look |= {"linestyle": "none", "marker": "v" if method == CONSISTENT else "^"}
        mine, around = select(ligament, key=key), select(ring, key=key)
        for ax in axes.flat[:2] if len(mine) else ():
            ax.plot(mine["X"], mine["stress"], **look)
        if len(around):
            axes[0, 2].plot(around["angle"], around["stress"], **look)
    y_label = "stress along Y / pull [-]"
    axes[0, 0].set(title="ligament, Y = 0", xlabel="X [m]", ylabel=y_label)
    axes[0, 1].set(title="ligament beside the hole", xlabel="X [m]", ylabel=y_label)
    axes[0, 1].set(xlim=(RADIUS - 0.002, 1.5 * RADIUS), ylim=(1.2, 3.7))
    axes[0, 2].set(
        title="middles of the cells at the hole", xlabel="angle from the X axis [deg]",
        ylabel="hoop stress / pull [-]",
    )  # fmt: skip
    outside_legend(figure, axes.flat, columns=3)
    return figure


def words(tables: Tables) -> Mapping[str, Any]:
    """The scene, and how far the methods with the default operator are from the elements."""
    found = []
    for method in (PACKAGE, SUPG):
        mine = [claim for claim in claims(tables) if claim.where.startswith(f"{method.name}, ")]
        mine = [claim for claim in mine if CONSISTENT.name not in claim.where]
        worst = max((float(claim.measured) for claim in mine), default=np.nan)  # type: ignore[arg-type]
        met = sum(claim.verdict == "met" for claim in mine)
        found.append({"method": method.name, "counted": len(mine), "met": met, "worst": worst})
    return {
        "judged": found, "default": PACKAGE.name,
        "operator": default_operator(mesh_of("hex").mesh(AS_MESHED)).name,
        "half_width": HALF_WIDTH, "radius": RADIUS, "stress": STRESS, "instants": INSTANTS,
        "tolerance": TOLERANCE, "patch": PATCH,
    }  # fmt: skip


STUDY = Study(
    name="plate_with_hole",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={"plate": plate_figure, "ligament": ligament_figure},
    words=words,
    text=Path(__file__).with_suffix(".md"),
    warm_up=warm_up,
    description="Stress concentration at a hole, particles on mesh files against B-bar elements.",
)


if __name__ == "__main__":
    run_study(STUDY)
