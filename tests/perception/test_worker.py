"""What of a source's answers is published, and why others are refused."""

from __future__ import annotations

import math
import queue
import time
from typing import Any, cast

import numpy as np
import pytest

from humanoid_bt.core.messages import Percept
from humanoid_bt.perception.source import PerceptSource
from humanoid_bt.perception.worker import PerceptError, Worker, checked

GOOD = Percept("cup", 1.0, np.array([1.0, 0, 0]), 0.5)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (None, "gave None"),
        (GOOD, "gave a percept, and must give a list"),
        (["cup"], "which is no Percept"),
        ([GOOD, GOOD], "'cup' twice"),
        ([Percept("bowl", 1.0, GOOD.position, 0.5)], "'bowl', which it does not publish: it publishes cup"),
        ([Percept("cup", 1.0, np.array([1.0, np.nan, 0]), 0.5)], "has the position"),
        ([Percept("cup", 1.0, np.zeros(2), 0.5)], "has the position"),
        ([Percept("cup", 1.0, GOOD.position, 1.5)], "confidence 1.5: it is from 0 to 1"),
        ([Percept("cup", 9.0, GOOD.position, 0.5)], "it was not seen yet"),
        ([Percept("cup", -99.0, GOOD.position, 0.5)], "has the stamp of 100 s ago: .* of 60 s"),
        ([Percept("cup", 1.0, 2000 * GOOD.position, 0.5)], "is 2000 m away: positions are in metres"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, size=np.array([1, 0, 1]))], "lengths are above 0"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, orientation=np.ones(4))], "a unit quaternion"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, covariance=-np.eye(3))], "not symmetric and positive"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, covariance=np.full((2, 2), np.nan))], r"\[nan, nan\], \[nan, nan\]"),
        ([Percept("cup", 1.0, GOOD.position, 0.5, class_name=3)], "no text"),  # type: ignore[arg-type]  # the mistake that is tried
    ],
)
def test_only_sound_percepts_of_its_own_are_published(given: Any, why: str) -> None:
    with pytest.raises(PerceptError, match=why.replace("(", r"\(")):
        checked(given, ["cup"], 1.0)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (Percept("cup", 1.02, GOOD.position, 0.5), "it was not seen yet"),  # of the next tick
        (Percept("cup", 1.0, GOOD.position, 0.5, orientation=np.array([0.9, 0, 0, 0])), "a unit quaternion"),
        (Percept("cup", 1.0, GOOD.position, 0.5, orientation=np.array([1.1, 0, 0, 0])), "a unit quaternion"),
        (Percept("cup", 1.0, GOOD.position, 0.5, covariance=np.eye(3) + np.eye(3, k=1) / 2), "not symmetric"),
    ],
)
def test_percepts_that_are_a_little_wrong_are_refused(given: Percept, why: str) -> None:
    with pytest.raises(PerceptError, match=why):
        checked([given], ["cup"], 1.0)


# a field that is lost here is lost for trees
def test_everything_that_a_source_tells_is_published() -> None:
    turn = np.array([math.cos(0.2), 0, 0, math.sin(0.2)])
    given = Percept("cup", 0.9, GOOD.position, 0.5, np.array([1.0, 2, 3]), 0.7, turn, "mug", 0.01 * np.eye(3))
    (published,) = checked([given], ["cup"], 1.0)
    assert (published.stamp, published.confidence, published.heading, published.class_name) == (0.9, 0.5, 0.7, "mug")
    for field in ("position", "size", "orientation", "covariance"):
        array = getattr(published, field)
        np.testing.assert_array_equal(array, getattr(given, field))
        assert not array.flags.writeable


def test_no_wait_for_a_source_is_so_long_that_ctrl_c_just_before_it_is_not_heard() -> None:
    now, waits = [0.0], list[float]()

    class Silent:
        """Answers nothing, in no time."""

        def get(self, timeout: float) -> Any:
            waits.append(timeout)
            now[0] += timeout
            raise queue.Empty

    worker = Worker(cast(PerceptSource, None), "slow")
    worker._answers = cast(Any, Silent())
    worker.busy, worker._limit = True, 60.0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time, "monotonic", lambda: now[0])
        worker.take(wait=True)
    worker.close()
    assert max(waits) <= 0.1
    assert sum(waits) == pytest.approx(60.0, abs=0.1)
    assert worker.off == "has been at it for more than 60 s"
