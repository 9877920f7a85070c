"""Which operator on which cloud?  The swinging cube and free bodies on every kind of particles.

``python -m studies.clouds`` compares ``Literal``, ``Consistent`` and ``SummationByParts`` on
lattices, disorder, tetrahedra and mesh files: orders and errors on the swinging cube, momenta and
set-up on free bodies of other shapes, the energy account without stabilisation, the CFL number
that a free cube allows, and what the choices inside ``SummationByParts`` are worth.  With
``--cloud`` (also ``python -m studies.convergence --cloud ...``) only the swinging cube on the
clouds named.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from typing import Any

from sphsolid.errors import InputError, require
from studies.clouds.cases import OPERATORS
from studies.clouds.choice import KINDS, cloud_of, folder_of, label_of
from studies.clouds.report import report
from studies.clouds.shape_cases import SHAPES
from studies.clouds.tables import summary, tables
from studies.harness.cases import Case
from studies.harness.front import Study, main

#: Clouds of the comparison and the cells along an edge of their last level.
COMPARED = {
    "lattice": 16,
    "jitter:0.1": 16,
    "jitter:0.2": 32,
    "jitter:0.4": 32,
    "jitter:0.8": 16,
    "tet": 32,
    "hex:studies/meshes/cube_hex_8.msh": 16,
    "tet:studies/meshes/cube_tet_8.msh": 16,
}
#: Last level of the other operators, and the clouds of the short form.
OTHERS_LAST, SHORT_FORM = 16, ("lattice", "jitter:0.4", "tet")
EPSILONS = (1.0e3, 1.0, 0.1, 0.02, 0.01)
#: Clouds whose spectrum is taken.
SPECTRA = ("lattice", "jitter:0.2", "jitter:0.4", "jitter:0.8", "tet")
SUPPORTS = (0.9, 1.0, 1.1, 1.2)
#: Relative cost of a set-up at the same number of particles.
_SET_UP = {"Literal": 0.1, "Consistent": 0.6, "SummationByParts": 6.0}

#: Cells per side of every level, and of the last one where none is named.
LEVELS = (4, 8, 16, 32, 64)
FINEST, FINEST_QUICK = 32, 8


def _cube(
    cloud: str,
    level: int,
    operator: str,
    runs: Sequence[tuple[str, str, str]],
    variant: str = "",
    **options: Any,
) -> Case:
    cells = cloud_of(cloud).cells(level)
    step = "" if cloud.startswith("points") else f" level {level}"
    return Case(
        f"cube {label_of(cloud)}{step} {operator} {variant}".strip(),
        "studies.clouds.cases:cube",
        {
            "cloud": cloud, "level": level, "operator": operator,
            "runs": [list(run) for run in runs], "variant": variant, **options,
        },
        cost=(len(runs) * cells**4 / 16 + _SET_UP[operator] * cells**3.5) / 16**3,
    )  # fmt: skip


def _runs(families: Sequence[str], formulations: Sequence[str]) -> list[tuple[str, str, str]]:
    return [
        (scene, family, formulation)
        for scene in ("linear", "manufactured")
        for family in families
        for formulation in formulations
    ]


def _finest(options: argparse.Namespace) -> int:
    usual = FINEST_QUICK if options.quick else FINEST
    return usual if options.finest is None else int(options.finest)


def _named(clouds: Sequence[str], options: argparse.Namespace) -> Iterator[Case]:
    """All operators on the clouds of the command line, to the same level."""
    families = ("A+B+C=0", "A=B=C") if options.both_families else ("A+B+C=0",)
    finest = _finest(options)
    for cloud in clouds:
        for level in cloud_of(cloud).levels(finest):
            for operator in OPERATORS:
                yield _cube(cloud, level, operator, _runs(families, ("{p,F}", "{p,F,J}")))


def _comparison(options: argparse.Namespace) -> Iterator[Case]:
    for cloud, last in COMPARED.items():
        if options.quick and cloud not in SHORT_FORM:
            continue
        chosen = cloud_of(cloud)
        for operator in OPERATORS:
            finest = last if operator == "SummationByParts" else min(last, OTHERS_LAST)
            finest = min(finest, _finest(options))
            for level in chosen.levels(finest):
                # In the linear limit the formulations agree to three digits.
                fine = chosen.cells(level) > 24
                runs = _runs(("A+B+C=0",), ("{p,F}", "{p,F,J}"))
                runs = [run for run in runs if not fine or run[::2] != ("linear", "{p,F,J}")]
                yield _cube(cloud, level, operator, runs)


def _variants(quick: bool) -> Iterator[Case]:
    """One choice inside ``SummationByParts`` changed at a time, on ``jitter:0.4``."""
    runs = [("linear", "A+B+C=0", "{p,F}")]
    changes: list[tuple[str, dict[str, Any]]] = [
        *((f"start {start}", {"start": start}) for start in ("compatible", "given")),
        *((f"tolerance {rest:g}", {"tolerance": rest}) for rest in (1.0e-6, 1.0e-2)),
        *((f"epsilon {epsilon:g}", {"epsilon": epsilon}) for epsilon in EPSILONS),
        *((f"h/dx {ratio:g}", {"h_over_dx": ratio}) for ratio in SUPPORTS),
    ]
    for variant, options in changes[:2] if quick else changes:
        for level in (4, 8) if quick else (8, 16):
            yield _cube("jitter:0.4", level, "SummationByParts", runs, variant, **options)
    if not quick:
        # Whether a wider support lifts the order of the stress shows at the last level only.
        yield _cube("jitter:0.4", 32, "SummationByParts", runs, "h/dx 1.1", h_over_dx=1.1)


def _conserved(quick: bool) -> Iterator[Case]:
    for shape, clouds in SHAPES.items():
        for cloud in clouds:
            for operator in OPERATORS:
                if quick and (shape != "cube" or operator == "Consistent"):
                    continue
                yield Case(
                    f"free {shape} {cloud} {operator}",
                    "studies.clouds.shape_cases:conservation",
                    {"shape": shape, "cloud": cloud, "operator": operator,
                     "formulation": "{p,F}"},
                    cost=0.5 * (1.0 + _SET_UP[operator]),
                )  # fmt: skip


def _ledgers(quick: bool) -> Iterator[Case]:
    for cloud in ("jitter:0.4", "tet"):
        for integrator in ("TVD-RK2", "position Verlet"):
            yield Case(
                f"energy account {cloud} {integrator}",
                "studies.clouds.ledger_cases:ledger",
                {"cloud": cloud, "level": 4 if quick else 8, "operator": "SummationByParts",
                 "integrator": integrator},
                cost=2.0,
            )  # fmt: skip


def _spectra(quick: bool) -> Iterator[Case]:
    for cloud in SPECTRA[:2] if quick else SPECTRA:
        for operator in OPERATORS:
            yield Case(
                f"spectrum {label_of(cloud)} {operator}",
                "studies.clouds.spectrum_cases:spectrum",
                {"cloud": cloud, "level": 2 if quick else 4, "operator": operator},
                cost=3.0,
            )  # fmt: skip


def cases(options: argparse.Namespace) -> list[Case]:
    """The whole comparison, or the cube on the clouds that ``--cloud`` names."""
    require(
        _finest(options) in LEVELS,
        f"--finest {options.finest}: choose one of {', '.join(map(str, LEVELS))}",
    )
    require(
        bool(options.cloud) or not options.both_families,
        "--both-families is for the clouds that --cloud names: name one, or leave it out",
    )
    if options.cloud:
        names = [label_of(cloud) for cloud in options.cloud]
        require(len(set(names)) == len(names), f"--cloud: {names} are not all different")
        return list(_named(options.cloud, options))
    return [
        *_comparison(options),
        *_variants(options.quick),
        *_conserved(options.quick),
        *_ledgers(options.quick),
        *_spectra(options.quick),
    ]


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel."""
    runs = _runs(("A+B+C=0",), ("{p,F}", "{p,F,J}"))
    return [
        *(_cube("jitter:0.4", 4, operator, runs) for operator in OPERATORS),
        *list(_ledgers(True))[:2],
    ]


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--cloud``, ``--finest``, ``--both-families``."""
    parser.add_argument(
        "--cloud", action="append", default=[], metavar="CLOUD",
        help=f"only the swinging cube on this cloud: {KINDS}; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--finest", type=int, help="cells per side of the last level "
        f"(default {FINEST}, {FINEST_QUICK} with --quick)",
    )  # fmt: skip
    parser.add_argument(
        "--both-families", action="store_true", help="with --cloud: A=B=C beside A+B+C=0"
    )


STUDY = Study(
    name="clouds",
    cases=cases,
    tables=tables,
    report=report,
    summary=summary,
    arguments=arguments,
    warm_up=warm_up,
    description="Operators on lattices, disorder, tetrahedra, mesh files and points.",
)


def run(given: Sequence[str]) -> int:
    """From the command line; results of named clouds go to a folder of their own."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    arguments(parser)
    for name in ("--quick", "--out"):
        parser.add_argument(name, nargs="?", const=True)
    known, _ = parser.parse_known_args(given)
    argv = list(given)
    if known.cloud and known.out is None:
        try:
            for cloud in known.cloud:
                cloud_of(cloud)
        except InputError as error:
            print(f"error: {error}", file=sys.stderr)
            return 2
        name = "+".join(folder_of(cloud) for cloud in known.cloud)
        argv += ["--out", f"{'out' if known.quick else 'reports'}/clouds-{name}"]
    return main(STUDY, argv)
