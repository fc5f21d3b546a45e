from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType

import pytest

from humanoid_bt.core.ctrl_c import is_ctrl_c


def raised_by(code: Callable[[], None]) -> BaseException:
    try:
        code()
    except BaseException as error:
        return error
    raise AssertionError("nothing was raised")


def press() -> None:
    signal.raise_signal(signal.SIGINT)


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.fixture
def handled() -> Iterator[None]:
    """A program that handles the signal itself."""

    def handler(_number: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("handled")
def test_what_a_handler_raises_is_somebodys_and_what_code_raises_its_own() -> None:
    assert is_ctrl_c(raised_by(press))
    assert not is_ctrl_c(raised_by(interrupt))


def test_pythons_own_handler_leaves_no_trace_and_acts_in_the_main_thread_only() -> None:
    assert is_ctrl_c(raised_by(press))
    assert is_ctrl_c(raised_by(interrupt))
    found: list[bool] = []
    thread = threading.Thread(target=lambda: found.append(is_ctrl_c(raised_by(interrupt))))
    thread.start()
    thread.join()
    assert found == [False]


def test_nothing_else_is_one() -> None:
    assert not is_ctrl_c(raised_by(lambda: exec("raise SystemExit")))
