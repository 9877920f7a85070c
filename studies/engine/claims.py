"""A claim: what is said of a method, the number that decides it, and the verdict.

``Claim("order of the displacement", measured=1.98, comparison=">=", asked=1.9)`` is met.  A claim
about several runs has a mapping of their names to numbers, and holds in part where some do.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import pandas as pd

from sphsolid.errors import require

#: Who says so: the paper, or whoever asked for the study.  The words of a verdict follow.
Source = Literal["paper", "asked"]
Comparison = Literal["<=", "<", ">=", ">", "within", "reported"]
Number = float | Mapping[str, float]

_WORDS: dict[Source, tuple[str, str, str]] = {
    "paper": ("reproduced", "reproduced in part", "not reproduced"),
    "asked": ("met", "met in part", "not met"),
}
NOT_EXAMINED, REPORTED = "not examined", "reported"
#: Verdicts as a report lists them: what does not hold comes first.
FIRST = (
    "not reproduced", "not met", "reproduced in part", "met in part", NOT_EXAMINED, REPORTED,
    "reproduced", "met",
)  # fmt: skip
#: Digits that are added at most where a rounded number would hold and the number does not.
MORE_DIGITS = 4
_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "<=": operator.le, "<": operator.lt, ">=": operator.ge, ">": operator.gt,
}  # fmt: skip


@dataclass(frozen=True)
class Claim:
    """``what`` is claimed, and ``measured comparison asked`` decides.

    ``measured`` is a number, or numbers by name; one that is nan does not hold.  ``asked`` is one
    number for all, a pair with ``within``, or numbers by the same names.  With ``in_part`` a number
    that fails ``asked`` but holds against ``in_part`` holds in part.  ``sound`` is False where the
    run cannot show it (its positions folded), or says so by name.  ``incomplete`` says what was not
    run: then the claim holds in part at most.  ``said`` and ``wanted`` replace the numbers in the
    report, ``where`` names the run, ``format`` and ``unit`` are those of the numbers.
    """

    what: str
    measured: Number
    comparison: Comparison = "reported"
    asked: Number | tuple[float, float] = math.nan
    source: Source = "asked"
    where: str = ""
    in_part: float | None = None
    sound: bool | Mapping[str, bool] = True
    incomplete: str = ""
    said: str = ""
    wanted: str = ""
    format: str = ".3g"
    unit: str = ""

    def __post_init__(self) -> None:
        """Raise ``InputError`` where nothing could be compared."""
        names, asked = set(self._parts()), self.asked
        require(
            isinstance(asked, tuple) == (self.comparison == "within"),
            f"claim {self.what!r}: a pair of asked numbers goes with 'within' and with nothing "
            f"else, got {asked} with {self.comparison!r}",
        )
        for what, given in (("asked", asked), ("sound", self.sound)):
            require(
                not isinstance(given, Mapping) or set(given) == names,
                f"claim {self.what!r}: {what} must name what is measured ({', '.join(names)})",
            )
        require(
            self.comparison == "reported" or isinstance(asked, tuple | Mapping) or asked == asked,
            f"claim {self.what!r}: {self.comparison!r} needs the number that is asked for",
        )

    @classmethod
    def counted(cls, what: str, hold: int, of: int, **more: object) -> Claim:
        """``hold`` of ``of`` runs do: all, some or none; nothing was examined where ``of`` is 0."""
        names = {str(number): float(number < hold) for number in range(of)}
        words = {"said": f"{hold} of {of}", "wanted": "all"} | more
        return cls(what, names, ">=", 1.0, **words)  # type: ignore[arg-type]

    @classmethod
    def graded(cls, what: str, *, whole: bool, part: bool, **more: object) -> Claim:
        """All of it or a ``part``, by a rule of several numbers, which ``said`` gives."""
        grade = 2.0 if whole else float(part)
        return cls(what, grade, ">=", 2.0, in_part=1.0, **more)  # type: ignore[arg-type]

    def holds(self) -> dict[str, bool]:
        """Which parts of the claim hold, by name."""
        return {name: self._is_sound(name) and self._meets(name) for name in self._parts()}

    @property
    def verdict(self) -> str:
        """All, some or none of it, in the words of the source."""
        if self.comparison == "reported":
            return REPORTED
        parts = self.holds()
        if not parts:
            return NOT_EXAMINED
        yes, partly, no = _WORDS[self.source]
        if all(parts.values()):
            return partly if self.incomplete else yes
        return partly if any(parts.values()) or self._nearly() else no

    @property
    def shown(self) -> str:
        """The measured numbers as a report says them."""
        parts = self._parts()
        text = self.said
        if not text and set(parts) == {""}:
            text = self._measured_number("")
        elif not text:
            text = ", ".join(f"{name} {self._measured_number(name)}" for name in parts)
        if "folded" not in text:
            hidden = [name for name in parts if not self._is_sound(name) and self._meets(name)]
            names = ", ".join(filter(None, hidden))
            text += f"; folded or diverged{f': {names}' if names else ''}" if hidden else ""
        return f"{text}; {self.incomplete}" if self.incomplete else text

    @property
    def limit(self) -> str:
        """What was asked, as a report says it."""
        if self.wanted or self.comparison == "reported":
            return self.wanted or "-"
        if isinstance(self.asked, tuple):
            low, high = (self._number(end) for end in self.asked)
            return f"{low} to {high}"
        sign = {"<=": "at most", "<": "less than", ">=": "at least", ">": "more than"}
        if isinstance(self.asked, Mapping):
            return ", ".join(
                f"{name} {sign[self.comparison]} {self._number(value)}"
                for name, value in self.asked.items()
            )
        return f"{sign[self.comparison]} {self._number(self.asked)}"

    def _parts(self) -> Mapping[str, float]:
        return self.measured if isinstance(self.measured, Mapping) else {"": self.measured}

    def _is_sound(self, name: str) -> bool:
        return self.sound if isinstance(self.sound, bool) else self.sound[name]

    def _meets(self, name: str) -> bool:
        """By the number alone, whether or not the run can show it."""
        return self._would_meet(self._parts()[name], name)

    def _would_meet(self, value: float, name: str) -> bool:
        if math.isnan(value) or self.comparison == "reported":
            return False
        if isinstance(self.asked, tuple):
            return self.asked[0] <= value <= self.asked[1]
        asked = self.asked[name] if isinstance(self.asked, Mapping) else self.asked
        return _COMPARE[self.comparison](value, asked)

    def _nearly(self) -> bool:
        if self.in_part is None:
            return False
        sound = self.sound if isinstance(self.sound, bool) else all(self.sound.values())
        values = self._parts().values()
        return sound and all(_COMPARE[self.comparison](value, self.in_part) for value in values)

    def _measured_number(self, name: str) -> str:
        """With as many digits as it takes to come to the same verdict from what is read."""
        value = self._parts()[name]
        if math.isnan(value) or self.comparison == "reported":
            return self._number(value)
        for form in _finer(self.format):
            if self._would_meet(_read(format(value, form)), name) == self._meets(name):
                break
        return self._number(value, form)

    def _number(self, value: float, form: str = "") -> str:
        if math.isnan(value):
            return "-"
        return format(value, form or self.format) + (f" {self.unit}" if self.unit else "")


def _finer(form: str) -> list[str]:
    """A format, and the same with up to :data:`MORE_DIGITS` more digits."""
    digits = int("".join(filter(str.isdigit, form.partition(".")[2])))
    return [form.replace(f".{digits}", f".{digits + more}") for more in range(MORE_DIGITS + 1)]


def _read(text: str) -> float:
    return float(text[:-1]) / 100.0 if text.endswith("%") else float(text)


def claims_table(claims: Sequence[Claim], *, worst_first: bool = True) -> pd.DataFrame:
    """One row a claim: ``claim, source, where, measured, asked, verdict``."""
    rows = [
        {
            "claim": claim.what, "source": claim.source, "where": claim.where,
            "measured": claim.shown, "asked": claim.limit, "verdict": claim.verdict,
        }
        for claim in claims
    ]  # fmt: skip
    names = [row["claim"] + row["where"] for row in rows]
    repeated = sorted({name for name in names if names.count(name) > 1})
    require(not repeated, f"claims repeat: {', '.join(repeated)}; name what tells them apart")
    columns = ["claim", "source", "where", "measured", "asked", "verdict"]
    table = pd.DataFrame(rows, columns=columns)
    if not worst_first:
        return table
    return table.sort_values(
        "verdict", key=lambda verdicts: verdicts.map(FIRST.index), kind="stable", ignore_index=True
    )
