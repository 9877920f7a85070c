"""Bodies described with what is no number, no box or no region: one sentence each."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry import (
    Blocks,
    Box,
    HoledBlock,
    PointCloud,
    Region,
    Surface,
    Tagged,
    TetBox,
    interior_lattice,
)

CUBE = Box().mesh(0.25)
SURFACE = Surface.closed(vertices=CUBE.vertices, faces=CUBE.boundary)
ONE = ((0, 0, 0), (1, 1, 1))


def everywhere(X):
    return np.ones(len(X), dtype=bool)


def broken(X):
    raise KeyError("no such zone")


def moving(X):
    X -= 0.5
    return X[:, 0] < 0.0


BAD = {
    "a lone block": (lambda: Blocks(ONE).mesh(0.5), r"blocks\[0\] = \(0, 0, 0\) is no box; .*lone"),
    "volume of a lone block": (lambda: Blocks(ONE).volume, r"blocks\[0\] .* is no box"),
    "a body as a block": (lambda: Blocks((Box(),)).mesh(0.5), r"blocks\[0\] = Box\(.* is no box"),
    "a body for blocks": (lambda: Blocks(Box()).mesh(0.5), r"= Box\(.* is not a tuple of boxes"),
    "a number for blocks": (lambda: Blocks(3).mesh(0.5), "blocks = 3 is not a tuple of boxes"),
    "a flat corner": (lambda: Blocks((ONE, ((1, 1), (2, 2)))).mesh(0.5), "box 1: lower = .1, 1"),
    "numbers for corners": (lambda: Box(0, 1).mesh(0.5), "lower = 0 is not three finite numbers"),
    "their volume": (lambda: Box(0, 1).volume, "lower = 0 is not three finite numbers; give .* m"),
    "words for numbers": (lambda: Box(("0", "0", "0"), (1, 1, 1)).mesh(0.5), r"lower = \('0',"),
    "their volume, too": (lambda: Box((0, 0, 0), "111").volume, "upper = '111' is not three"),
    "nothing in a corner": (lambda: Box((0, 0, 0), (1, None, 1)).mesh(0.5), r"upper = \(1, None,"),
    "a corner in a plane": (lambda: Box(upper=(1, 1)).mesh(0.5), r"upper = \(1, 1\) is not three"),
    "a corner at infinity": (lambda: Box(upper=(1, 1, np.inf)).mesh(0.5), "three finite numbers"),
    "a huge corner": (lambda: Box(upper=(1, 1, 10**400)).mesh(0.5), "three finite numbers"),
    "a word for jitter": (lambda: Box(jitter="a").mesh(0.5), "jitter = 'a' is not a number"),
    "no jitter": (lambda: Blocks((ONE,), jitter=None).mesh(0.5), "jitter = None is not a number"),
    "one aspect": (lambda: Box(aspect=2).mesh(0.5), "aspect = 2 is not three finite numbers"),
    "a word in aspect": (lambda: Box(aspect=(1, "2", 1)).mesh(0.5), r"aspect = \(1, '2', 1\)"),
    "a negative seed": (lambda: Box(jitter=0.2, seed=-1).mesh(0.5), "seed = -1 is not a whole"),
    "half a seed": (lambda: Box(jitter=0.2, seed=1.5).mesh(0.5), "seed = 1.5 is not a whole"),
    "no seed": (lambda: Blocks((ONE,), jitter=0.2, seed=None).mesh(0.5), "seed = None is not"),
    "a tetrahedral number": (lambda: TetBox(0, 1).mesh(0.5), "lower = 0 is not three"),
    "its volume": (lambda: TetBox(("0", "0", "0")).volume, r"lower = \('0', '0', '0'\)"),
    "its seed": (lambda: TetBox(seed=-1).mesh(0.5), "seed = -1 is not a whole number"),
    "its seed in words": (lambda: TetBox(seed="1").mesh(0.5), "seed = '1' is not a whole number"),
    "a holed number": (lambda: HoledBlock(0, 1), "lower = 0 is not three finite numbers"),
    "holed words": (lambda: HoledBlock(upper=("1", "1", "1")), r"upper = \('1', '1', '1'\)"),
    "a radius in words": (lambda: HoledBlock(radius="0.1"), "radius = '0.1' is not a number"),
    "no radius": (lambda: HoledBlock(radius=None), "radius = None is not a number"),
    "spacing of a cloud": (
        lambda: PointCloud.fill(surface=SURFACE, spacing="0.25"), "spacing = '0.25' is not a number"
    ),
    "no spacing of a cloud": (
        lambda: PointCloud.fill(surface=SURFACE, spacing=None), "spacing = None is not a number"
    ),
    "jitter of a cloud": (
        lambda: PointCloud.fill(surface=SURFACE, spacing=0.25, jitter="a"), "jitter = 'a' is not"
    ),
    "seed of a cloud": (
        lambda: PointCloud.fill(surface=SURFACE, spacing=0.25, jitter=0.1, seed=-1), "seed = -1"
    ),
    "spacing of a lattice": (
        lambda: interior_lattice(surface=SURFACE, spacing=(0.25,)), r"spacing = \(0.25,\) is not"
    ),
    "a lone region": (
        lambda: Tagged(Box(), Region("a", "Z+", everywhere)), "regions is a lone Region; put it"
    ),
    "words for regions": (lambda: Tagged(Box(), ("Z+",)), "regions holds 'Z.', which is no Region"),
    "no body": (lambda: Tagged("cube", ()), "Tagged: body = 'cube' cannot be used"),
    **{
        f"a region that {what}": (
            lambda name=name, contains=contains: Tagged(
                Box(), (Region(name, "Z+", contains),)
            ).mesh(0.25),
            named,
        )
        for what, name, contains, named in (
            ("fails", "a", broken, "region 'a': contains raised KeyError: 'no such zone'"),
            ("moves the body", "a", moving, "region 'a': contains raised ValueError: .*read-only"),
            ("is asked for time", "a", lambda X, t: X, r"raised TypeError: .*called with \(X\)"),
            ("is no function", "a", 0.5, "region 'a': contains raised TypeError"),
            ("returns nothing", "a", lambda X: None, "region 'a': contains must return a bool"),
            ("returns a ragged list", "a", lambda X: [[1], [1, 2]], "region 'a': contains raised"),
            ("has no name", 1, everywhere, "region 1 of face 'Z.': give two names"),
        )
    },
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_body_is_one_sentence(name):
    make, named = BAD[name]
    with pytest.raises(InputError, match=named) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_numbers_of_any_kind_are_numbers():
    """Lists, arrays and numbers of NumPy are what floats are, to the bit."""
    plain = Box((0.0, 0.0, 0.0), (1.0, 0.5, 1.0), jitter=0.2, seed=3).mesh(0.25)
    for lower, upper, seed in (
        ([0, 0, 0], [1, 0.5, 1], np.int64(3)),
        (np.zeros(3), np.array([1.0, 0.5, 1.0]), 3),
    ):
        mesh = Box(lower, upper, jitter=np.float64(0.2), seed=seed).mesh(np.float64(0.25))
        np.testing.assert_array_equal(mesh.vertices, plain.vertices)
    one = Blocks([[[0, 0, 0], [1, 0.5, 1]]], jitter=0.2, seed=3)
    np.testing.assert_array_equal(one.mesh(0.25).vertices, plain.vertices)
    assert Blocks(np.array([[[0, 0, 0], [1, 0.5, 1]]])).volume == 0.5


def test_regions_may_come_in_a_list():
    assert Tagged(Box(), [Region("a", "Z+", everywhere)]).mesh(0.5).face("a").shape == (4, 4)
