"""Which laws there are, and the form in which kernels meet them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sphsolid.compiled import inlined
from sphsolid.continuum.law_source import LawSource, is_ours
from sphsolid.continuum.law_types import kernel_type
from sphsolid.continuum.quadratic_volume import QUADRATIC
from sphsolid.continuum.volumetric import FromEnergy, Function, Volumetric, volumetric_of
from sphsolid.errors import InputError, require


@dataclass(frozen=True)
class Law:
    """The functions of a law; ``stated`` is its own ``U``, ``volumetric`` the one that is used."""

    energy: Function
    conjugate_stresses: Function
    first_piola: Function
    hessian_action: Function
    stated: Volumetric | FromEnergy
    volumetric: Volumetric

    @property
    def is_quadratic(self) -> bool:
        """True where ``U'`` is known to be linear in ``J``."""
        return self.volumetric == QUADRATIC


_LAWS: dict[type, Law] = {}
_IN_KERNELS: dict[str, type] = {}


def _law(functions: dict[str, Function], stated: Volumetric | FromEnergy) -> Law:
    """A law that kernels can call."""
    if isinstance(stated, FromEnergy):
        volumetric = volumetric_of(
            functions["energy"], functions["conjugate_stresses"], functions["hessian_action"]
        )
    else:
        volumetric = stated
    return Law(**functions, stated=stated, volumetric=volumetric)


def register_law(
    parameters: type,
    *,
    energy: Function,
    conjugate_stresses: Function,
    first_piola: Function,
    hessian_action: Function,
    volumetric: tuple[Function, Function, Function] | FromEnergy = FromEnergy(),  # noqa: B008
) -> None:
    """Make a law known to the generic functions under the type of its parameters.

    ``parameters`` is a ``NamedTuple`` class with at least ``mu``, ``kappa`` [Pa], ``density``
    [kg/m^3] and ``depends_on_H`` (fields or properties).  ``volumetric`` are ``U, U', U''``, each a
    function of ``(parameters, J)``; without it the law's energy is asked at pure changes of volume.
    Raises ``InputError``.
    """
    name = getattr(parameters, "__name__", repr(parameters))
    require(
        isinstance(parameters, type)
        and issubclass(parameters, tuple)
        and hasattr(parameters, "_fields"),
        f"register_law: {name} is no class of parameters; write `class {name}(NamedTuple)` with "
        "fields that are numbers",
    )
    given = {
        "energy": energy,
        "conjugate_stresses": conjugate_stresses,
        "first_piola": first_piola,
        "hessian_action": hessian_action,
    }
    for which, function in given.items():
        require(callable(function), f"register_law: {which} = {function!r} is no function")
    if not isinstance(volumetric, FromEnergy):
        is_triple = isinstance(volumetric, tuple) and len(volumetric) == 3
        require(
            is_triple and all(callable(function) for function in volumetric),
            f"register_law: volumetric = {volumetric!r} of {name} must be three functions of "
            "(parameters, J): (U, dU, ddU), the volumetric energy and its two derivatives",
        )
        volumetric = Volumetric(*map(_python, volumetric))
    functions = {which: _python(function) for which, function in given.items()}
    law = _law(functions, volumetric)
    _LAWS[parameters] = law
    _compilable(law)


def _python(function: Function) -> Function:
    """The Python function of one that numba already compiles."""
    return getattr(function, "py_func", function)


def _compilable(law: Law) -> None:
    for function in (
        *(law.energy, law.conjugate_stresses, law.first_piola, law.hessian_action),
        *law.volumetric,
    ):
        inlined(function)


def law_of(kind: type) -> Law:
    """The law registered for a type of parameters; raises ``InputError`` for any other."""
    law = _LAWS.get(kind)
    if law is None:
        raise InputError(
            f"{getattr(kind, '__name__', kind)} is no registered constitutive law: use "
            "NeoHookean.from_young(...) or MooneyRivlin.from_young(...), or register a law of "
            "your own with sphsolid.continuum.law.register_law (docs/laws.md)"
        )
    return law


def in_kernels(material: Any) -> Any:
    """The parameters as an instance of the type that kernels are compiled for.

    For a law of this package that is ``material`` itself.  For any other the type is new whenever
    something that makes up the law has changed.  So neither a kernel in memory nor one on disk can
    be older than the law: see ``law_source`` and ``law_types``.  What comes back is the law as it
    is now, for kernels and for plain Python.  Nothing done to the law's text, constants or class
    afterwards changes it.  Raises ``InputError`` where the law reads what cannot be followed.
    """
    kind = type(material)
    law = law_of(kind)
    if is_ours(kind):
        return material
    source = LawSource(kind.__name__)
    source.note(kind.__name__, kind._fields)
    attributes = source.attributes(kind)
    functions = {
        which: source.read(getattr(law, which))
        for which in ("energy", "conjugate_stresses", "first_piola", "hessian_action")
    }
    stated = law.stated
    if not isinstance(stated, FromEnergy):
        stated = Volumetric(*map(source.read, stated))
    digest = source.digest
    if digest not in _IN_KERNELS:
        source.compilable()
        made = kernel_type(digest, kind, attributes, _again)
        _LAWS[made] = _law(functions, stated)
        _compilable(_LAWS[made])
        _IN_KERNELS[digest] = made
    return tuple.__new__(_IN_KERNELS[digest], material)


def _again(parameters: type, values: tuple[Any, ...]) -> Any:
    return in_kernels(tuple.__new__(parameters, values))
