"""Solved operators come back from the disk bit for bit, and damage is healed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud, operator_cache
from sphsolid.geometry import Box


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(operator_cache, "cache_base", lambda: tmp_path)
    monkeypatch.setattr(operator_cache, "LEAST_PARTICLES", 0)
    return tmp_path / "operators"


def build(operator: Any, seed: int = 1) -> Any:
    mesh = Box(jitter=0.3, seed=seed).mesh(0.25)
    return build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=operator)


@pytest.mark.parametrize(
    "operator", [sph.SummationByParts(), sph.Consistent(), sph.Consistent(use="force")]
)
def test_a_second_set_up_reads_the_same_bits(
    folder: Path, monkeypatch: pytest.MonkeyPatch, operator: Any
) -> None:
    first = build(operator)
    assert len(list(folder.iterdir())) == 1

    def refuse(self: Any, cloud: Any) -> None:
        raise AssertionError("solved again")

    monkeypatch.setattr(type(operator), "build", refuse)
    second = build(operator)
    np.testing.assert_array_equal(second.gradients.force, first.gradients.force)
    np.testing.assert_array_equal(second.gradients.kinematic, first.gradients.kinematic)
    np.testing.assert_array_equal(second.areas, first.areas)
    assert second.is_adjoint == first.is_adjoint
    assert (second.iterations, second.change) == (first.iterations, first.change)


def test_anything_that_matters_makes_another_file(folder: Path) -> None:
    build(sph.SummationByParts())
    build(sph.SummationByParts(epsilon=0.2))
    build(sph.SummationByParts(), seed=2)
    build(sph.Consistent())
    assert len(list(folder.iterdir())) == 4


def test_a_damaged_file_is_made_anew(folder: Path) -> None:
    first = build(sph.SummationByParts())
    [path] = folder.iterdir()
    whole = path.read_bytes()
    for damage in (b"", whole[: len(whole) // 2], b"not an archive"):
        path.write_bytes(damage)
        again = build(sph.SummationByParts())
        np.testing.assert_array_equal(again.gradients.force, first.gradients.force)
        assert path.read_bytes() == whole or len(path.read_bytes()) == len(whole)


def test_the_printed_operator_is_not_kept(folder: Path) -> None:
    build(sph.Literal())
    assert not folder.exists()


def test_the_oldest_make_room(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build(sph.SummationByParts())
    [oldest] = folder.iterdir()
    monkeypatch.setattr(operator_cache, "MOST_BYTES", int(1.5 * oldest.stat().st_size))
    build(sph.SummationByParts(), seed=2)
    assert not oldest.exists()
    assert len(list(folder.iterdir())) == 1


def test_a_folder_that_cannot_be_written_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setattr(operator_cache, "cache_base", lambda: tmp_path / "file")
    monkeypatch.setattr(operator_cache, "LEAST_PARTICLES", 0)
    assert build(sph.SummationByParts()).size == 125


@pytest.mark.parametrize("part", ["kinematic", "areas"])
def test_a_file_of_another_shape_is_made_anew(folder: Path, part: str) -> None:
    first = build(sph.SummationByParts())
    [path] = folder.iterdir()
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **(arrays | {part: arrays[part][:5]}))
    again = build(sph.SummationByParts())
    np.testing.assert_array_equal(again.gradients.force, first.gradients.force)
    with np.load(path) as file:
        assert file[part].shape == arrays[part].shape
