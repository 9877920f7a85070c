"""Reports: holes are filled or named, every text arrives, nothing overflows, bytes repeat."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pypdfium2
import pytest

from sphsolid.errors import InputError
from studies.engine.claims import Claim
from studies.engine.document import (
    Bullets,
    Document,
    Figure,
    Heading,
    Paragraph,
    Table,
    format_cell,
    markup,
    pieces,
    quote,
    write_pdf,
)
from studies.engine.plotting import panels, save_figure
from studies.engine.provenance import describe_run
from studies.engine.results import Results
from studies.engine.text import document

HOSTILE = '#1 $x$ <a> * b _c_ @d \\e "f" [g] {h} ~ // = - + {p, F}, τ_F = Δt, ∇·P'
FAILED = pd.DataFrame({"key": ["case 7"], "failure": ["Diverged"], "message": ["gone"]})


@pytest.fixture
def results(tmp_path):
    run = describe_run(
        study="fake", command="python -m fake", sources="ab", argv=[], mode="quick", jobs=3,
        threads=1, cluster=True, wall_s=65.0, cases=3, failed=1, sampled=0,
        older_times=0,
        resumed=2,
    )  # fmt: skip
    tables = {"table": pd.DataFrame({"name": ["a", "b"], "value": [0.12345, 2.0]})}
    return Results(tmp_path, tables, FAILED, run)


def filled(text, results, claims=(), **words):
    """The blocks made of a template."""
    path = results.out / "text.md"
    path.write_text(text)
    return document(
        path, results, claims=claims, words=words, draw=lambda name: results.out / f"{name}.pdf"
    )


# --- the text -----------------------------------------------------------------------------------


def test_a_text_becomes_a_report(results):
    text = """# A title with `code`

First of the *abstract*,
{{ x | number(".1f") }}. Second, {{ share | percent }}.

## Part {{ run.jobs }}

- one {{ time | duration }}
- two,
  which goes on

{% for name in tables.table.name %}Row {{ name }}. {% endfor %}{{ missing }} {{ flag }}

{{ figure("f", "Drawn.", width=0.5) }}

### Deeper

