"""What a long set-up says: nothing at first, nothing into files, nothing that stays."""

from __future__ import annotations

import io

from sphsolid.cloud.slow_work import SlowWork


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_short_work_says_nothing() -> None:
    stream, times = Terminal(), iter([0.0, 1.0, 2.9])
    work = SlowWork("solving", stream=stream, now=lambda: next(times))
    work.at("iteration 1")
    work.at("iteration 2")
    work.over()
    assert stream.getvalue() == ""


def test_long_work_says_what_it_does_and_wipes_it() -> None:
    stream, times = Terminal(), iter([0.0, 4.0, 4.0, 4.1, 5.0, 5.0])
    work = SlowWork("solving", stream=stream, now=lambda: next(times))
    for k in range(3):
        work.at(f"iteration {k}")
    work.over()
    lines = stream.getvalue().split("\r")
    assert lines[1:3] == ["set-up: solving: iteration 0", "set-up: solving: iteration 2"]
    assert lines[-2].strip() == ""


def test_a_file_hears_nothing() -> None:
    stream, times = io.StringIO(), iter([0.0, 9.0, 9.0, 9.0])
    work = SlowWork("solving", stream=stream, now=lambda: next(times))
    work.at("iteration 1")
    work.over()
    assert stream.getvalue() == ""
