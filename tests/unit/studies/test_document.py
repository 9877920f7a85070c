"""Reports: every text arrives, nothing overflows its page silently, bytes repeat."""

from __future__ import annotations

import importlib.util
import re

import numpy as np
import pandas as pd
import pypdfium2
import pytest

from sphsolid.errors import InputError
from studies.report.document import (
    Bullets,
    Document,
    Figure,
    Paragraph,
    Section,
    Table,
    format_cell,
    pieces,
)
from studies.report.document_pdf import write_pdf
from studies.report.document_typst import markup, quote
from studies.report.plotting import panels, save_figure
from studies.report.standard_sections import what_failed

ENGINES = [
    pytest.param(
        "typst",
        marks=pytest.mark.skipif(
            importlib.util.find_spec("typst") is None, reason="the typst package is not installed"
        ),
    ),
    "pages",
]
HOSTILE = '#1 $x$ <a> *b* _c_ @d \\e "f" [g] {h} ~ // = - + {p, F}, τ_F = Δt, ∇·P'


def pages_of(path) -> list[str]:
    """Text of every page of a PDF, white space made single."""
    with pypdfium2.PdfDocument(path) as pdf:
        return [re.sub(r"\s+", " ", page.get_textpage().get_text_range()) for page in pdf]


def text_of(path) -> str:
    return " ".join(pages_of(path))


def right_of(path) -> float:
    """Right end of the text that reaches farthest [points]."""
    with pypdfium2.PdfDocument(path) as pdf:
        texts = [page.get_textpage() for page in pdf]
        return max(
            text.get_charbox(k)[2] for text in texts for k in range(text.count_chars())
        )


def long_table(rows: int) -> Table:
    frame = pd.DataFrame(
        {"name": [f"row{i}" for i in range(rows)], "value": np.linspace(0, 1, rows), "ok": True}
    )
    frame.loc[1, "value"] = np.nan
    return Table("A long table.", frame, {"value": ".3e"}, {"value": "error [-]"})


@pytest.fixture
def document(tmp_path) -> Document:
    figure, axes = panels(1, 1)
    axes[0, 0].plot([1, 2], [1, 2])
    save_figure(figure, tmp_path / "figure")
    blocks = [
        Paragraph(f"Hostile: {HOSTILE}"),
        Bullets(["first point", "second `code` and **bold**"]),
        Figure("What the figure shows.", tmp_path / "figure", width=0.5),
        long_table(150),
    ]
    failures = pd.DataFrame({"key": ["case 7"], "failure": ["Diverged"], "message": ["gone"]})
    sections = [Section("First things", blocks), what_failed(failures)]
    return Document(f"Title {HOSTILE}", "What this is.", sections, subtitle="a subtitle")


@pytest.mark.parametrize("engine", ENGINES)
def test_all_content_arrives(engine, document, tmp_path):
    path = tmp_path / "sub" / "report.pdf"
    write_pdf(document, path, engine=engine)
    assert [p.name for p in path.parent.iterdir()] == ["report.pdf"]
    assert len(pages_of(path)) >= 3
    text = text_of(path)
    for expected in (
        HOSTILE,
        "Abstract. What this is.",
        "a subtitle",
        "first point",
        "second code and bold",
        "Figure 1: What the figure shows.",
        "Table 1: A long table.",
        "row0 0.000e+00 yes",
        "row1 – yes",
        "row149 1.000e+00 yes",
        "case 7 Diverged gone",
    ):
        assert expected in text, expected
    assert text.count("error [-]") >= 3, "the heading of a table is repeated on its pages"


@pytest.mark.parametrize("engine", ENGINES)
def test_same_document_same_bytes(engine, document, tmp_path):
    for name in ("a.pdf", "b.pdf"):
        write_pdf(document, tmp_path / name, engine=engine)
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()
    assert str(tmp_path).encode() not in (tmp_path / "a.pdf").read_bytes()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_tall_figure_stays_on_the_page_of_its_heading(engine, tmp_path):
    figure, axes = panels(1, 1, width=3.0, height=9.0)
    axes[0, 0].set(title="topmost", xlabel="lowest")
    save_figure(figure, tmp_path / "tall")
    path = tmp_path / "document.pdf"
    sections = [
        Section("First", [Paragraph("before")]),
        Section("Heading", [Figure("A caption. " * 25 + "Last.", tmp_path / "tall")]),
    ]
    write_pdf(Document("Tall", "", sections), path, engine=engine)
    assert len(pages_of(path)) == 2
    (page,) = [text for text in pages_of(path) if "Heading" in text]
    assert "Last." in page
    if engine == "typst":
        assert "topmost" in page
        assert "lowest" in page


@pytest.mark.parametrize("engine", ENGINES)
def test_a_wide_table_stays_on_the_page(engine, tmp_path):
    wide = pd.DataFrame({f"column {i}": [f"{i}" * 12, f"end{i}"] for i in range(12)})
    words = pd.DataFrame({"key": ["k"], "message": ["a long reason " * 30 + "to its last word"]})
    tables = [Table("Wide.", wide), Table("Wordy.", words), Table("Empty.", wide.iloc[:0])]
    path = tmp_path / "wide.pdf"
    write_pdf(Document("Wide", "", [Section("One", tables)]), path, engine=engine)
    assert right_of(path) < 595.3 - 20.0
    text = text_of(path)
    assert "end11" in text
    assert "word" in text


def test_without_typst_the_pages_engine_is_taken(document, tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    write_pdf(document, tmp_path / "auto.pdf")
    write_pdf(document, tmp_path / "pages.pdf", engine="pages")
    assert (tmp_path / "auto.pdf").read_bytes() == (tmp_path / "pages.pdf").read_bytes()


def test_a_missing_figure_is_named(tmp_path):
    document = Document("T", "", [Section("S", [Figure("c", tmp_path / "not_there")])])
    with pytest.raises(InputError, match="not_there"):
        write_pdf(document, tmp_path / "t.pdf")


@pytest.mark.parametrize(
    ("value", "pattern", "text"),
    [
        (1.23456e-5, "", "1.23e-05"),
        (0.5, ".2e", "5.00e-01"),
        (float("nan"), "", "–"),
        (None, "", "–"),
        (np.float64(2.0), ".2f", "2.00"),
        (np.int64(35937), "", "35937"),
        (True, "", "yes"),
        (np.bool_(False), "", "no"),
        ("{p,F}", ".2e", "{p,F}"),
    ],
)
def test_cells(value, pattern, text):
    assert format_cell(value, pattern if not isinstance(value, str) else "") == text
    if isinstance(value, str):
        assert format_cell(value, pattern) == text


def test_markup():
    assert pieces("a `b` **c** d`") == [
        ("plain", "a "), ("code", "b"), ("plain", " "), ("bold", "c"), ("plain", " d`")
    ]  # fmt: skip
    assert markup("x `y`") == '#"x ";#raw("y");'
    assert quote('a"b\\c\nd') == '"a\\"b\\\\c d"'
