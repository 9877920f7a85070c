"""The particles of a body and every operator a scheme needs of them, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from sphsolid.cloud.boundary_weights import quadratically_exact_areas
from sphsolid.cloud.consistent import divergence_defect
from sphsolid.cloud.gradient import (
    corrected_gradient,
    linear_interpolation,
    offsets,
    row_sum,
)
from sphsolid.cloud.lattice_difference import LatticeDifference
from sphsolid.cloud.lengths import Lengths, lengths_of, refuse_long_cells
from sphsolid.cloud.loaded_areas import loaded_areas
from sphsolid.cloud.operator import (
    Gradients,
    Ingredients,
    Layout,
    OperatorKind,
    refuse_wrong_gradients,
    refuse_wrong_layout,
)
from sphsolid.cloud.operator_cache import gradients_of
from sphsolid.cloud.pair_tables import (
    KeptTables,
    Packed,
    PairTables,
    TablesOnDemand,
    WrittenOut,
)
from sphsolid.cloud.pairs.neighbours import PairList, transposed
from sphsolid.cloud.pairs.pair_operator import PairOperator, expanded, pair_operators
from sphsolid.cloud.pairs.parts import parts_of
from sphsolid.cloud.pairs.sight import Sight
from sphsolid.cloud.secondary import SecondaryPoints
from sphsolid.cloud.smoothing import SmoothingFunction
from sphsolid.cloud.summation_by_parts import skewness_defect
from sphsolid.cloud.support import check_support
from sphsolid.errors import require
from sphsolid.geometry.integrals import area_vectors, vertex_volumes
from sphsolid.geometry.mesh import Mesh
from sphsolid.geometry.overlap import refuse_overlap
from sphsolid.geometry.patches import smooth_patches

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cloud:
    """Primary particles.

    ``X (N, 3)`` [m] positions, ``V (N,)`` [m^3] volumes and ``areas (N, 3)`` [m^2] outward area
    vectors, zero inside.  ``lengths`` are the smoothing lengths, ``h_min`` [m] is the smallest
    distance of a pair.  ``sight`` says who sees whom through the material.  ``left_out`` counts the
    pairs within their support that it leaves out, ``parts`` the sets of particles that share no
    pair.  ``iterations`` and ``change`` are as in ``operator.Gradients``; ``kind`` is the option
    that made them, ``areas_by_tag`` what it brought along, if anything.

    The operators have one pair list and three columns each (``tables``).  ``kinematic`` and
    ``force`` are the gradients ``G_b(X_a)`` [1/m] (see ``operator.Gradients``), one object when
    adjoint.  ``adjoint`` is the divergence ``g_ab = V_b G_a(X_b) / V_a``: ``(DIV P)_a`` is minus
    ``sum_b P_b g_ab``.
    """

    mesh: Mesh
    X: Array
    V: Array
    areas: Array
    lengths: Lengths
    tables: PairTables
    smoothing: SmoothingFunction
    h_min: float
    iterations: int
    change: float
    sight: Sight
    left_out: int
    parts: int
    kind: OperatorKind
    areas_by_tag: dict[str, csc_array] = field(default_factory=dict)

    @property
    def h(self) -> float:
        """Nominal smoothing length [m]; ``lengths`` has those of a graded cloud."""
        return self.lengths.h_over_dx * self.lengths.nominal

    def areas_of(self, face: str) -> Array:
        """Area vectors of a tag ``(N, 3)`` [m^2]; those of all tags add up to :attr:`areas`."""
        if face in self.areas_by_tag:
            return np.asarray(self.areas_by_tag[face].toarray())
        part = area_vectors(self.mesh, self.mesh.face(face))
        if np.array_equal(self.areas, area_vectors(self.mesh, self.mesh.boundary)):
            return part
        return quadratically_exact_areas(self.mesh)[face]

    def areas_of_sides(self, face: str) -> list[Array]:
        """Area vectors ``(N, 3)`` [m^2] that a load acts over, of each smooth side of a tag.

        A sum over a sharp edge would lose its area.  Resultant and moments of a constant traction
        are those of the facets: see :mod:`sphsolid.cloud.loaded_areas`.
        """
        patches = smooth_patches(self.mesh, self.mesh.face(face))
        facets = [area_vectors(self.mesh, patch) for patch in patches]
        return loaded_areas(self.X, facets, self.areas_of(face))

    @property
    def spacing(self) -> float:
        """Nominal particle spacing ``dx`` [m]."""
        return self.mesh.spacing

    @property
    def middle(self) -> Array:
        """Middle of the box around the particles ``(3,)`` [m]."""
        return np.asarray(0.5 * (self.X.min(axis=0) + self.X.max(axis=0)))

    @property
    def size(self) -> int:
        """Number of primary particles."""
        return len(self.X)

    @property
    def kinematic(self) -> PairOperator:
        """Sums for ``F`` and its rate."""
        return self.tables.packed.kinematic

    @property
    def force(self) -> PairOperator:
        """Sums with the gradient whose adjoint makes the force."""
        return self.tables.packed.force

    @property
    def adjoint(self) -> PairOperator:
        """Sums for the force."""
        return self.tables.packed.adjoint

    @property
    def is_adjoint(self) -> bool:
        """True when force and kinematics share one gradient."""
        return self.tables.is_adjoint

    @property
    def mean_neighbours(self) -> float:
        """Pairs a particle, those with coefficient zero included."""
        return self.tables.mean_neighbours

    @property
    def particle_major(self) -> bool:
        """How tensor fields should lie in memory (see ``fields``)."""
        return self.tables.particle_major

    @property
    def pairs(self) -> PairList:
        """Who sees whom, written out (it takes memory; nothing in a step needs it)."""
        return self.tables.written_out(self.areas).pairs

    @property
    def gradients(self) -> Gradients:
        """Coefficients ``(P, 3)`` [1/m] of every pair, written out."""
        found = self.tables.written_out(self.areas).gradients
        return Gradients(
            found.kinematic, found.force, self.areas, self.iterations, self.change
        )

    @property
    def divergence(self) -> Array:
        """``g_ab (P, 3)`` [1/m] of every pair, written out."""
        return expanded(self.adjoint)[1]


@dataclass(frozen=True)
class Secondary:
    """Secondary particles and their coupling to the primaries.

    ``sampling``, four columns: gradient ``G_a(X_q)`` [1/m] and weight ``V_a W~_a(X_q)`` of every
    pair.  ``spreading``: the adjoint by primary particle, ``V_q G_a(X_q) / V_a`` and, when it was
    asked for, ``V_q V_a W~_a(X_q) / V_a``.  ``left_out``: pairs within their support that leave
    the body on their way.
    """

    X: Array
    V: Array
    sampling: PairOperator
    spreading: PairOperator
    left_out: int

    @property
    def pairs(self) -> PairList:
        """Who is seen from every secondary particle, written out."""
        return expanded(self.sampling)[0]

    @property
    def sample(self) -> Array:
        """Coefficients ``(P, 4)`` of :attr:`pairs`."""
        return expanded(self.sampling)[1]

    @property
    def spread_pairs(self) -> PairList:
        """Which secondary particles see a primary, written out."""
        return expanded(self.spreading)[0]

    @property
    def spread(self) -> Array:
        """Gradient coefficients ``(P, 3)`` of :attr:`spread_pairs`."""
        return expanded(self.spreading)[1][:, :3]


@dataclass(frozen=True)
class ConsistencyReport:
    """Largest residuals of the identities the operators should satisfy, all dimensionless.

    ``C0`` constants: ``dx |sum_a G_a|``; ``C1`` linears: ``|sum_a G_a (x) X_a - I|``; ``D0``
    divergence theorem of the force's gradient, over the largest area; ``SBP`` summation by parts:
    ``C + C^T - diag(A N)``, ``C_ab = V_a G_b(X_a)``, over the largest area; ``volume`` relative
    error of ``sum V``.
    """

    C0: float
    C1: float
    D0: float
    SBP: float
    volume: float

    def __str__(self) -> str:
        return (
            f"C0 {self.C0:.1e}, C1 {self.C1:.1e}, D0 {self.D0:.1e}, SBP {self.SBP:.1e}, "
            f"volume {self.volume:.1e}"
        )


def build_cloud(
    mesh: Mesh,
    *,
    smoothing: SmoothingFunction,
    h_over_dx: float,
    operator: OperatorKind,
    stencils: bool = True,
) -> Cloud:
    """Particles on the vertices of ``mesh`` with the operators of ``operator``.

    Pairs whose straight line leaves the body are none (``pairs.sight``).  ``stencils=False`` stores
    every particle's own pairs, as on an irregular cloud.  Raises ``InputError`` for a non-positive
    ``h_over_dx``, parts that overlap, or an operator that does not exist on this cloud.  It also
    refuses a support that is too small, naming the particle and the value to raise it to, and cells
    so long that the support spans the body with hundreds of neighbours.
    """
    require(
        np.isfinite(h_over_dx) and h_over_dx > 0.0,
        f"h_over_dx = {h_over_dx} must be positive; 0.77 is the default on a lattice",
    )
    X = mesh.vertices
    refuse_overlap("the body", mesh)
    sight = Sight.within(mesh)
    lengths = lengths_of(mesh, h_over_dx)
    layout, left_out = _layout(operator, mesh, sight, lengths, smoothing)
    V, pairs, by_tag = layout.volumes, layout.pairs, layout.areas
    areas = (
        np.sum(list(by_tag.values()), axis=0) if by_tag else area_vectors(mesh, mesh.boundary)
    )
    ingredients = Ingredients(mesh, V, areas, pairs, smoothing, lengths)
    gradients = gradients_of(operator, ingredients)
    refuse_wrong_gradients(operator, gradients, ingredients)
    made = WrittenOut(pairs, gradients)
    tables: PairTables
    if isinstance(operator, LatticeDifference):

        def again() -> WrittenOut:
            anew = operator.layout(mesh).pairs
            given = Ingredients(mesh, V, areas, anew, smoothing, lengths)
            return WrittenOut(anew, operator.build(given))

        tables = TablesOnDemand(again, made, V, stencils=stencils)
    else:
        tables = KeptTables(Packed.of(made, V, stencils=stencils))
    h_min = _h_min(X, pairs)
    return Cloud(
        mesh, X, V, gradients.areas, lengths, tables, smoothing, h_min,
        gradients.iterations, gradients.change, sight, left_out, int(parts_of(pairs).max()) + 1,
        operator, {name: csc_array(part) for name, part in by_tag.items()},
    )  # fmt: skip


def _layout(
    operator: OperatorKind, mesh: Mesh, sight: Sight, lengths: Lengths, smoothing: SmoothingFunction
) -> tuple[Layout, int]:
    """Volumes and pairs, and how many pairs within the support see nothing of each other."""
    if hasattr(operator, "layout"):
        made = operator.layout(mesh)
        refuse_wrong_layout(operator, made, mesh)
        return made, 0
    X, V = mesh.vertices, vertex_volumes(mesh)
    within = lengths.pairs(X, X, smoothing.support)
    refuse_long_cells(mesh, lengths, smoothing.support, within)
    pairs = sight.seen(X, within)
    check_support(
        X, X, pairs,
        h_over_dx=lengths.h_over_dx, support=smoothing.support, spacings=lengths.spacings(X),
        what="primary", hidden=sight.hidden,
    )  # fmt: skip
    return Layout(V, {}, pairs), (within.pairs - pairs.pairs) // 2


def _h_min(X: Array, pairs: PairList) -> float:
    distance = np.linalg.norm(offsets(X, X, pairs), axis=1)
    return float(np.min(distance[distance > 0.0]))


def build_secondary(
    cloud: Cloud,
    points: SecondaryPoints,
    *,
    adjoint_weight: bool = False,
    stencils: bool = True,
) -> Secondary:
    """Secondary particles of the cloud's mesh with the cloud's smoothing function."""
    X, V = points.place(cloud.mesh)
    lengths = cloud.lengths
    within = lengths.pairs(X, cloud.X, cloud.smoothing.support)
    pairs = cloud.sight.seen(X, within)
    check_support(
        X, cloud.X, pairs,
        h_over_dx=lengths.h_over_dx, support=cloud.smoothing.support,
        spacings=lengths.spacings(X), what=f"secondary ({points.name})",
        hidden=cloud.sight.hidden,
    )  # fmt: skip
    h = lengths.of_pairs(X, pairs)
    arguments = (X, cloud.X, cloud.V, pairs, cloud.smoothing, h)
    # Tensors that lie particle by particle are read pair by pair: runs of rows would be left out.
    stencils = stencils and not cloud.particle_major
    G = corrected_gradient(*arguments)
    weight = linear_interpolation(*arguments)
    sample = np.concatenate([G, weight[:, None]], axis=1)
    (sampling,) = pair_operators(pairs, [sample], cloud.size, stencils=stencils)
    spread_pairs, place = transposed(pairs, cloud.size)
    volume_of_pair = V[pairs.row_of_pair] / cloud.V[pairs.indices]
    columns = sample if adjoint_weight else G
    spread = (columns * volume_of_pair[:, None])[place]
    (spreading,) = pair_operators(spread_pairs, [spread], len(X), stencils=stencils)
    return Secondary(X, V, sampling, spreading, within.pairs - pairs.pairs)


def consistency_report(cloud: Cloud, exact_volume: float) -> ConsistencyReport:
    """Measure C0, C1, D0 and the volume of a cloud (see :class:`ConsistencyReport`)."""
    pairs, gradients = cloud.pairs, cloud.gradients
    d = offsets(cloud.X, cloud.X, pairs)
    C0 = C1 = 0.0
    for G in {id(G): G for G in (gradients.kinematic, gradients.force)}.values():
        C0 = max(C0, float(np.max(np.abs(row_sum(pairs, G)))) * cloud.spacing)
        linear = row_sum(pairs, d[:, :, None] * G[:, None, :])
        C1 = max(C1, float(np.max(np.abs(linear - np.eye(3)))))
    defect = divergence_defect(gradients.force, pairs, cloud.V, cloud.areas)
    area = float(np.max(np.linalg.norm(cloud.areas, axis=1)))
    return ConsistencyReport(
        C0=C0,
        C1=C1,
        D0=float(np.max(np.abs(defect))) / area,
        SBP=skewness_defect(gradients.force, pairs, cloud.V, cloud.areas),
        volume=abs(float(np.sum(cloud.V)) / exact_volume - 1.0),
    )
