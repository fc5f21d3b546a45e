"""A network in a thread of its own: whoever asks it waits as long as it has said, or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from threading import Event

import numpy as np
import pytest

from humanoid_bt.control.body.policy import inference
from humanoid_bt.control.body.policy.inference import Inference
from humanoid_bt.robot.policy.network import Tensor

ONE = {"obs": np.ones(1, np.float32)}


class Stub:
    """A network that does what a test says."""

    def __init__(self, work: Callable[[], list[Tensor]]) -> None:
        self._work = work

    def run(self, _outputs: list[str], _inputs: Mapping[str, Tensor]) -> list[Tensor]:
        return self._work()


def made(work: Callable[[], list[Tensor]], *, waits: bool) -> Inference:
    return Inference(Stub(work), ["action"], waits=waits)  # type: ignore[arg-type]  # a network of a test's own


def test_time_that_stands_still_waits_for_the_answer() -> None:
    asked = made(lambda: [ONE["obs"]], waits=True)
    asked.ask(ONE)
    assert asked.take() == [ONE["obs"]]
    assert not asked.busy


def test_the_wall_clock_does_not_wait() -> None:
    over = Event()

    def work() -> list[Tensor]:
        over.wait()
        return [ONE["obs"]]

    asked = made(work, waits=False)
    asked.ask(ONE)
    assert asked.take() is None
    assert asked.busy, "it still computes"
    over.set()


def test_nothing_waits_for_ever_nor_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inference, "PATIENCE", 0.05)
    over = Event()

    def work() -> list[Tensor]:
        over.wait()
        return []

    asked = made(work, waits=True)
    asked.ask(ONE)
    assert asked.take() is None
    monkeypatch.setattr(inference, "PATIENCE", 1e6)
    assert asked.take() is None
    over.set()


def test_an_error_is_told_to_whoever_takes_the_answer() -> None:
    def work() -> list[Tensor]:
        raise RuntimeError("no such input")

    asked = made(work, waits=True)
    asked.ask(ONE)
    with pytest.raises(RuntimeError, match="no such input"):
        asked.take()
    assert not asked.busy
