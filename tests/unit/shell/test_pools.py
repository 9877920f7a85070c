"""Work handed to a Dask client, without a cluster: what becomes of a task becomes of its future."""

from __future__ import annotations

from concurrent.futures import CancelledError

import pytest

from sphsolid.shell.pools import _OnClient


class FakeTask:
    """Ends when it is told to; its state says ``error`` although it has a result."""

    status = "error"

    def __init__(self, call):
        self.call, self.callbacks, self.is_cancelled = call, [], False

    def add_done_callback(self, callback):
        self.callbacks.append(callback)

    def end(self):
        for callback in self.callbacks:
            callback(self)

    def result(self):
        return self.call()

    def cancel(self):
        self.is_cancelled = True


class FakeClient:
    def submit(self, fn, *args, pure, **kwargs):
        assert not pure
        self.task = FakeTask(lambda: fn(*args, **kwargs))
        return self.task


def handed(fn, *args, **kwargs):
    client = FakeClient()
    future = _OnClient(client).submit(fn, *args, **kwargs)
    assert not future.done()
    return client.task, future


def test_a_result_is_handed_over_whatever_the_state_says():
    task, future = handed(int, "ff", base=16)
    task.end()
    assert future.result(timeout=1) == 255


def test_an_error_is_raised():
    task, future = handed(int, "x")
    task.end()
    with pytest.raises(ValueError, match="invalid literal"):
        future.result(timeout=1)


def test_who_gives_up_takes_the_task_back():
    task, future = handed(int, "1")
    assert future.cancel()
    assert task.is_cancelled
    task.end()
    with pytest.raises(CancelledError):
        future.result(timeout=1)
