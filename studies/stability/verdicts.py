"""Claims about stability, and what the table of the hard cases says of each."""

from __future__ import annotations

from collections.abc import Callable, Collection

import pandas as pd

from studies.stability.hard_case_judgement import ABSENT, LOST, SOUND, USELESS, is_folded
from studies.stability.hard_case_methods import BASE, DEFAULTS, FEM, METHODS, VARIANTS

YES, PARTLY, NO, UNKNOWN = "reproduced", "reproduced in part", "not reproduced", "not run"
#: Without the term of J, the pressure noise must be this many times as large to show its use.
NOISE_RATIO = 1.5
#: Change of the share of energy kept that counts as none.
SAME = 0.02
STABILISED = tuple(method.name for method in METHODS if method.solver == "SUPG-SPH")
#: What the package gives where the formulation is left to it, or one of the two is asked for.
BY_PACKAGE = (DEFAULTS.name, "{p,F} H1", BASE.name)
_SEEDED = ("seeded sawtooth", "seeded hourglass", "seeded noise", "seeded checkerboard")


def _three(part: int, whole: int) -> str:
    return YES if part == whole else PARTLY if part else NO


def positions_hold(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: positions fold in no hard case with the package's own settings."""
    lasted = table[~table["verdict"].isin([LOST, ABSENT])]
    runs = lasted[lasted["method"].isin(BY_PACKAGE)]
    if not len(runs):
        return UNKNOWN, "no case was run with the package's settings"
    folded = [row for row in runs.to_dict("records") if is_folded(row)]
    why = [
        f"{row['case']}, {row['method']} (unseen motion {row['unseen_rms']:.2g}, "
        f"{row['inside_out']:.1%} inside out)"
        for row in folded
    ]
    theirs = lasted[lasted["method"] == FEM.name]
    count = sum(is_folded(row) for row in theirs.to_dict("records"))
    text = (
        f"{len(folded)} of {len(runs)} runs with the package's settings folded, {count} of "
        f"{len(theirs)} with B-bar elements"
    )
    return _three(len(runs) - len(folded), len(runs)), text + _listed("; folded", why)


def long_columns_are_sound(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: the defaults are sound on every lattice from nu 0.3 to 0.495."""
    runs = table[
        (table["method"] == DEFAULTS.name) & table["case"].str.startswith("long column")
    ]
    if not len(runs):
        return UNKNOWN, "no long column was run with the defaults"
    bad = runs[runs["verdict"] != SOUND]
    text = f"{len(runs) - len(bad)} of {len(runs)} long columns are sound with the defaults"
    why = [f"{row.case} ({row.why})" for row in bad.itertuples()]
    return _three(len(runs) - len(bad), len(runs)), text + _listed("; not sound", why)


def every_case_has_a_method(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: every case is sound with some stabilised particle method."""
    runs = table[table["method"].isin((*STABILISED, DEFAULTS.name))]
    cases = list(dict.fromkeys(runs["case"]))
    if not cases:
        return UNKNOWN, "no case was run"
    sound = set(runs[runs["verdict"] == SOUND]["case"])
    lasted = set(runs[~runs["verdict"].isin([LOST])]["case"])
    without = [case for case in cases if case not in sound]
    text = (
        f"{len(sound)} of {len(cases)} cases are sound with at least one stabilised method, "
        f"{len(lasted)} run to the end with one"
    )
    return _three(len(sound), len(cases)), text + _listed("; none sound", without)


def one_method_for_all(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: one and the same setting is sound in all cases.

    Only settings that ran the most cases count: a variant put to few is not compared.  The long
    columns, which only a few methods run, are judged on their own.
    """
    names = [*STABILISED, *(variant.name for variant in VARIANTS)]
    runs = table[table["method"].isin(names) & ~table["case"].str.startswith("long column")]
    if not len(runs):
        return UNKNOWN, "no case was run"
    counts = runs.groupby("method", sort=False)["verdict"].agg(
        lambda verdicts: ((verdicts == SOUND).sum(), len(verdicts))
    )
    most = max(whole for _, whole in counts)
    compared = [name for name in counts.index if counts[name][1] == most]
    best = max(compared, key=lambda name: counts[name][0])
    sound, whole = counts[best]
    base = counts.get(BASE.name, (0, 0))
    text = f"best: {best}, sound in {sound} of {whole}; {BASE.name} in {base[0]} of {base[1]}"
    failed = runs[(runs["method"] == best) & (runs["verdict"] != SOUND)]
    why = [f"{row.case} ({row.why})" for row in failed.itertuples()]
    return _three(int(sound), int(whole)), text + _listed("; not sound", why)


def seeds_decay(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: all seeds are smaller at the end with every stabilised method."""
    runs = table[table["case"].isin(_SEEDED) & table["method"].isin(STABILISED)]
    if not len(runs):
        return UNKNOWN, "no seeded case was run"
    sound = int((runs["verdict"] == SOUND).sum())
    variants = table[table["case"].isin(_SEEDED) & table["method"].isin(v.name for v in VARIANTS)]
    cured = [
        name for name, part in variants.groupby("method", sort=False)
        if (part["verdict"] == SOUND).all()
    ]  # fmt: skip
    text = f"decayed in {sound} of {len(runs)} runs"
    return _three(sound, len(runs)), text + _listed("; changes that cure it", cured)


def tension_is_stable(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: noise stays bounded in tension with every stabilised method."""
    runs = table[
        (table["case"] == "pulled to stretch 2") & table["method"].isin(STABILISED)
    ]  # fmt: skip
    if not len(runs):
        return UNKNOWN, "the pulled block was not run"
    sound = int((runs["verdict"] == SOUND).sum())
    grown = ", ".join(f"{row.method} {row.answer:.2g}" for row in runs.itertuples())
    return _three(sound, len(runs)), f"growth of the noise to stretch 2: {grown}"


def pressure_term_smooths(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: in the punch the noise is ``NOISE_RATIO`` times as large with ``tau_p = 0``."""
    runs = table[table["case"] == "punch, initial"]
    noise = runs[runs["survived"] == True].set_index("method")["noise_end"]  # noqa: E712
    names = (BASE.name, "tau_p 0", "{p,F,J} unstabilised")
    if not set(names) <= set(noise.index):
        return UNKNOWN, "needs the initial punch with and without tau_p"
    with_it, without, plain = (float(noise[name]) for name in names)
    text = (
        f"noise of the pressure at the end: {with_it:.3f} with tau_p = 0.1 dt, {without:.3f} with "
        f"0, {plain:.3f} without any stabilisation"
    )
    bars = (without > NOISE_RATIO * with_it) + (plain > NOISE_RATIO * with_it)
    return _three(bars, 2), text


def all_survive(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: columns and punches are not lost with any stabilised method."""
    runs = table[
        table["method"].isin(STABILISED) & table["case"].str.contains("column|punch")
    ]
    if not len(runs):
        return UNKNOWN, "no column or punch was run"
    lasted = int((runs["verdict"] != LOST).sum())
    useless = runs[runs["verdict"] == USELESS]
    why = [f"{row.method}, {row.case} ({row.why})" for row in useless.itertuples()]
    text = f"{lasted} of {len(runs)} ran to the end, {len(useless)} of them useless"
    verdict = _three(lasted, len(runs))
    return (PARTLY if verdict == YES and len(useless) else verdict), text + _listed("", why)


def default_makes_no_energy(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: the self-adjoint ``D(p)`` dissipates in every run with the defaults.

    Work below a part in ``10^9`` of the energy is round-off.
    """
    runs = table[
        table["method"].isin(("{p,F} H1", BASE.name, "{p,F,J} H1, SSP-RK3"))
        & (table["survived"] == True) & table["dissipated_p"].notna()  # noqa: E712
    ]  # fmt: skip
    if not len(runs):
        return UNKNOWN, "no run with the defaults"
    sound = int((runs["dissipated_p"] >= -1.0e-9).sum())
    worst = runs.loc[runs["energy_gain"].idxmax()]
    before = table[table["method"].isin(m.name for m in METHODS if m.weighting == "printed")]
    text = (
        f"D(p) took energy in {sound} of {len(runs)} runs; largest gain by anything "
        f"{worst['energy_gain']:.1e} ({worst['method']}, {worst['case']})"
    )
    if len(before):
        most = before.loc[before["energy_gain"].idxmax()]
        text += (
            f"; as printed it made energy in {int((before['dissipated_p'] < -1.0e-9).sum())} of "
            f"{len(before)}, largest gain {most['energy_gain']:.1e} ({most['method']}, "
            f"{most['case']})"
        )
    return _three(sound, len(runs)), text


def step_does_not_matter(table: pd.DataFrame) -> tuple[str, str]:
    """Reproduced: at CFL 0.5 and 0.8 the energy kept is that of the default within ``SAME``."""
    kept = table[~table["answer_is"].isin(("seed left [-]",))].pivot_table(
        index="case", columns="method", values="energy_kept"
    )
    names = ("CFL 0.5", "CFL 0.8")
    if not {BASE.name, *names} <= set(kept.columns):
        return UNKNOWN, "needs the variants CFL 0.5 and CFL 0.8"
    kept = kept.dropna(subset=[BASE.name, *names])
    change = kept[[*names]].sub(kept[BASE.name], axis=0).abs().max(axis=1)
    lost = int((table[table["method"].isin(names)]["verdict"] == LOST).sum())
    text = (
        f"energy kept differs by at most {change.max():.4f} ({change.idxmax()}) from that at CFL "
        f"{BASE.cfl:g}; {lost} runs are lost"
    )
    return _three(int((change <= SAME).sum()), len(change) + lost), text


def _listed(what: str, names: list[str]) -> str:
    return f"{what}: {'; '.join(names)}" if names else ""


CLAIMS: tuple[tuple[str, Callable[[pd.DataFrame], tuple[str, str]]], ...] = (
    ("positions hold their shape in every hard case with the package's settings", positions_hold),
    ("the column is sound with the defaults on every lattice, nu 0.3 to 0.495, to 0.2 s",
     long_columns_are_sound),
    ("every hard case runs to the end, and soundly, with some stabilised method",
     every_case_has_a_method),
    ("one setting is sound in every case", one_method_for_all),
    ("columns to 300 rad/s and nu 0.4999, disordered ones, and the punch survive",
     all_survive),
    ("hourglass, saw tooth, noise and checkerboard are damped", seeds_decay),
    ("no tensile instability in the total Lagrangian frame", tension_is_stable),
    ("tau_p removes the pressure noise of the punch", pressure_term_smooths),
    ("the self-adjoint D(p) makes no energy", default_makes_no_energy),
    ("results do not depend on the step up to CFL 0.8", step_does_not_matter),
)  # fmt: skip


def verdicts(table: pd.DataFrame, cases: Collection[str] = ()) -> pd.DataFrame:
    """One row per claim: ``claim``, ``verdict``, ``decided by``.

    ``cases`` are those that a claim is about: when some were not run, as in the short form, no
    more than a part is reproduced.
    """
    missing = len(set(cases) - set(table["case"]))
    rows = []
    for claim, decide in CLAIMS:
        verdict, text = decide(table)
        if missing and verdict == YES:
            verdict, text = PARTLY, f"{text}; {missing} of {len(cases)} cases were not run"
        rows.append((claim, verdict, text))
    return pd.DataFrame(rows, columns=["claim", "verdict", "decided by"])
