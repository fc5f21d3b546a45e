"""What a run has come to so far, tick by tick: its time, its stops, whether the robot fell."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from humanoid_bt import Tree, load
from humanoid_bt.control.supervisor import Stop
from humanoid_bt.core.messages import Mode
from humanoid_bt.testing.course import Course


@pytest.fixture(scope="module")
def tree() -> Tree:
    return load("stand")


def view(time: float, mode: Mode = Mode.RUN) -> Any:
    """Return what is seen of a run in which nothing happens."""
    nothing: dict[str, Any] = {"changes": (), "touched": (), "bumped": (), "statuses": {}, "results": {}}
    return SimpleNamespace(time=time, state=SimpleNamespace(mode=mode), robot=None, **nothing)


def test_a_stop_counts_from_when_it_comes_also_where_the_run_did_not_begin_at_zero(tree: Tree) -> None:
    course = Course(tree, [Stop(0.1 + 0.2, Mode.PROTECTIVE_STOP, "silent", "supervisor", {})])
    counted = []
    for time in (0.2, 0.3, 0.4):
        course.tick(view(time))
        counted.append(course.stops)
    assert counted == [0, 1, 1]


def test_who_fell_has_fallen_whatever_follows(tree: Tree) -> None:
    course, fell = Course(tree), []
    for number, mode in enumerate((Mode.RUN, Mode.DAMP, Mode.RUN)):
        course.tick(view(0.1 * number, mode))
        fell.append(course.fell)
    assert fell == [False, True, True]


@pytest.mark.parametrize(("ended", "time"), [(0.5, 0.5), (0.25, 0.3)])
def test_a_run_takes_until_it_ends_and_at_least_until_its_last_tick(tree: Tree, ended: float, time: float) -> None:
    course = Course(tree)
    for now in (1.0, 1.3):
        course.tick(view(now))
    course.finish(SimpleNamespace(outcome="success", reason="", fell=False, time=ended))  # type: ignore[arg-type]  # all that it asks
    assert course.time == pytest.approx(time)
