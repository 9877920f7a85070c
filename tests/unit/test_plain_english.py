"""The documents are readable: short sentences, and one word for one thing."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [
    ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "studies").rglob("*.md")),
]  # fmt: skip
#: A longer sentence has more than one idea.
MOST_WORDS = 35
#: How a page begins that is filled from reports.
MADE = "<!-- Made by"
#: What the field has a word for, and the word.
TERMS = {
    r"ledgers?": "energy budget",
    r"(account|balance|watch) of (the )?(energy|momentum)": "energy budget",
    r"energy (account|balance|watch)": "energy budget",
    r"lost": "diverged, or what else happened to it",
}
#: A full stop behind one of these ends no sentence.
_ABBREVIATED = r"(?<!\beq)(?<!\beqs)(?<!\bFig)(?<!\bFigs)(?<!\be\.g)(?<!\bi\.e)(?<!\bcf)"
_END = re.compile(_ABBREVIATED + r"[.?!][)*\"”]*\s+(?=[^a-z])")
_ITEM = re.compile(r"^(?:[-*]|\d+\.) ")


def prose(text: str) -> Iterator[str]:
    """Paragraphs and items of lists, each on one line; no code, table, heading or picture."""
    text = re.sub(r"<!--.*?-->|```.*?```", "\n\n", text, flags=re.DOTALL)
    # Templates of reports: a hole is a number, and a branch is no part of a sentence.
    text = re.sub(r"{%.*?%}", "\n\n", text, flags=re.DOTALL)
    text = re.sub(r"{{.*?}}", "1", text, flags=re.DOTALL)
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*|#]|\d+\.) )", text):
        if block.strip() and not block.startswith("    ") and block.lstrip()[0] not in "|#!":
            yield _ITEM.sub("", " ".join(block.split()), count=1)


def sentences(text: str) -> Iterator[str]:
    """The sentences of a Markdown text."""
    for block in prose(text):
        yield from _END.split(block)


def too_long(text: str) -> list[str]:
    """Sentences of more than :data:`MOST_WORDS` words."""
    return [each for each in sentences(text) if len(each.split()) > MOST_WORDS]


def other_terms(text: str) -> list[str]:
    """Words for which the field has another one; names in code count as they are."""
    if text.startswith(MADE):
        # Their tables quote reports word by word.
        text = re.sub(r"^\|.*$", "", text, flags=re.MULTILINE)
    words = re.sub(r"`[^`]*`|\]\([^)]*\)", " ", re.sub(r"```.*?```", " ", text, flags=re.DOTALL))
    return [
        f"{found.group()!r}: say {term}"
        for pattern, term in TERMS.items()
        for found in re.finditer(rf"\b{pattern}\b", words, re.IGNORECASE)
    ]


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_sentences_are_short(path):
    found = too_long(path.read_text(encoding="utf-8"))
    assert found == [], "\n".join(found)


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_one_word_for_one_thing(path):
    assert other_terms(path.read_text(encoding="utf-8")) == []


def test_a_long_sentence_is_found():
    long = " ".join(["word"] * (MOST_WORDS + 1))
    assert too_long(f"Short. Then {long}.") == [f"Then {long}."]
    assert too_long(f"- An item: {long};\n- another.") == [f"An item: {long};"]
    assert too_long(f"Of [Lee2017] eq. (34) {long}.") != []


def test_what_is_no_prose_is_left_out():
    long = " ".join(["word"] * (MOST_WORDS + 1))
    for form in ("| {} | b |", "```\n{}\n```", "    {}", "# {}", "![{}](x)", "<!-- {} -->"):
        assert list(sentences(form.format(long))) == []


def test_sentences_end_where_a_reader_ends_them():
    text = "One (of [Lee2017] eq. 3). Two is `a.b`, i.e. 0.5. *Three!* And four:\n\n- five;"
    assert len(list(sentences(text))) == 5


def test_another_term_is_found():
    assert len(other_terms("The ledger, the balance of energy and a run that was lost.")) == 3
    assert len(other_terms(f"{MADE} x -->\n| a ledger |\n\nA ledger.")) == 1
    assert other_terms("`EnergyLedger()` records the energy budget; see [it](ledger.md).") == []
