"""Caches of kernels are optional, and found where their variables say."""

from __future__ import annotations

import dis
import errno
from pathlib import Path

import numba
import numpy as np
import pytest

from sphsolid import compiled, kernel_cache
from sphsolid.cloud import build_cloud, operator_cache
from sphsolid.cloud.operator import Consistent
from sphsolid.cloud.smoothing import WendlandC2
from sphsolid.geometry import Box


@pytest.fixture
def environment(monkeypatch):
    """Neither cache nor home, but what a test sets."""

    def setting(**variables):
        for name in ("SPHSOLID_CACHE", "XDG_CACHE_HOME", "HOME", "USERPROFILE"):
            monkeypatch.delenv(name, raising=False)
        for name, value in variables.items():
            monkeypatch.setenv(name, value)

    return setting


@pytest.mark.parametrize(
    ("variables", "base"),
    [
        ({"HOME": "/h"}, "/h/.cache/sphsolid"),
        ({"HOME": "/h", "XDG_CACHE_HOME": "/x"}, "/x/sphsolid"),
        ({"HOME": "/h", "XDG_CACHE_HOME": ""}, "/h/.cache/sphsolid"),
        ({"HOME": "/h", "XDG_CACHE_HOME": "here"}, "/h/.cache/sphsolid"),
        ({"XDG_CACHE_HOME": "/x"}, "/x/sphsolid"),
        ({"HOME": "/h", "XDG_CACHE_HOME": "/x", "SPHSOLID_CACHE": "/s"}, "/s"),
        ({"HOME": "/h", "SPHSOLID_CACHE": "~/s"}, "/h/s"),
        ({"HOME": "/h", "SPHSOLID_CACHE": ""}, "/h/.cache/sphsolid"),
        ({"SPHSOLID_CACHE": "/s"}, "/s"),
    ],
)
@pytest.mark.skipif(numba.config.IS_WIN32, reason="homes of POSIX")
def test_the_folder_of_the_cache(environment, variables, base):
    environment(**variables)
    assert compiled.cache_base() == Path(base)


@pytest.fixture
def homeless(environment, monkeypatch):
    environment()

    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", no_home)


def test_no_home_is_no_folder_and_no_harm(homeless, monkeypatch):
    with pytest.raises(OSError, match=r"no cache folder .* set SPHSOLID_CACHE"):
        compiled.cache_base()
    assert compiled._cache_dir() is None
    monkeypatch.setattr(operator_cache, "LEAST_PARTICLES", 0)
    cloud = build_cloud(
        Box(jitter=0.3).mesh(0.25), smoothing=WendlandC2(), h_over_dx=1.0, operator=Consistent()
    )
    assert cloud.size == 125


def doubled(x, out):
    for i in range(len(x)):
        out[i] = 2.0 * x[i]


def runs(kernel) -> bool:
    out = np.zeros(3)
    kernel(np.arange(3.0), out)
    return out.tolist() == [0.0, 2.0, 4.0]


@pytest.fixture
def not_said(monkeypatch):
    monkeypatch.setattr(kernel_cache, "_said_not_kept", False)
    monkeypatch.setattr(compiled, "_KERNELS", [])


@pytest.mark.usefixtures("not_said")
def test_without_a_place_kernels_are_compiled_in_memory(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    folder = tmp_path / "file" / "kernels"
    monkeypatch.setattr(compiled, "CACHE_DIR", folder)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(folder))
    with pytest.warns(RuntimeWarning, match="compiled in memory.*SPHSOLID_CACHE") as said:
        kernels = [compiled.serial_kernel(doubled) for _ in range(2)]
    assert len(said) == 1
    assert all(map(runs, kernels))
    assert not list(Path(__file__).parent.glob("__pycache__/*doubled*"))


@pytest.mark.usefixtures("not_said", "homeless")
def test_without_a_home_too(monkeypatch):
    monkeypatch.setattr(compiled, "CACHE_DIR", None)
    with pytest.warns(RuntimeWarning, match="no cache folder") as said:
        assert runs(compiled.serial_kernel(doubled))
    assert str(said[0].message).count("set SPHSOLID_CACHE") == 1


@pytest.mark.usefixtures("not_said")
def test_a_full_disk_is_said_once_and_does_no_harm(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "CACHE_DIR", tmp_path)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))

    def full(self, name, data):
        raise OSError(errno.ENOSPC, "No space left on device")

    kernels = [compiled.serial_kernel(doubled) for _ in range(2)]
    with monkeypatch.context() as disk:
        disk.setattr("numba.core.caching.IndexDataCacheFile._save_data", full)
        with pytest.warns(RuntimeWarning, match="No space") as said:
            assert [runs(kernel) for kernel in kernels] == [True, True]
    assert len(said) == 1
    # An index without its kernel, as such a disk leaves it, is no harm either.
    assert runs(compiled.serial_kernel(doubled))


@pytest.mark.usefixtures("not_said")
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_damaged_cache_is_made_anew(tmp_path, monkeypatch, share):
    monkeypatch.setattr(compiled, "CACHE_DIR", tmp_path)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    assert runs(compiled.serial_kernel(doubled))
    files = [file for file in tmp_path.rglob("*.nb?") if file.is_file()]
    assert len(files) == 2
    for file in files:
        content = file.read_bytes()
        file.write_bytes(content[: int(share * len(content))])
    assert runs(compiled.serial_kernel(doubled))


def test_no_kernel_calls_another():
    """In a forked process the inner one would still have the threads of the parent."""
    import fem_reference  # noqa: F401  (its kernels, too)
    import sphsolid  # noqa: F401

    kernels = {id(each) for each in compiled._KERNELS}
    assert len(kernels) > 20
    for each in compiled._KERNELS:
        function = each.py_func
        called = {
            step.argval for step in dis.get_instructions(function) if step.opname == "LOAD_GLOBAL"
        }
        inner = [name for name in called if id(function.__globals__.get(name)) in kernels]
        assert not inner, f"{function.__module__}.{function.__qualname__} calls {inner}"
