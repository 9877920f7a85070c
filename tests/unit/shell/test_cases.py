"""Case files are the objects that a script would make; every example is one."""

from __future__ import annotations

import inspect
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sphsolid as sph
from sphsolid import scenes
from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile, Tagged
from sphsolid.record import Energy, Every, Never, Probe
from sphsolid.scenes import Scene, twisting_column
from sphsolid.shell import main, read_case
from sphsolid.shell.case import TABLES
from sphsolid.shell.lines import key_lines, spelled
from sphsolid.shell.member import Member, hash_of
from sphsolid.shell.names import BODIES, FEM, SCENES, SPH
from sphsolid.shell.run_table import KEYS
from sphsolid.shell.settings import one, parse, product

ROOT = Path(__file__).resolve().parents[3]
CASES = sorted((ROOT / "examples" / "cases").glob("*.toml"))
#: What plans each example within a second.
COARSE = {"punch": "1/10", "l_shaped_block": "1", "cable": "1", "plate_with_hole": ""}


def case(text: str, tmp_path: Path, **settings: str):
    path = tmp_path / "a case.toml"
    path.write_text(text, encoding="utf-8")
    return read_case(path, settings=[one(f"{k}={v}") for k, v in settings.items()])


def test_there_is_an_example_for_each_scene():
    made = {read_case(path).values["scene"].get("type") for path in CASES}
    assert made == {*SCENES, None}
    public = {
        name for name, each in vars(scenes).items()
        if inspect.isfunction(each) and inspect.signature(each).return_annotation == "Scene"
    }  # fmt: skip
    assert set(SCENES) == public


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_every_example_is_read_and_planned(path, capsys):
    spacing = COARSE.get(path.stem, "1/2")
    more = ["--set", f"spacing={spacing}"] if spacing else []
    assert main(["explain", str(path), "--no-time", *more]) == 0
    said = capsys.readouterr().out
    for word in ("memory", "threads", "records", "steps"):
        assert word in said


def test_every_option_of_both_simulations_has_a_place():
    import fem_reference as fem
    from sphsolid.shell.names import FEM_NUMBERS, SPH_NUMBERS

    for method, known in ((sph, {*SPH, *SPH_NUMBERS}), (fem, {*FEM, *FEM_NUMBERS})):
        keywords = set(inspect.signature(method.Simulation).parameters)
        assert keywords - {"scene", "spacing", "terms"} == known


def test_a_named_scene_is_what_its_function_makes(tmp_path):
    found = case(
        'spacing = "1/6"\n[scene]\ntype = "twisting_column"\nangular_velocity = 50\n'
        "[material]\npoisson_ratio = 0.3\n",
        tmp_path,
    )
    assert found.scene == twisting_column(angular_velocity=50, poisson_ratio=0.3)
    assert (found.solver, found.spacing, found.method) == ("sph", 1 / 6, {})
    assert found.run.until == found.scene.end_time
    assert found.run.record == (Energy(), *(Probe(name) for name in found.scene.probes))


def test_options_are_the_objects_however_they_are_written(tmp_path):
    head = 'spacing = 1\n[scene]\ntype = "twisting_column"\n[method]\n'
    text = 'stabilisation = "SUPG(tau_F=OfMesh(0.5), xi_F=1/10, secondary=H6())"\n'
    table = (
        "[method.stabilisation]\ntype = 'SUPG'\ntau_F = { type = 'OfMesh', c = 0.5 }\n"
        "xi_F = 0.1\nsecondary = 'H6'\n"
    )
    wanted = sph.SUPG(tau_F=sph.OfMesh(0.5), xi_F=0.1, secondary=sph.H6())
    for written in (text, table):
        assert case(head + written, tmp_path).method["stabilisation"] == wanted
    simple = case(head + "operator = 'Consistent'\ncfl = 'auto'\nh_over_dx = '9/10'\n", tmp_path)
    assert simple.method == {"operator": sph.Consistent(), "cfl": "auto", "h_over_dx": 0.9}


