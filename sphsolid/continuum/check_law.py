"""Does a law say one thing?  Its functions against one another, before a kernel trusts them.

The energy is taken at its word and everything else compared with its differences: fourth-order
central differences of step 1e-3, good to about 1e-10 of the larger modulus, in plain NumPy.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum import law
from sphsolid.continuum.compiles import require_compilable
from sphsolid.continuum.law_registry import in_kernels, law_of
from sphsolid.continuum.moduli import first_lame
from sphsolid.continuum.tensor import IDENTITY, add, axpy, cofactor, cross, determinant, join, split
from sphsolid.errors import InputError, require

Array = NDArray[np.float64]
_STEP = 1.0e-3
_OFFSETS = np.array([-2.0, -1.0, 1.0, 2.0])
_WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
#: Allowed difference over ``mu + kappa`` and over the value itself.
_TOLERANCE = 1.0e-7
#: Jacobians at which the volumetric energy is looked at; the first is the undeformed state.
_J = np.array([1.0, 0.7, 0.9, 1.1, 1.4])
_ENTRIES = [f"{name}{i}{k}" for name in "FH" for i in "123" for k in "123"] + ["J"]
_CHECKED: dict[tuple[Any, ...], tuple[str, str]] = {}


def _deformations() -> Array:
    """The undeformed state and four others, ``J`` between 0.7 and 1.5."""
    rng = np.random.default_rng(1)
    F = np.eye(3) + 0.25 * rng.uniform(-1.0, 1.0, (4, 3, 3))
    F *= (np.array([0.75, 0.95, 1.1, 1.4]) / np.linalg.det(F))[:, None, None] ** (1.0 / 3.0)
    return np.concatenate([np.eye(3)[None], F])


_F = _deformations()


def require_law(material: Any, what: str = "material") -> None:
    """Raise ``InputError`` unless ``material`` is a set of parameters of a registered law."""
    if isinstance(material, type):
        raise InputError(
            f"{what} = {material.__name__} is a class, not a set of parameters; write "
            f"{material.__name__}(...) with its moduli and density"
        )
    try:
        law_of(type(material))
    except InputError as unknown:
        raise InputError(f"{what} = {material!r}: {unknown}") from None


def check_law(material: Any) -> None:
    """Raise ``InputError`` where the functions of a law contradict one another; else nothing.

    The parameters: ``mu``, ``kappa`` [Pa] and ``density`` [kg/m^3] positive.  Every function takes
    numbers and arrays alike.  No stress in the undeformed state.  ``conjugate_stresses`` is the
    gradient of ``energy`` in ``F, H, J``, ``first_piola`` what follows from it, ``hessian_action``
    its derivative; ``depends_on_H`` is true where the energy does.  ``W(Q F, Q H, J) = W(F, H, J)``
    for a rotation ``Q``.  ``U(J)`` is the energy of a pure change of volume, ``U'`` and ``U''`` its
    derivatives, ``U''(1) = kappa``; small strains find ``lambda = kappa - 2/3 mu`` and ``mu``.

    Both solvers run :func:`check_first_use`, which is this, once, with a milder end.
    """
    contradiction, moduli = _verdict(material)
    if contradiction or moduli:
        raise InputError(contradiction or moduli)


def check_first_use(material: Any) -> Any:
    """:func:`check_law` when a solver meets a law; remembered.  Returns ``in_kernels(material)``.

    Kernels must be able to compile a law of the user's own (``compiles``).
    A law whose ``mu`` or ``kappa`` is not the stiffness of its energy may run: solvers ask the law
    for its wave speed.  Its stabilisation goes by the parameters, and one warning says so.
    """
    contradiction, moduli = _verdict(material)
    if contradiction:
        raise InputError(contradiction)
    if moduli:
        warnings.warn(
            f"{moduli}; the time step follows the energy, stabilisation the parameters",
            stacklevel=3,
        )
    frozen = in_kernels(material)
    require_compilable(frozen)
    return frozen


def _verdict(material: Any) -> tuple[str, str]:
    """What the functions, and what the moduli are said to do wrong; empty where nothing."""
    require_law(material)
    try:
        key = (type(in_kernels(material)), *material)
        known = _CHECKED.get(key)
    except TypeError:
        raise InputError(
            f"law {type(material).__name__}: its parameters {tuple(material)} must be numbers"
        ) from None
    if known is None:
        with np.errstate(all="ignore"):
            judge = _Judge(material)
            contradiction = _refusal(judge.functions)
            known = contradiction, "" if contradiction else _refusal(judge.moduli)
        _CHECKED[key] = known
    return known


def _refusal(judgement: Callable[[], None]) -> str:
    try:
        judgement()
    except InputError as failure:
        return str(failure)
    return ""


class _Judge:
    def __init__(self, material: Any) -> None:
        self.m = material
        self.name = f"law {type(material).__name__}"
        self.F = split(_F)
        self.H = cofactor(self.F)
        self.J = determinant(self.F)
        self.point = np.column_stack([*self.F, *self.H, self.J])
        self.scale = 1.0

    def functions(self) -> None:
        """Everything but the moduli."""
        self.parameters()
        self.numbers_and_arrays()
        self.rest()
        self.gradient()
        self.stress()
        self.hessian()
        self.rotation()
        self.volume()

    def parameters(self) -> None:
        for parameter in ("mu", "kappa", "density"):
            value = getattr(self.m, parameter, None)
            require(
                isinstance(value, int | float | np.number) and bool(0.0 < value < np.inf),
                f"{self.name}: {parameter} = {value!r} must be a positive, finite number, a field "
                "or a property of the parameters",
            )
        require(
            "density" in self.m._fields,
            f"{self.name}: density must be a field of the parameters; kernels see no properties",
        )
        require(
            isinstance(getattr(self.m, "depends_on_H", None), bool | np.bool_),
            f"{self.name}: depends_on_H must be True or False: does the energy depend on H?",
        )
        self.scale = float(self.m.mu + self.m.kappa)

    def numbers_and_arrays(self) -> None:
        dF, dH, dJ = split(_F[::-1]), split(_F[::-1] ** 2), self.J[::-1]
        for function, arguments in (
            (law.energy, (self.F, self.H, self.J)),
            (law.conjugate_stresses, (self.F, self.H, self.J)),
            (law.first_piola, (self.F, self.H, self.J)),
            (law.hessian_action, (self.F, self.H, self.J, dF, dH, dJ)),
            (law.volumetric_energy, (self.J,)),
            (law.volumetric_pressure, (self.J,)),
            (law.volumetric_stiffness, (self.J,)),
        ):
            self._both_ways(function, arguments)

    def _both_ways(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        what = f"{self.name}: {function.__name__}"
        try:
            together = _flat(function(self.m, *arguments), len(_F))
        except Exception as failure:
            raise InputError(
                f"{what} fails for arrays ({type(failure).__name__}: {failure}); it must take "
                "numbers and NumPy arrays alike: use + - * / **, np.log, np.sqrt"
            ) from failure
        for a in range(len(_F)):
            one = tuple(
                tuple(float(entry[a]) for entry in x) if isinstance(x, tuple) else float(x[a])
                for x in arguments
            )
            try:
                alone = _flat(function(self.m, *one), 1)[:, 0]
            except Exception as failure:
                raise InputError(
                    f"{what} fails for numbers ({type(failure).__name__}: {failure})"
                ) from failure
            require(
                alone.shape == together[:, a].shape,
                f"{what} returns {len(alone)} numbers for one state, {len(together)} for several",
            )
            require(
                bool(np.all(np.isfinite(alone))),
                f"{what} is not finite at {_state(a)}",
            )
            self._agree(
                f"{function.__name__} of an array", together[:, a], alone,
                f"{function.__name__} of the numbers in it", a,
            )  # fmt: skip

    def rest(self) -> None:
        P = np.array(law.first_piola(self.m, IDENTITY, IDENTITY, 1.0))
        self._agree("first_piola in the undeformed state", P, np.zeros(9), "no stress", 0)

    def gradient(self) -> None:
        expected = self._differences(lambda F, H, J: _flat(law.energy(self.m, F, H, J), len(J)))
        S_F, S_H, S_J = law.conjugate_stresses(self.m, self.F, self.H, self.J)
        found = _flat((*S_F, *S_H, S_J), len(_F))
        for a in range(len(_F)):
            for entry, name in enumerate(_ENTRIES):
                self._agree(
                    f"conjugate_stresses, entry dW/d{name}", found[entry, a],
                    expected[entry, 0, a], "the derivative of energy", a,
                )  # fmt: skip
        if not self.m.depends_on_H:
            self._agree(
                "depends_on_H is False but dW/dH", found[9:18].ravel(), np.zeros(9 * len(_F)),
                "zero", 1,
            )  # fmt: skip

    def stress(self) -> None:
        S_F, S_H, S_J = law.conjugate_stresses(self.m, self.F, self.H, self.J)
        expected = _flat(axpy(S_J, self.H, add(S_F, cross(S_H, self.F))), len(_F))
        found = _flat(law.first_piola(self.m, self.F, self.H, self.J), len(_F))
        for a in range(len(_F)):
            self._agree(
                "first_piola", found[:, a], expected[:, a], "Sigma_F + Sigma_H x F + Sigma_J H", a
            )

    def hessian(self) -> None:
        def stresses(F: Any, H: Any, J: Any) -> Array:
            S_F, S_H, S_J = law.conjugate_stresses(self.m, F, H, J)
            return _flat((*S_F, *S_H, S_J), len(J))

        expected = self._differences(stresses)
        for entry, name in enumerate(_ENTRIES):
            along = np.zeros((19, len(_F)))
            along[entry] = 1.0
            F, H, J = tuple(along[:9]), tuple(along[9:18]), along[18]
            dS_F, dS_H, dS_J = law.hessian_action(self.m, self.F, self.H, self.J, F, H, J)
            found = _flat((*dS_F, *dS_H, dS_J), len(_F))
            for a in range(len(_F)):
                self._agree(
                    f"hessian_action along {name}", found[:, a], expected[entry, :, a],
                    "the derivative of conjugate_stresses", a,
                )  # fmt: skip

    def rotation(self) -> None:
        Q = np.array([[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]]) / 3.0
        QF, QH = split(Q @ join(self.F)), split(Q @ join(self.H))
        before = law.energy(self.m, self.F, self.H, self.J)
        after = law.energy(self.m, QF, QH, self.J)
        for a in range(len(_F)):
            self._agree(
                "energy of a rotated state W(QF, QH, J)", after[a], before[a], "W(F, H, J)", a
            )

    def volume(self) -> None:
        a = np.cbrt(_J)
        F, H = (tuple(b * entry for entry in IDENTITY) for b in (a, a * a))
        rest = law.energy(self.m, IDENTITY, IDENTITY, 1.0)
        U, dU, ddU = (
            _flat(f(self.m, _J), len(_J))[0]
            for f in (law.volumetric_energy, law.volumetric_pressure, law.volumetric_stiffness)
        )
        near = _J[:, None] + _STEP * _OFFSETS
        stated = "U, the first of `volumetric`,"
        self._at_J(stated, U, law.energy(self.m, F, H, _J) - rest, "W(J^(1/3) I) - W(I)")
        for what, found, f in (
            ("U', the second of `volumetric`,", dU, law.volumetric_energy),
            ("U'', the third of `volumetric`,", ddU, law.volumetric_pressure),
        ):
            slope = np.array([np.broadcast_to(f(self.m, J), 4) @ _WEIGHTS for J in near]) / _STEP
            self._at_J(what, found, slope, "the derivative of the one before")

    def moduli(self) -> None:
        ddU = law.volumetric_stiffness(self.m, 1.0)
        self._agree("kappa", self.m.kappa, ddU, "U''(1), the bulk modulus of energy", 0)
        mu, lam = float(self.m.mu), first_lame(float(self.m.mu), float(self.m.kappa))
        for name, i, k in (("12", 0, 1), ("13", 0, 2), ("23", 1, 2), ("21", 1, 0)):
            dF = np.zeros((3, 3))
            dF[i, k] = 1.0
            dP = np.array(law.tangent_action(self.m, IDENTITY, split(dF))).reshape(3, 3)
            self._agree(
                f"mu in shear {name} (all laws are taken as isotropic at rest)", mu,
                dP[i, k], "the stiffness of energy", 0,
            )  # fmt: skip
        for i in range(3):
            dF = np.zeros((3, 3))
            dF[i, i] = 1.0
            dP = np.array(law.tangent_action(self.m, IDENTITY, split(dF))).reshape(3, 3)
            self._agree(
                f"lambda + 2 mu of the parameters along axis {i + 1}", lam + 2.0 * mu, dP[i, i],
                "the stiffness of energy", 0,
            )  # fmt: skip

    def _differences(self, f: Callable[[Any, Any, Any], Array]) -> Array:
        """Derivatives ``(19, values, states)`` of ``f`` with respect to ``F``, ``H`` and ``J``."""
        moved = np.repeat(self.point[None, None], 19, axis=0).repeat(4, axis=1)
        for entry in range(19):
            moved[entry, :, :, entry] += _STEP * _OFFSETS[:, None]
        columns = moved.reshape(-1, 19).T
        values = f(tuple(columns[:9]), tuple(columns[9:18]), columns[18])
        shaped = values.reshape(len(values), 19, 4, len(_F))
        return np.einsum("veos,o->evs", shaped, _WEIGHTS) / _STEP

    def _at_J(self, what: str, found: Array, expected: Array, which: str) -> None:
        for j, J in enumerate(_J):
            self._agree(f"{what} at J = {J}", found[j], expected[j], which, -1)

    def _agree(self, what: str, found: Any, expected: Any, which: str, state: int) -> None:
        found, expected = np.atleast_1d(found), np.atleast_1d(expected)
        off = np.abs(found - expected)
        allowed = _TOLERANCE * (self.scale + np.abs(expected))
        if np.all(off <= allowed):
            return
        worst = int(np.argmax(np.where(np.isnan(off), np.inf, off / allowed)))
        value, right = float(found[worst]), float(expected[worst])
        share = abs(value - right) / abs(right) if right != 0.0 else np.inf
        by = f"off by {share:.2g} of it" if np.isfinite(share) else f"off by {value - right:.3g} Pa"
        where = f" at {_state(state)}" if state >= 0 else ""
        raise InputError(
            f"{self.name}: {what} is {value:.6g}, but {which} is {right:.6g}{where} ({by}); "
            "correct the law, or its parameters mu and kappa (docs/laws.md)"
        )


def _flat(values: Any, count: int) -> Array:
    """Nested tuples of numbers or arrays as rows ``(values, count)``."""
    if isinstance(values, tuple):
        return np.concatenate([_flat(value, count) for value in values])
    return np.broadcast_to(np.asarray(values, dtype=float), (count,))[None]


def _state(a: int) -> str:
    return "F = I" if a == 0 else f"F = {np.round(_F[a], 3).tolist()}"