{{ table(tables.table, "All of it.", {"value": "error"}, formats={"value": ".2f"}) }}
Both: {{ names | listed }}
"""
    claims = [Claim("good", 1.0, "<=", 2.0, where="here"), Claim("bad", 3.0, "<=", 2.0)]
    made = filled(text, results, claims, x=1.25, share=0.5, time=65, missing=float("nan"),
                  flag=True, names=["a", 1.0])  # fmt: skip
    assert made.title == "A title with `code`"
    assert made.abstract == "First of the *abstract*, 1.2. Second, 50 %."
    assert "quick study" in made.subtitle
    found, verdicts, *body = made.blocks
    assert found == Heading("What was found")
    assert verdicts.frame["claim"].tolist() == ["bad", "good"], "on the first page"
    part, bullets, rows, drawn, deeper, table, both, ran, facts, failed, said, why = body
    assert part == Heading("Part 3", 1)
    assert bullets == Bullets(("one 1 min 05 s", "two, which goes on"))
    assert rows == Paragraph("Row a. Row b. – yes")
    assert drawn == Figure("Drawn.", results.out / "f.pdf", 0.5)
    assert deeper == Heading("Deeper", 2)
    assert (table.head(), table.body()) == (["error"], [["0.12"], ["2.00"]])
    assert both == Paragraph("Both: a, 1")
    assert (ran.text, failed.text) == ("What was run", "What failed")
    assert "3 (1 failed, 2 resumed)" in facts.frame["value"].tolist()
    assert "3 of a Dask cluster" in " ".join(facts.frame["value"])
    assert said.text.startswith("1 case(s) stopped")
    assert why.frame["key"].tolist() == ["case 7"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("# T\n\nfirst\n{{ order }}", r"text.md, line 4: UndefinedError: 'order' is undefined"),
        ("# T\n\n{{ tables.orders }}", "orders"),
        ("# T\n\n{{ order.value }}", "order"),
        ("# T\n\n{{ tables.table.query('no > 1') }}", r"line 3: UndefinedVariableError"),
        ("# T\n\n{{ run.jobs | number('.1q') }}", r"line 3: ValueError"),
        ("# T\n\n{% if %}", r"line 3: TemplateSyntaxError"),
        ("Text\n\nwithout title", "must begin with its title"),
        ("# T\n\n```\ncode\n```", "not fence"),
        ("# T\n\n1. one\n2. two", "not ordered_list"),
    ],
)
def test_what_cannot_be_filled_or_set_is_named(results, text, said):
    with pytest.raises(InputError, match=said):
        filled(text, results)


# --- the PDF ------------------------------------------------------------------------------------


def pages_of(path):
    """Text of every page of a PDF, white space made single."""
    with pypdfium2.PdfDocument(path) as pdf:
        return [re.sub(r"\s+", " ", page.get_textpage().get_text_range()) for page in pdf]


def right_of(path):
    """Right end of the text that reaches farthest [points]."""
    with pypdfium2.PdfDocument(path) as pdf:
        texts = [page.get_textpage() for page in pdf]
        return max(text.get_charbox(k)[2] for text in texts for k in range(text.count_chars()))


def drawing(path, **size):
    figure, axes = panels(1, 1, **size)
    axes[0, 0].plot([1, 2], [1, 2])
    axes[0, 0].set(title="topmost", xlabel="lowest")
    return save_figure(figure, path)


@pytest.fixture
def report(tmp_path):
    frame = pd.DataFrame(
        {"name": [f"row{i}" for i in range(150)], "value": np.linspace(0, 1, 150), "ok": True}
    )
    frame.loc[1, "value"] = np.nan
    blocks = [
        Heading("First things"),
        Paragraph(f"Hostile: {HOSTILE}"),
        Bullets(["first point", "second `code` and **bold**"]),
        Figure("What the figure shows.", drawing(tmp_path / "figure.pdf"), width=0.5),
        Table("A long table.", frame, {"value": ".3e"}, {"value": "error [-]"}),
    ]
    return Document(f"Title {HOSTILE}", "What this is.", blocks, subtitle="a subtitle")


def test_all_content_arrives_and_bytes_repeat(report, tmp_path):
    path = tmp_path / "sub" / "report.pdf"
    write_pdf(report, path)
    assert [p.name for p in path.parent.iterdir()] == ["report.pdf"]
    assert len(pages_of(path)) >= 3
    text = " ".join(pages_of(path))
    for expected in (
        HOSTILE, "What this is.", "a subtitle", "1 First things", "first point",
        "second code and bold", "Figure 1: What the figure shows.", "Table 1: A long table.",
        "row0 0.000e+00 yes", "row1 – yes", "row149 1.000e+00 yes",
    ):  # fmt: skip
        assert expected in text, expected
    assert text.count("error [-]") >= 3, "the heading of a table is repeated on its pages"
    write_pdf(report, tmp_path / "again.pdf")
    assert (tmp_path / "again.pdf").read_bytes() == path.read_bytes()
    assert str(tmp_path).encode() not in path.read_bytes()


def test_a_tall_figure_stays_on_the_page_of_its_heading(tmp_path):
    tall = drawing(tmp_path / "tall.pdf", width=3.0, height=9.0)
    blocks = [Heading("First"), Paragraph("before"), Heading("Second"),
              Figure("A caption. " * 25 + "Last.", tall)]  # fmt: skip
    write_pdf(Document("Tall", "", blocks), tmp_path / "report.pdf")
    assert len(pages_of(tmp_path / "report.pdf")) == 2
    [page] = [text for text in pages_of(tmp_path / "report.pdf") if "Second" in text]
    assert all(word in page for word in ("topmost", "lowest", "Last."))


def test_a_wide_table_stays_on_the_page(tmp_path):
    wide = pd.DataFrame({f"column {i}": [f"{i}" * 12, f"end{i}"] for i in range(12)})
    words = pd.DataFrame({"key": ["k"], "message": ["a long reason " * 30 + "to its last word"]})
    tables = [Table("Wide.", wide), Table("Wordy.", words), Table("Empty.", wide.iloc[:0])]
    write_pdf(Document("Wide", "", tables), tmp_path / "wide.pdf")
    assert right_of(tmp_path / "wide.pdf") < 595.3 - 20.0
    text = " ".join(pages_of(tmp_path / "wide.pdf"))
    assert "end11" in text
    assert "last word" in text
    assert "Empty. (no rows)" in text


@pytest.mark.parametrize(
    ("value", "pattern", "text"),
    [
        (1.23456e-5, "", "1.23e-05"), (0.5, ".2e", "5.00e-01"), (float("nan"), "", "–"),
        (None, "", "–"), (np.float64(2.0), ".2f", "2.00"), (np.int64(35937), "", "35937"),
        (True, "", "yes"), (np.bool_(False), "", "no"), ("{p,F}", ".2e", "{p,F}"),
    ],
)  # fmt: skip
def test_cells(value, pattern, text):
    assert format_cell(value, pattern) == text


def test_markup():
    assert pieces("a `b` **c** d`") == [
        ("plain", "a "), ("code", "b"), ("plain", " "), ("bold", "c"), ("plain", " d`")
    ]  # fmt: skip
    assert markup("x `y`") == '#"x ";#raw("y");'
    assert quote('a"b\\c\nd') == '"a\\"b\\\\c d"'
