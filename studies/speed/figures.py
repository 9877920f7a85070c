"""One figure: the passes of a step, and what the machine itself would need for each."""

from __future__ import annotations

import matplotlib.pyplot as plt

from studies.harness.results import Results
from studies.report.document import Figure
from studies.report.plotting import save_figure


def passes_figure(results: Results) -> Figure:
    """Bars of the default evaluation's passes on all threads; a tick is the machine's limit."""
    table = results.tables["passes"]
    table = table[table["threads"] == table["threads"].max()]
    first = table.iloc[0]
    same = (table["weighting"] == first["weighting"]) & (table["cloud"] == first["cloud"])
    same &= (table["formulation"] == first["formulation"])
    same &= (table["particles"] == first["particles"])
    shown = table[same].drop_duplicates("pass")[::-1]
    fig, axes = plt.subplots(figsize=(6.4, 2.8), layout="constrained")
    y = range(len(shown))
    limit = shown["ns_per_particle"] * shown["roofline_share"]
    axes.barh(y, shown["ns_per_particle"], color="#4c78a8", height=0.6, label="measured")
    axes.barh(y, limit, color="#f58518", height=0.6, label="the machine's limit")
    axes.set_yticks(list(y), list(shown["pass"]))
    axes.set_xlabel("ns a particle")
    for k, (value, share) in enumerate(
        zip(shown["ns_per_particle"], shown["roofline_share"], strict=True)
    ):
        axes.text(value, k, f"  {value:.0f} ns, {share:.0%}", va="center", fontsize=8)
    axes.set_xlim(0, 1.3 * float(shown["ns_per_particle"].max()))
    axes.legend(frameon=False, loc="lower right")
    axes.spines[["top", "right"]].set_visible(False)
    caption = (
        f"Passes of one evaluation, {first['formulation']} {first['weighting']}, "
        f"{first['particles']} particles, {first['threads']} threads. The machine's limit is the "
        "larger of the compulsory traffic over the bandwidth and the operations over the "
        "arithmetic measured in the same run."
    )
    stem = save_figure(fig, results.out / "passes")
    plt.close(fig)
    return Figure(caption, stem)

