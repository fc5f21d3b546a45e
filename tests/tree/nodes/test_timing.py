from __future__ import annotations

import pytest
from py_trees.common import Status

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.forcing import force
from tests.tree.helpers import run


@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        ("{delay: {duration: 0.2 s, act: {script: sf}}}", "rrsrrf"),
        ("{delay: {duration: 0 s, act: {script: s}}}", "s"),
        ("{min_duration: {duration: 0.2 s, act: {script: sf}}}", "rrsrrf"),
        ("{min_duration: {duration: 0.2 s, act: {script: rrrs}}}", "rrrs"),
        ("{cooldown: {duration: 0.3 s, act: {script: s}}}", "sffs"),
        ("{cooldown: {duration: 0.3 s, act: {script: frs}}}", "fffrsff"),
    ],
)
def test_status_of_a_timed_decorator(workspace: Workspace, root: str, statuses: str) -> None:
    assert run(workspace, root).ticks(len(statuses)) == statuses


def test_delay_starts_its_child_when_the_time_is_over(workspace: Workspace) -> None:
    delay = run(workspace, "{delay: {duration: 0.2 s, act: {script: rs}}}")
    delay.ticks(2)
    assert delay.log == []
    assert delay.feedback("delay") == "starts in 0.1 s"
    assert delay.ticks(2) == "rs"
    assert delay.feedback("delay") == ""
    delay.tick()
    assert delay.told() == [("act", "INVALID"), ("delay", "RUNNING")]  # it has not run this time


def test_a_halted_delay_waits_again(workspace: Workspace) -> None:
    delay = run(workspace, "{delay: {duration: 0.2 s, act: {script: r}}}")
    delay.tick()
    delay.halt()
    assert delay.told() == [("delay", "INVALID")]
    assert delay.ticks(2) == "rr"
    assert delay.log == []


def test_min_duration_does_not_tick_a_child_that_ended(workspace: Workspace) -> None:
    least = run(workspace, "{min_duration: {duration: 0.2 s, act: {script: f}}}")
    assert least.ticks(2) == "rr"
    assert least.feedback("min_duration") == "failure, in 0.1 s"
    assert least.ticks(1) == "f"
    assert least.log == [("start", "act"), ("FAILURE", "act")]


def test_cooldown_counts_from_a_result_that_is_forced(workspace: Workspace) -> None:
    cooldown = run(workspace, "{cooldown: {duration: 0.2 s, act: }}")
    cooldown.ticks(5)
    force(cooldown.tree.root, Status.SUCCESS, "forced")
    assert cooldown.ticks(3) == "sfr"


def test_the_tip_of_min_duration_is_itself_while_it_goes_on_alone(workspace: Workspace) -> None:
    least = run(workspace, "{min_duration: {duration: 0.2 s, act: {script: rs}}}")
    tips = []
    for _ in range(3):
        least.tick()
        tips.append(least.tree.root.tip().name)  # type: ignore[union-attr]  # it was ticked
    assert tips == ["act", "min_duration", "act"]


def test_cooldown_counts_from_a_halt(workspace: Workspace) -> None:
    cooldown = run(workspace, "{cooldown: {duration: 0.2 s, act: {script: r}}}")
    cooldown.ticks(5)
    cooldown.halt()  # at 0.5 s
    assert cooldown.ticks(3) == "ffr"
    assert cooldown.log == [("start", "act"), ("INVALID", "act"), ("start", "act")]


def test_cooldown_counts_on_while_it_is_not_ticked(workspace: Workspace) -> None:
    cooldown = run(workspace, "{cooldown: {duration: 0.3 s, act: {script: s}}}")
    cooldown.tick()
    cooldown.halt()
    cooldown.clock.cycle += 100
    assert cooldown.ticks(2) == "fs"


def test_cooldown_counts_after_an_exception(workspace: Workspace) -> None:
    cooldown = run(workspace, "{on_error: {cooldown: {duration: 0.2 s, act: {script: xs}}}}")
    assert cooldown.ticks(3) == "ffs"
    assert len(cooldown.events) == 1


def test_cooldown_says_how_long(workspace: Workspace) -> None:
    cooldown = run(workspace, "{cooldown: {duration: 0.3 s, act: {script: s}}}")
    cooldown.ticks(2)
    assert cooldown.told() == [("act", "INVALID"), ("cooldown", "FAILURE")]  # the child has not run this time
    assert cooldown.feedback("cooldown") == "cools down for 0.2 s more"
