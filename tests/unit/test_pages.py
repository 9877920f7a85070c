"""README and the pages: what they quote is in the reports, and their code can be run."""

from __future__ import annotations

import ast
import importlib.util
import re
import shlex
from pathlib import Path

import pandas as pd
import pytest

import sphsolid as sph
from studies import readme_table
from studies.methods import B_BAR, PACKAGE, SUPG
from studies.pages import markdown_table, theory
from studies.pages.code import Block, blocks, run_page
from studies.pages.reports import Reports

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))
]  # fmt: skip
#: ``python`` is run by ``verification/test_page_code.py``, ``py`` are fragments of a script that
#: is run elsewhere, or that needs a machine which is not here.
LANGUAGES = {"python", "py", "sh", "toml", "text", ""}
FRAGMENTS = {"docs/how_to_add/study.md", "docs/clusters.md"}
LONGEST_README = 110


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def code(path: Path) -> list[Block]:
    """Blocks of a page but the directives of the site."""
    found = blocks(path.read_text(encoding="utf-8"))
    return [block for block in found if not block.language.startswith("{")]


# ------------------------------------------------------------------ what is quoted
def test_readme_and_pages_say_what_the_reports_say():
    for path, text in readme_table.made().items():
        assert path.read_text(encoding="utf-8") == text, (
            f"{name(path)} is not what the reports say: run python -m studies.readme_table"
        )


def test_readme_is_short():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= LONGEST_README
    table = text[text.index("<!-- results: begin") : text.index("<!-- results: end")]
    assert 3 <= len(re.findall(r"^\|", table, re.M)) <= 2 + 10
    for heading in ("Install", "Quick start", "What you get", "Results", "Limits", "How to cite"):
        assert f"\n## {heading}\n" in text


def test_readme_without_its_markers_is_refused():
    with pytest.raises(sph.InputError, match="one block"):
        readme_table.with_block("no markers", "results", "table")


def test_a_report_of_the_former_default_counts_for_the_method_that_it_is():
    rows = pd.DataFrame({"method": [PACKAGE.name, B_BAR.name]})
    assert list(readme_table.with_present_names(rows)["method"]) == [SUPG.name, B_BAR.name]
    both = pd.DataFrame({"method": [PACKAGE.name, SUPG.name]})
    assert list(readme_table.with_present_names(both)["method"]) == [PACKAGE.name, SUPG.name]


def test_costs_are_over_those_of_elements_and_say_where_they_are_bounds():
    rows = [
        ("a", "interpolated", 6.0), ("b", "coarsest is enough", 1.0), ("c", "not reached", None),
        (B_BAR.name, "interpolated", 2.0),
    ]  # fmt: skip
    costs = pd.DataFrame(rows, columns=["method", "how", "cpu_s_per_s"]).assign(
        scene="cube", nu=0.3, measure="stress", asked=0.01
    )
    found = [readme_table.cost(costs, name) for name in ("a", "b", "c", "d", B_BAR.name)]
    assert found == ["3", "at most 0.5", "not reached", "–", "1"]


def test_hard_cases_are_counted_without_those_that_do_not_apply():
    hard = pd.DataFrame(
        {
            "method": ["a"] * 4,
            "verdict": ["sound", "useless", "diverged", "not applicable"],
            "why": [None, "folded (unseen motion 1)", "non-finite", None],
        }
    )
    assert readme_table.judged(hard, "a") == {"cases": 3, "sound": 1, "folded": 1}
    with_column = hard.assign(folded=[True, True, False, False])
    assert readme_table.judged(with_column, "a")["folded"] == 2
    assert readme_table.judged(hard, "b") == {"cases": 0, "sound": 0, "folded": 0}


def test_tables_of_pages_keep_their_columns():
    frame = pd.DataFrame({"what": ["|r| small"], "value": [0.25]})
    assert markdown_table(frame, {"what": "of", "value": "v"}, {"value": ".1e"}).splitlines() == [
        "| of | v |", "| --- | --- |", "| \\|r\\| small | 2.5e-01 |",
    ]  # fmt: skip


def a_report(root: Path, study: str, **tables: pd.DataFrame) -> Reports:
    folder = root / "reports" / study
    folder.mkdir(parents=True)
    (folder / "run.json").write_text("{}")
    for table, frame in tables.items():
        frame.to_csv(folder / f"{table}.csv", index=False)
    return Reports(root)


