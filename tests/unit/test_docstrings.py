"""Every public name says what it is, and every source it names can be looked up."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("sphsolid", "fem_reference", "studies")
BIBLIOGRAPHY = ROOT / "docs" / "references.bib"
#: ``[Lee2017]``, also in ``[Lee2017 section 8.1]`` and ``[Hughes1980; Simo1985]``.
CITED = re.compile(r"\[([^\[\]]*)\]")
KEY = re.compile(r"\b([A-Z][A-Za-z]+(?:18|19|20)\d\d[a-z]?)\b")

#: What an article, a book and a part of a book have beside author and title.
FIELDS = {
    "article": ("journal", "volume", "pages"),
    "book": ("publisher",),
    "incollection": ("booktitle", "publisher", "pages"),
    "inproceedings": ("booktitle",),
}

Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def sources(root: Path) -> Iterator[Path]:
    """All Python files of the packages under ``root``."""
    for package in PACKAGES:
        yield from sorted((root / package).rglob("*.py"))


def public(tree: ast.Module, name: str) -> Iterator[tuple[str, Documented]]:
    """The module and its public classes, functions and methods; nothing inside functions."""
    yield name, tree

    def inside(body: list[ast.stmt], prefix: str) -> Iterator[tuple[str, Documented]]:
        for node in body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                if node.name.startswith("_"):
                    continue
                yield f"{prefix}.{node.name}", node
                if isinstance(node, ast.ClassDef):
                    yield from inside(node.body, f"{prefix}.{node.name}")

    yield from inside(tree.body, name)


def undocumented(root: Path) -> list[str]:
    """Public names without a docstring."""
    found = []
    for path in sources(root):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for name, node in public(tree, path.relative_to(root).as_posix()):
            if not (ast.get_docstring(node) or "").strip():
                found.append(name)
    return found


def entries(bibliography: Path) -> list[str]:
    """Keys of a bibliography, in order."""
    return re.findall(r"^@\w+\{\s*([^,\s]+)\s*,", bibliography.read_text(encoding="utf-8"), re.M)


def keys_in(text: str) -> set[str]:
    """Source keys cited in brackets in a text."""
    return {key for bracket in CITED.findall(text) for key in KEY.findall(bracket)}


def unresolved(root: Path, bibliography: Path) -> list[str]:
    """Cited keys that the bibliography lacks, with where they are cited."""
    known = set(entries(bibliography))
    documents = [*sources(root), *sorted((root / "docs").glob("*.md")), *root.glob("*.md")]
    return [
        f"{path.relative_to(root).as_posix()}: {key}"
        for path in documents
        for key in sorted(keys_in(path.read_text(encoding="utf-8")) - known)
    ]


def test_every_public_name_has_a_docstring():
    assert undocumented(ROOT) == []


def test_every_source_resolves():
    assert unresolved(ROOT, BIBLIOGRAPHY) == []


def test_the_bibliography_is_sound():
    keys = entries(BIBLIOGRAPHY)
    assert len(keys) > 10
    assert len(set(keys)) == len(keys), "a key appears twice"
    assert all(KEY.fullmatch(key) for key in keys), "a key that could not be cited"
    text = BIBLIOGRAPHY.read_text(encoding="utf-8")
    for block in text.split("\n@")[1:]:
        key = block.split("{")[1].split(",")[0]
        year = re.search(r"year\s*=\s*\{(\d{4})\}", block)
        assert year, key
        assert year.group(1) in key
        kind = block.split("{")[0]
        for field in ("author", "title", *FIELDS[kind]):
            assert re.search(rf"^\s*{field}\s*=", block, re.M), (key, field)
        assert block.count("{") == block.count("}"), f"{key}: braces do not match"


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("", ["m.py"]),
        ('"""M."""\ndef f(): ...', ["m.py.f"]),
        ('"""M."""\nclass C:\n    """C."""\n    def g(self): ...', ["m.py.C.g"]),
        ('"""M."""\nclass C: ...', ["m.py.C"]),
        ('"""M."""\ndef f():\n    """ """', ["m.py.f"]),
        ('"""M."""\ndef _f(): ...\nclass _C:\n    def g(self): ...', []),
        ('"""M."""\ndef f():\n    """F."""\n    def inner(): ...', []),
        ('"""M."""\nclass C:\n    """C."""\n    def __init__(self): ...', []),
    ],
)
def test_a_missing_docstring_is_found(tmp_path, text, missing):
    folder = tmp_path / "sphsolid"
    folder.mkdir()
    (folder / "m.py").write_text(text)
    assert undocumented(tmp_path) == [f"sphsolid/{name}" for name in missing]


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("[Lee2017] eq. (7)", []),
        ("[Nobody1999] eq. (7)", ["Nobody1999"]),
        ("as in [Lee2017 section 8.1; Nobody1999a]", ["Nobody1999a"]),
        ("momentum [kg/(m^2 s)] and [Pa], list [1984], x[ABC2000x1]", []),
        ("Nobody1999 without brackets", []),
    ],
)
def test_a_source_that_does_not_resolve_is_found(tmp_path, text, missing):
    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "m.py").write_text(f'"""{text}."""')
    (tmp_path / "r.bib").write_text("@article{Lee2017,\n}\n")
    expected = [f"studies/m.py: {key}" for key in missing]
    assert unresolved(tmp_path, tmp_path / "r.bib") == expected
