"""What the report says of the free vibration and the short pulse."""

from __future__ import annotations

from studies.harness.results import Results
from studies.report.document import Block, Figure, Section, Table
from studies.stability.waves import vibration_figure

_VIBRATION = {
    "method": "", "nu": "g", "cells": "g", "energy_left": ".4f", "damping_ratio": ".1e",
    "omega": ".2f", "omega_reference": ".2f", "omega_finest": ".2f", "frequency_error": "+.2%",
}  # fmt: skip
_PULSE = {
    "method": "", "nu": "g", "energy_left": ".3f", "error": ".0%", "lag": ".2f", "width": ".2f",
    "width_reference": ".2f",
}  # fmt: skip
_WAVE_HEADINGS = {
    "energy_left": "left", "damping_ratio": "damping", "omega_reference": "limit",
    "omega_finest": "finest", "frequency_error": "off by", "error": "off", "lag": "late",
    "width_reference": "exact width",
}  # fmt: skip


def wave_sections(results: Results) -> list[Section]:
    """One section, or none where nothing was run."""
    vibration, pulse = results.tables["vibration"], results.tables["pulse"]
    blocks: list[Block] = []
    if len(vibration):
        blocks += [
            Figure(
                "A clamped block in its lowest bending mode, ten periods: energy left, and error "
                "of the frequency against the limit of quadratic finite elements. A sound method "
                "has 100 and 0.",
                vibration_figure(vibration, results.out),
            ),
            Table(
                "The vibration. left: energy at the end over that at the start; limit: of three "
                "meshes of quadratic elements, rad/s; finest: of the finest of them.",
                vibration[list(_VIBRATION)], formats=_VIBRATION, headings=_WAVE_HEADINGS,
            ),
        ]  # fmt: skip
    if len(pulse):
        blocks.append(
            Table(
                "A velocity pulse three spacings wide at half its height, after 24 spacings along "
                "a bar held at its sides. off: root mean square difference from the exact "
                "(d'Alembert's) velocity over that; late: how far the centre of its energy is "
                "behind, and its width, in spacings.",
                pulse[list(_PULSE)], formats=_PULSE, headings=_WAVE_HEADINGS,
            )
        )  # fmt: skip
    return [Section("Free vibration and a short pulse", blocks)] if blocks else []