def test_an_own_problem(tmp_path):
    found = read_case(ROOT / "examples" / "cases" / "own_block.toml")
    scene = found.scene
    assert isinstance(scene, Scene)
    assert scene.name == "own_block"
    assert isinstance(scene.body, Tagged)
    assert scene.body.body == Box((0, 0, 0), (2, 1, 1))
    assert scene.material == sph.NeoHookean.from_young(
        young_modulus=1.7e7, poisson_ratio=0.45, density=1100.0
    )
    X = np.array([[0.5, 0.0, 0.0]])
    np.testing.assert_array_equal(scene.initial_velocity(X), [[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(scene.body_force(X, 0.0), [[0.0, 0.0, -9.81 * 1100]])
    np.testing.assert_array_equal(scene.tractions[0].value(X, X, 0.0025), [[1.5e5, 0.0, 0.0]])
    assert scene.probes["tip"] == (2.0, 0.5, 0.5)


def test_moduli_may_be_given_as_they_are(tmp_path):
    text = (
        "spacing = 0.5\n[scene]\nend_time = 1\n[body]\ntype = 'Box'\n"
        "[material]\ntype = 'NeoHookean'\nmu = 1e6\nkappa = 1e7\ndensity = 1000\n"
    )
    assert case(text, tmp_path).scene.material == sph.NeoHookean(1e6, 1e7, 1000)


def test_bodies_from_files_lie_beside_the_case(tmp_path):
    text = (
        "[scene]\nend_time = 1\n[body]\ntype = 'MeshFile'\npath = 'part.msh'\nunit = 'mm'\n"
        "[material]\nyoung_modulus = 1e6\npoisson_ratio = 0.3\ndensity = 1000\n"
    )
    (tmp_path / "part.msh").write_text("one")
    found = case(text, tmp_path)
    assert found.scene.body == MeshFile(str(tmp_path / "part.msh"), unit="mm")
    assert found.files == (tmp_path / "part.msh",)
    other = tmp_path / "elsewhere" / "part.msh"
    other.parent.mkdir()
    other.write_text("two")
    whole = case(text.replace("path = 'part.msh'", f"path = '{other}'"), tmp_path)
    assert whole.scene.body.path == str(other)
    # What a sweep keeps is of the files as they were.
    assert hash_of(found.files[0]) != hash_of(whole.files[0])
    one = Member(found.text, "a", "b", (), inputs=(hash_of(found.files[0]),))
    assert one.number != replace(one, inputs=(hash_of(other),)).number
    assert "PointCloud.fill" in BODIES


def test_what_a_run_leaves(tmp_path):
    head = 'spacing = 1\n[scene]\ntype = "twisting_column"\n[run]\n'
    run = case(head + "frames = 5\nvtkhdf = false\ncheckpoints = 0\nfolder = 'x'\n", tmp_path).run
    assert (run.frames, run.vtkhdf, run.checkpoints) == (Every(5), Never(), Never())
    assert run.folder == "x"
    assert case(head, tmp_path).run.folder == "out/a case"


# ---------------------------------------------------------------------- settings
def test_settings_take_the_place_of_what_the_file_says(tmp_path):
    text = 'spacing = 1\n[scene]\ntype = "twisting_column"\n'
    found = case(text, tmp_path, **{"material.poisson_ratio": "0.3", "spacing": "1/4",
                                    "method.integrator": "TVDRK2()", "solver": "sph"})  # fmt: skip
    assert found.scene == twisting_column(poisson_ratio=0.3)
    assert found.spacing == 0.25
    assert found.method["integrator"] == sph.TVDRK2()


def test_values_are_split_at_commas_outside_brackets():
    assert [each.value for each in parse("a=1,2.5,1/4")] == [1, 2.5, "1/4"]
    assert [each.value for each in parse("a.b=SUPG(xi_F=0, tau_F=1),Restraint()")] == [
        "SUPG(xi_F=0, tau_F=1)", "Restraint()",
    ]  # fmt: skip
    assert [each.value for each in parse("a=[1, 2],'x,y',true")] == [[1, 2], "x,y", True]
    assert parse("constraints[2].face=X+")[0].place == ("constraints", 1, "face")


def test_all_combinations_the_last_one_fastest():
    found = product(["a=1,2", "b=x,y,z"])
    assert [tuple(each.value for each in one) for one in found][:4] == [
        (1, "x"), (1, "y"), (1, "z"), (2, "x"),
    ]  # fmt: skip
    with pytest.raises(InputError, match="given twice"):
        product(["a=1", "a=2"])


# ---------------------------------------------------------------------- lines
def test_lines_of_keys():
    text = (
        "# a comment\n"  # 1
        'a = 1\n"b c" = """\nx = 3\n"""\n'  # 2, 3 to 5
        "[t]\nc.d = [\n  1,\n  2, # ]\n]\n"  # 6, 7 to 10
        "e = { f = 1 }\n"  # 11
        "[[l]]\ng = 1\n[[l.m]]\nh = 1\n[[l]]\ng = 2\n"  # 12 to 17
    )
    found = key_lines(text)
    assert found[("a",)] == 2
    assert found[("b c",)] == 3
    assert ("x",) not in found
    assert found[("t", "c", "d")] == 7
    assert found[("t", "e")] == 11
    assert found[("l", 0, "g")] == 13
    assert found[("l", 0, "m", 0, "h")] == 15
    assert found[("l", 1, "g")] == 17
    assert spelled(("l", 1, "g")) == "l[2].g"


# ---------------------------------------------------------------------- the page
def test_the_cases_of_the_page_are_cases(tmp_path):
    page = (ROOT / "docs" / "shell.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        assert isinstance(case(block, tmp_path).scene, Scene)
    for name in (*SPH, *FEM, *TABLES, *KEYS, *BODIES):
        assert f"`{name}`" in page or f"[{name}]" in page, name
