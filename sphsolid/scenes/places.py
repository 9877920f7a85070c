"""Names and places that belong to a problem: a dict that nobody changes."""

from __future__ import annotations

from typing import Any, NoReturn

from sphsolid.errors import InputError

Place = tuple[float, float, float]


class Places(dict[str, Place]):
    """A ``dict`` in every way but one: after it was made, changing it raises ``InputError``.

    It is equal to a ``dict`` of the same places and reads like one; a copy, by ``dict(...)``,
    ``|`` or ``copy()``, is a ``dict`` that may be changed.
    """

    def _refuse(self, *arguments: Any, **named: Any) -> NoReturn:
        raise InputError(
            "the probes of a scene cannot be changed, since every recorder and both solvers read "
            "them; make another scene: dataclasses.replace(scene, probes=scene.probes | {...})"
        )

    __setitem__ = __delitem__ = __ior__ = _refuse
    update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        """Made anew from its places, since it cannot be filled."""
        return Places, (dict(self),)
