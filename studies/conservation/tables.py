"""How tables of the conservation study are printed: formats, headings, names of runs."""

from __future__ import annotations

import pandas as pd

from studies.report.document import Table

_SCIENTIFIC = dict.fromkeys(
    ("linear", "angular_free", "angular_step", "angular_total", "linear_total", "linear_step",
     "impulse_gap", "rest", "left_over", "rest_end", "projection_work", "measured", "wanted"),
    ".1e",
)  # fmt: skip
FORMATS = _SCIENTIFIC | {
    "energy_kept": ".4f", "dissipated": ".4f", "noise": ".3f", "cfl": "g", "spacing": "g",
    "h_over_dx": "g", "tau_F": "g", "xi_F": "g", "tau_p": "g", "jitter": "g", "load": "g",
    "until": "g", "spin": "g", "lost_at": ".2f", "order": ".2f", "order_left_over": ".2f",
    "turns": "g",
}  # fmt: skip


def named(runs: pd.DataFrame, *names: str) -> pd.DataFrame:
    """``runs`` with a column ``run``: the words of ``names`` that say something."""
    words = [
        " ".join(word for word in row if word not in ("-", "TVD-RK2", "as printed", "SUPG-SPH"))
        for row in runs[list(names)].itertuples(index=False)
    ]
    return runs.assign(run=words)


def table_of(caption: str, frame: pd.DataFrame, columns: dict[str, str]) -> Table:
    """``columns`` of a frame, each under its heading."""
    return Table(caption, frame[list(columns)], formats=FORMATS, headings=columns)
