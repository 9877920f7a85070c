"""Formulas: right where they are some, refused where they are anything else."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.shell.expressions import (
    FUNCTIONS,
    Condition,
    FaceField,
    Field,
    TimeField,
    is_condition,
    is_finite_somewhere,
    number_in,
    value_of,
)

X = np.array([[0.1, 0.2, 0.3], [1.0, -2.0, 4.0]])


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("1/6", 1 / 6), ("-2**2", -4.0), ("2**-1", 0.5), ("(1 + 2) * 3", 9.0), ("7 % 4", 3.0),
        ("sin(pi/2)", 1.0), ("log(e)", 1.0), ("min(1, 2)", 1.0), ("where(1 < 2, 5, 6)", 5.0),
        ("5 if 1 > 2 else 6", 6.0), ("1 < 2 < 3", 1.0), ("not (1 > 2 or 2 > 3)", 1.0),
        ("clip(5, 0, 1)", 1.0), ("hypot(3, 4)", 5.0), ("1e-3", 1e-3), (" 2 ", 2.0),
    ],
)  # fmt: skip
def test_numbers(text, wanted):
    assert number_in(text) == pytest.approx(wanted, rel=1e-15)


def test_every_function_is_that_of_numpy():
    for name, (function, (count,)) in FUNCTIONS.items():
        values = [0.3, 0.2, 0.6][:count]
        text = f"{name}({', '.join(map(str, values))})"
        assert number_in(text) == pytest.approx(float(function(*values)), rel=1e-15), name


@pytest.mark.parametrize(
    "text",
    [
        "", "1 +", "X", "import os", "__import__('os').system('true')", "().__class__", "[1, 2]",
        "'a' * 3", "lambda: 1", "f'{1}'", "(1).real", "x := 3", "sin", "sin(1, 2)", "sin(x=1)",
        "eval('1')", "open('f')", "1j", "True", "None", "3^2", "1 // 2", "{1}", "sin[0]", "*X",
        "print(1)", "1 if 2", "9" * 3000, "1/0", "9.0**9**9", "(" * 70 + "1" + ")" * 70 + "+y",
        "-" * 100 + "1", "[k for k in (1,)]", "\0", "await x", "1 is 1", "~1", "1 << 3",
        "1 in (1,)",
    ],
)  # fmt: skip
def test_anything_else_is_refused(text):
    with pytest.raises(InputError):
        number_in(text)


def test_powers_of_whole_numbers_do_not_grow_without_end():
    with pytest.raises(InputError, match="no finite number"):
        number_in("9**9**9**9")


def test_the_side_of_a_choice_that_is_not_taken_may_be_anything():
    t = {"t": 0.0}
    assert value_of("1 / t if t > 0 else 7", t) == 7.0
    assert value_of("t ** -0.5 if t > 0 else 7", t) == 7.0
    assert value_of("3 % t if t > 0 else 7", t) == 7.0
    field = TimeField(("where(X > 0.5, 1 / (X - 0.5), 0)", "0", "0"))
    np.testing.assert_allclose(field(X, 0.0)[:, 0], [0.0, 2.0])


def test_a_root_of_what_is_negative_is_no_complex_number():
    assert math.isnan(value_of("(-8) ** 0.5", {}))
    assert not is_finite_somewhere("(-8) ** 0.5", ("X",))
    # Early on it is a number.
    assert is_finite_somewhere("(0.5 - t) ** 0.5", ("t",))
    assert is_finite_somewhere("1 / (X - 0.5)", ("X",))


def test_a_condition_says_yes_or_no():
    assert is_condition("X > 1 and not Y < 0", ("X", "Y"))
    assert not is_condition("3", ("X",))
    assert not is_condition("X", ("X",))


def test_a_field_of_place():
    field = Field(("X + Y", "2", "-Z * pi"))
    np.testing.assert_array_equal(
        field(X), np.stack([X[:, 0] + X[:, 1], [2.0, 2.0], -X[:, 2] * math.pi], axis=1)
    )
    assert field(np.zeros((0, 3))).shape == (0, 3)


def test_fields_of_time_and_of_faces():
    np.testing.assert_array_equal(TimeField(("t", "X * t", "0"))(X, 2.0)[:, 1], 2.0 * X[:, 0])
    N = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    found = FaceField(("-5 * NX", "NY", "NZ + t"))(X, N, 1.0)
    np.testing.assert_array_equal(found, [[-5, 0, 1], [0, 1, 1]])


def test_a_condition():
    assert Condition("X > 0.5 and Z > 1")(X).tolist() == [False, True]
    assert Condition("1")(X).tolist() == [True, True]


def test_fields_go_to_other_processes_and_compare_by_value():
    field = TimeField(("t", "X", "0"))
    assert pickle.loads(pickle.dumps(field)) == field
    assert repr(field) == "TimeField(parts=('t', 'X', '0'))"


def test_a_division_within_the_body_is_found_where_the_scene_asks():
    with np.errstate(all="raise"):
        assert np.isinf(value_of("1 / X", {"X": np.zeros(1)})).all()
