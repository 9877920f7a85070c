"""The report: verdicts, noise by cloud, pictures, how it was measured."""

from __future__ import annotations

from studies.harness.results import Results
from studies.punch_cloud.bodies import JITTER
from studies.punch_cloud.figures import noise_figure, pressure_figure
from studies.punch_cloud.verdicts import SMOOTH, TOLERANCE, verdicts
from studies.report.document import Document, Figure, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run


def report(results: Results) -> Document:
    """Everything from the tables, and the pictures of the run if they are still there."""
    table = results.tables["table"]
    shots = results.out / "shots"
    pictures = [
        Figure(
            f"Pressure on the face Y = 0 at the end, {cells} cells a metre, first seed. The lines "
            "are the facets of that face; points have only a surface, no mesh.",
            pressure_figure(results, shots, int(cells), results.out / f"pressure_{cells}"),
        )
        for cells in sorted(table["cells"].unique())
    ]
    noise = noise_figure(results, results.out / "noise")
    columns = ["cells", "cloud", "stabilisation", "method", "particles", "secondary", "seeds",
               "survived", "noise", "noise_in_rows", "against_H1"]  # fmt: skip
    others = ["cells", "cloud", "stabilisation", "p_low", "p_high", "top_low", "top_high",
              "missed_momentum", "setup_s", "wall_s"]  # fmt: skip
    return Document(
        title="The punch on points without a mesh",
        subtitle=subtitle(results.run),
        abstract=(
            "A nearly incompressible block (nu = 0.499) as points and a closed surface, with "
            "secondary particles from agglomerated Delaunay cells, against hexahedra with H1 on "
            "the same points: {p,F,J}, all else but what is named at its default."
        ),
        sections=[
            Section(
                "Asked and met",
                [
                    Table(
                        f"Noise: mean over time and seeds. Asked: at most {100 * TOLERANCE:g} % "
                        f"above H1; smooth, at most {SMOOTH:g} of that without stabilisation, is "
                        "our threshold.",
                        verdicts(results.tables),
                    )
                ],
            ),
            Section(
                "By cloud",
                [
                    Table(
                        "Means over the seeds. against_H1: noise over that of H1 (without "
                        "stabilisation: of the same on hexahedra) on the points of the same seed, "
                        "less one. noise_in_rows: the indicator of the punch study, along rows "
                        "of hexahedra.",
                        table[columns],
                        {"particles": ".0f", "secondary": ".0f", "against_H1": "+.1%"},
                    ),
                    Table(
                        "Percentiles 1 and 99 of the pressure by volume [Pa], lowest and highest "
                        "height of the top [m] at the end; missed_momentum: linear momentum "
                        "that no roller gave, over that of the start.",
                        table[others],
                        {"top_low": ".4f", "top_high": ".4f"},
                    ),
                    Figure("Noise over time, mean of the seeds.", noise),
                ],
            ),
            Section("Pictures", pictures),
            Section(
                "How",
                [
                    Paragraph(
                        f"hexahedra: the block with a jitter of {JITTER:g}, so every particle is "
                        f"off its place by at most {JITTER / 2:g} spacings a component, with the "
                        "smoothing length of the points (of the edge of a cube of the mean "
                        "volume), so that volumes and secondary points differ; widest edge: with "
                        "that of a disordered grid, which counts its widest edge and sees two "
                        "thirds more neighbours at 40 cells a metre. points: "
                        "the same particles, but only their positions and the triangles of the "
                        "surface are given; Delaunay cells, volumes and secondary particles are "
                        "found from these. filled: the same surface, filled by another disordered "
                        "lattice. T1: a secondary particle in each Delaunay cell."
                    ),
                    Paragraph(
                        "The indicator needs no rows of particles: the distance of each pressure "
                        "from the linear function that fits it and its neighbours within 1.6 "
                        "spacings best, over the spread of the pressure, scaled to 1 for a "
                        "checkerboard inside a lattice; a linear field has 0, a sine of ten "
                        "spacings 0.1. It stands for real curvature too, so that a smooth "
                        "solution on a coarse cloud has more than nothing; all clouds of one size "
                        "are judged alike."
                    ),
                ],
            ),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )
