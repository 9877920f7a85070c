"""Bad case files: every one is one clear message with path and line, and none a traceback."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sphsolid.shell import main

GOOD = """\
solver = "sph"
spacing = "1/2"

[scene]
end_time = 0.01
initial_velocity = ["0", "0", "2 * X"]
probes = { tip = [2.0, 0.5, 0.5] }

[body]
type = "Box"
upper = [2, 1, 1]

[[body.regions]]
name = "grip"
face = "X+"
where = "Z > 0.4"

[material]
type = "NeoHookean"
young_modulus = 1.7e7
poisson_ratio = 0.45
density = 1100.0

[[constraints]]
face = "X-"
direction = "all"

[[tractions]]
face = "grip"
value = ["3e5 * min(t / 0.005, 1)", "0", "0"]

[method]
integrator = "PositionVerlet"

[run]
every = 1e-3
record = ["Energy()", "Probe('tip')"]
"""
NAMED = """\
spacing = 0.5
[scene]
type = "twisting_column"
[material]
poisson_ratio = 0.3
"""


def change(old: str, new: str, text: str = GOOD) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


#: Text of the file, what the message says, and on which line that is (None: it has none).
BAD: dict[str, tuple[str, str, int | None]] = {
    "no TOML": (change('solver = "sph"', "solver = = sph"), "no TOML.*line 1, column 10", None),
    "twice": (change("end_time = 0.01", "end_time = 0.01\nend_time = 1"), "no TOML.*line 6", None),
    "unclosed": (change("upper = [2, 1, 1]", "upper = [2, 1, 1"), "is no TOML", None),
    "unknown table": (change("[material]", "[materail]"), "did you mean 'material'", 18),
    "unknown key": (change("poisson_ratio", "poison_ratio"), "did you mean 'poisson_ratio'", 21),
    "solver": (change('"sph"', '"sphh"'), "'sphh' is no solver", 1),
    "spacing is a word": (change('"1/2"', '"coarse"'), "unknown name 'coarse'", 2),
    "spacing is a list": (change('"1/2"', "[0.5]"), r"\[0.5\] is not a number", 2),
    "spacing is negative": (change('"1/2"', "-0.5"), "must be positive", 2),
    "divided by zero": (change('"1/2"', '"1/0"'), "is inf, which is no finite number", 2),
    "no end": (change("end_time = 0.01\n", ""), "end_time .* missing", 4),
    "end before start": (change("end_time = 0.01", "end_time = -1"), "must be positive", 4),
    "two components": (change('["0", "0", "2 * X"]', '["0", "0"]'), "no three components", 6),
    "unknown variable": (change("2 * X", "2 * t"), "unknown name 't'.*X, Y, Z", 6),
    "unknown function": (change("2 * X", "sine(X)"), "unknown function 'sine'; .*'sin'", 6),
    "power": (change("2 * X", "X^2"), "write \\*\\*", 6),
    "code": (change("2 * X", "().__class__"), "is no formula of numbers", 6),
    "import": (change("2 * X", "__import__('os')"), "unknown function '__import__'", 6),
    "probe outside": (change("[2.0, 0.5, 0.5]", "[20.0, 0.5, 0.5]"), "tip", 9),
    "body": (change('"Box"', '"Bocks"'), "'Bocks' is no body; did you mean", 10),
    "no extent": (change("[2, 1, 1]", "[0, 1, 1]"), "lower|upper|volume|extent", 9),
    "region of no face": (change('face = "X+"', 'face = "W+"'), "W\\+", 9),
    "condition": (change("Z > 0.4", "Z > h"), "unknown name 'h'", 16),
    "material": (change('"NeoHookean"', '"Hookean"'), "'Hookean' is no law; did you mean", 19),
    "incompressible": (change("0.45", "0.5"), "outside .-1, 0.5.", 21),
    "a text for a number": (change("1100.0", '"heavy"'), "unknown name 'heavy'", 22),
    "lacking": (change("density = 1100.0\n", ""), "needs density", 18),
    "direction": (change('"all"', '"al"'), "'normal', 'tangential', 'all'", 24),
    "unknown tag": (change('"X-"', '"Q-"'), "boundary tag 'Q-' is unknown.*'X-'", 25),
    "no list": (change("[[constraints]]", "[constraints]"), r"write \[\[constraints\]\]", 24),
    "traction": (change('"0", "0"]\n\n[method]', '"0"]\n\n[method]'), "no three components", 30),
    "integrator": (change("PositionVerlet", "Verlet"), "'Verlet' is no integrator", 33),
    "option of an option": (
        change('"PositionVerlet"', '"PositionVerlet(step=1)"'), "unknown key 'step'", 33,
    ),
    "broken option": (change('"PositionVerlet"', '"PositionVerlet("'), "cannot be read", 33),
    "of the other solver": (
        change('integrator = "PositionVerlet"', 'element = "BBarHex"'), "solver = 'fem'", 33,
    ),
    "cfl": (change('integrator = "PositionVerlet"', "cfl = -1"), "cfl = -1", 33),
    "pair": (
        change('integrator = "PositionVerlet"', 'formulation = "PF"\ninitial_strain = "Given"'),
        "states no initial|Given", None,
    ),
    "every": (change("every = 1e-3", "every = 0"), "must be positive", 36),
    "recorder": (change("Energy()", "Enrgy()"), "'Enrgy' is no recorder; did you mean", 37),
    "unknown probe": (change("Probe('tip')", "Probe('tpi')"), "'tpi'; did you mean 'tip'", 37),
    "folder": (change("every = 1e-3", "folder = 3"), "not the name of a folder", 36),
    "frames": (change("every = 1e-3", "frames = -1"), "0 is none", 36),
    "unknown scene": (change("twisting_column", "twisted_column", NAMED), "did you mean 'tw", 3),
    "argument of a scene": (
        NAMED.replace("[material]", "speed = 3\n[material]"), "unknown key 'speed'", 4,
    ),
    "body of a scene": (NAMED + '[body]\ntype = "Box"\n', "brings its own body", 6),
    "law of a scene": (NAMED + 'type = "MooneyRivlin"\n', "unknown key 'type'", 6),
    "scene is a list": (
        change('type = "twisting_column"', 'type = ["punch"]', NAMED), "is no scene", 3,
    ),
    "two scenes": (change("[scene]", "[[scene]]", NAMED), r"write \[scene\]", 2),
    "law is a list": (change('"NeoHookean"', '["NeoHookean"]'), "is no law", 19),
    "law is a table": (change('"NeoHookean"', "{ a = 1 }"), "is no law", 19),
    "probe is a list": (change("Probe('tip')", "Probe(['tip'])"), "not the name of a probe", 37),
    "spacing is complex": (change('"1/2"', '"(-8)**(1/3)"'), "is nan, which is no finite", 2),
    "option is complex": (
        change('"PositionVerlet"', '"TVDRK2"\nstabilisation = "SUPG(xi_F=(-1)**0.5)"'),
        "no finite number", 34,
    ),
    "a number for a place": (change("[2, 1, 1]", "2"), "not a list of 3 numbers", 11),
    "two numbers for a place": (change("[2, 1, 1]", "[2, 1]"), "not a list of 3 numbers", 11),
    "a list in a place": (change("[2, 1, 1]", "[[2], 1, 1]"), r"\[2\] is not a number", 11),
    "a word for a place": (change("[2, 1, 1]", '"far"'), "not a list of 3 numbers", 11),
    "a body for a list": (
        change('"Box"\nupper = [2, 1, 1]', '"Blocks"\nblocks = "Box"'), "is not a list", 11,
    ),
    "far too deep": (change("2 * X", "[" + "-" * 900 + "1]"), "nested more than 60 deep", 6),
    "never a number": (change("2 * X", "(-X * X - 1) ** 0.5"), "at none of the places", 6),
    "no condition": (change('"Z > 0.4"', "3"), "3 is no condition", 16),
    "no file": (
        change('"Box"\nupper = [2, 1, 1]', '"MeshFile"\npath = "none.msh"'), "no file", 11,
    ),
    "empty": ("", "body.* is missing", None),
}  # fmt: skip


def said(tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str], *more: str) -> str:
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    assert main(["explain", str(path), "--no-time", *more]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Traceback" not in captured.err
    assert "internal error" not in captured.err
    return captured.err


def test_there_are_thirty():
    assert len(BAD) >= 30


@pytest.mark.parametrize("name", BAD)
def test_a_bad_case_is_refused_with_its_line(name, tmp_path, capsys):
    text, expected, line = BAD[name]
    err = said(tmp_path, text, capsys)
    assert err.startswith("error: bad.toml")
    assert re.search(expected, err), err
    if line is not None:
        assert re.search(rf"\bline {line}\b", err), err


def test_all_mistakes_are_said_at_once_in_the_order_of_the_file(tmp_path, capsys):
    text = change("poisson_ratio", "poison_ratio", change("2 * X", "2 * Q"))
    text = text.replace('"all"', '"al"').replace("every = 1e-3", "evry = 1e-3")
    err = said(tmp_path, text, capsys)
    assert "has 5 mistakes" in err
    numbers = [int(n) for n in re.findall(r"^  line (\d+)", err, re.M)]
    assert len(numbers) == 5
    assert numbers == sorted(numbers)


def test_what_was_set_has_no_line_but_its_name(tmp_path, capsys):
    err = said(tmp_path, GOOD, capsys, "--set", "method.cfl=fast")
    assert re.search(r"bad.toml, --set method.cfl: 'fast'", err)
    err = said(tmp_path, GOOD, capsys, "--set", "constraints[2].face=X+")
    assert "constraints is a list of 1, counted from 1; write constraints[1]" in err
    err = said(tmp_path, GOOD, capsys, "--set", "constraints.direction=normal")
    assert "write constraints[1].direction" in err


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("spacing", "write a key"), ("=3", "write a key"), ("spacing=", "value is missing"),
        ("a b=3", "is no key"), ("spacing=1,2", "use sphsolid sweep"),
        ("constraints[0].face=X+", "counted from 1"), ("solver.x=3", "is no table"),
    ],
)  # fmt: skip
def test_a_bad_setting_is_refused(setting, expected, tmp_path, capsys):
    assert expected in said(tmp_path, GOOD, capsys, "--set", setting)


def test_files_that_are_none(tmp_path, capsys):
    for command in (
        ["run", "none.toml"], ["explain", str(tmp_path)], ["view", str(tmp_path)],
        ["sweep", "none.toml", "--set", "spacing=1"], ["check", "none.msh"],
    ):  # fmt: skip
        assert main(command) != 0
        assert "Traceback" not in capsys.readouterr().err
    binary = tmp_path / "b.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    assert main(["run", str(binary)]) == 2
    assert "UTF-8" in capsys.readouterr().err
