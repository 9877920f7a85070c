"""Reading costs what the file is large: a set costs what it holds, not what the mesh holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sphsolid.geometry import Box
from sphsolid.geometry.abaqus_reading import read_abaqus
from sphsolid.geometry.mesh_file import reading
from sphsolid.geometry.meshio_reading import by_number
from sphsolid.geometry.numbering import Numbering

MESH = Box().mesh(1.0 / 12.0)
SORTS = ("argsort", "sort", "lexsort", "unique", "isin", "union1d", "setdiff1d", "intersect1d")


@pytest.fixture
def work(monkeypatch) -> dict[str, int]:
    """How many numbers have been sorted, in whatever way."""
    count = {"sorted": 0}
    for name in SORTS:
        plain = getattr(np, name)

        def counted(values, *rest, plain=plain, **options):
            count["sorted"] += sum(np.size(part) for part in (values, *rest[:1]))
            return plain(values, *rest, **options)

        monkeypatch.setattr(np, name, counted)
    return count


def text_with(sets: int, size: int = 1) -> str:
    """The cube, and ``sets`` sets each of elements and of nodes, ``size`` members in each."""
    lines = ["*NODE", *(f"{k},{x!r},{y!r},{z!r}" for k, (x, y, z)
                        in enumerate(MESH.vertices.tolist(), 1)),
             "*ELEMENT,TYPE=C3D8,ELSET=all"]  # fmt: skip
    lines += [f"{k}," + ",".join(str(n + 1) for n in row) for k, row in enumerate(MESH.cells, 1)]
    for k in range(sets):
        members = ",".join(str(1 + (size * k + j) % len(MESH.cells)) for j in range(size))
        lines += [f"*ELSET,ELSET=e{k}", members, f"*NSET,NSET=n{k}", members]
    return "\n".join([*lines, ""])


def read(path: Path, text: str) -> dict[str, np.ndarray]:
    path.write_text(text)
    content = read_abaqus(path)
    reading(str(path), content, 1.0)
    return {each.name: each.points for each in content.sets if each.points is not None}


def test_sets_sort_their_members_and_nothing_else(tmp_path, work):
    totals = []
    for sets in (1, 101, 301):
        work["sorted"] = 0
        found = read(tmp_path / "body.inp", text_with(sets))
        totals.append(work["sorted"])
        assert len(found) == sets
    # The first set asks for the neighbours of all facets; each is then sorted a few times with
    # the facets around its nodes.
    assert totals[0] > 10 * len(MESH.vertices)
    assert totals[1] - totals[0] < 100 * 20
    assert totals[2] - totals[1] < 200 * 20


def test_sets_of_many_members_cost_their_members(tmp_path, work):
    few, many = [], []
    for size, into in ((1, few), (8, many)):
        for sets in (1, 101):
            work["sorted"] = 0
            read(tmp_path / "body.inp", text_with(sets, size))
            into.append(work["sorted"])
    assert many[1] - many[0] < 16 * (few[1] - few[0])


def test_each_list_of_numbers_is_sorted_once(tmp_path, monkeypatch):
    made = []
    plain = Numbering.__init__
    monkeypatch.setattr(
        Numbering, "__init__", lambda self, ids, first=0: made.append(1) or plain(self, ids, first)
    )
    read(tmp_path / "body.inp", text_with(50))
    assert len(made) == 2  # nodes and elements


def test_rows_of_each_number_are_found_by_one_sort(work):
    values = np.array([3, 0, 7, 3, -2, 7, 7])
    found = by_number(values)
    assert [(number, rows.tolist()) for number, rows in found] == [(3, [0, 3]), (7, [2, 5, 6])]
    assert work["sorted"] == len(values)
    assert by_number(np.zeros(3, np.int32)) == by_number(np.zeros(0, bool)) == []
    assert by_number(np.array([True, False]))[0][0] == 1


def test_numbers_are_found_by_what_the_file_calls_them():
    numbers = Numbering(np.array([7, 3, 50, 4]), first=100)
    found = numbers.find(np.array([[3, 4], [5, 50]]))
    np.testing.assert_array_equal(found, [[101, 103], [-1, 102]])
    np.testing.assert_array_equal(numbers.between(3, 7, 2), [101, 100])
    np.testing.assert_array_equal(numbers.between(8, 49, 1), [])
    np.testing.assert_array_equal(Numbering(np.array([5, 1, 5, 1])).twice(), [2, 3])
    assert Numbering(np.zeros(0, int)).find(np.array([1])).tolist() == [-1]