def test_the_map_of_hard_cases_says_what_became_of_a_run(tmp_path):
    columns = ["case", "method", "energy_kept", "unseen_rms", "verdict", "why"]
    rows = [
        ("column", "a", 0.98, 0.1, "sound", None),
        ("punch", "a", 0.64, 0.4, "useless", "folded (unseen motion 0.4)"),
        ("seeded noise", "a", 2e-5, 0.1, "sound", None),
        ("column", "b", 0.4, 0.1, "useless", "kept 40% of the energy"),
        ("punch", "b", 1e6, 0.1, "diverged", "non-finite"),
        ("seeded noise", "b", None, None, "not applicable", "no such field"),
        ("column", "a variant", 0.98, 0.1, "sound", None),
        ("long column 1/4", "a", 0.97, 0.1, "sound", None),
    ]
    reports = a_report(tmp_path, "stability", table=pd.DataFrame(rows, columns=columns))
    short = theory.hard_short(reports)
    assert short is not None
    assert list(short) == ["case", "a", "b"], "variants are left out"
    assert list(short["a"]) == ["0.980", "0.640, folded", "2e-05"]
    assert list(short["b"]) == ["0.400, useless", "diverged", "–"]
    long = theory.hard_long(reports)
    assert long is not None
    assert long.to_dict("records") == [{"case": "long column 1/4", "a": "0.970"}]


def test_stability_limits_stand_side_by_side(tmp_path):
    columns = ["integrator", "formulation", "nu", "cfl_slow", "cfl_fast"]
    rows = [("RK", "{p,F}", 0.3, 0.85, 0.9), ("RK", "{p,F}", 0.4, 0.8, 0.83),
            ("Verlet", "{p,F}", 0.3, 0.96, 0.96)]  # fmt: skip
    reports = a_report(tmp_path, "stability", limits=pd.DataFrame(rows, columns=columns))
    found = theory.limits(reports)
    assert found is not None
    assert list(found) == ["nu", "RK, {p,F}", "Verlet, {p,F}"]
    assert list(found["RK, {p,F}"]) == ["0.85 (0.90)", "0.80 (0.83)"]
    assert list(found["Verlet, {p,F}"]) == ["0.96 (0.96)", "–"]


def test_a_page_leaves_out_a_table_that_a_report_has_not(tmp_path):
    reports = a_report(tmp_path, "stability", table=pd.DataFrame({"case": ["column"]}))
    a_report(tmp_path, "clouds", levels=pd.DataFrame({"h": [0.1]}))
    a_report(tmp_path, "operators", table=pd.DataFrame({"variant": ["a"]}))
    for view in ("limits", "growth", "hard_short", "hard_long", "pulse", "variants", "by_parts",
                 "recovery", "cloud_limits"):  # fmt: skip
        assert reports.view(view) is None, view


# ------------------------------------------------------------------ code on pages
@pytest.mark.parametrize("path", PAGES, ids=name)
def test_blocks_of_code_are_of_a_kind_that_is_checked(path):
    for block in code(path):
        where = f"{name(path)}, line {block.line}"
        assert block.language in LANGUAGES, where
        if block.language in ("python", "py"):
            ast.parse(block.text)
        if block.language == "py":
            assert name(path) in FRAGMENTS, f"{where}: nothing runs this"


@pytest.mark.parametrize("path", PAGES, ids=name)
def test_commands_on_pages_exist(path):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for block in code(path):
        for line in block.text.splitlines() if block.language == "sh" else ():
            words = shlex.split(line, comments=True)
            if words[:1] == ["make"]:
                assert re.search(rf"^{words[1]}:", makefile, re.M), line
            elif "-m" in words and (module := words[words.index("-m") + 1]).startswith(
                ("studies", "sphsolid", "fem_reference")
            ):
                assert importlib.util.find_spec(module) is not None, line


def test_a_page_is_run_block_by_block_in_a_folder_of_its_own(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "```python\na = 2\n```\n\n```sh\nexit 1\n```\n\n"
        "```python\nopen('made.txt', 'w').write(str(a + 1))\n```\n"
    )
    folder = tmp_path / "inside"
    folder.mkdir()
    assert run_page(page, folder)["a"] == 2
    assert (folder / "made.txt").read_text() == "3"
    page.write_text("text\n\n```python\n1 / 0\n```\n")
    with pytest.raises(ZeroDivisionError) as failure:
        run_page(page, folder)
    assert failure.traceback[-1].lineno == 3
