"""Time: limits on the engine's clock. A tick comes every 0.1 s."""

from __future__ import annotations

import time

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.semantics.claims import shows
from tests.tree.helpers import run


@shows("time-clock")
@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        ("{timeout: {duration: 0.2, act: }}", "rrf"),
        ("{wait: 0.2}", "rrs"),
        ("{delay: {duration: 0.2, success: }}", "rrs"),
    ],
)
def test_no_wall_clock(workspace: Workspace, monkeypatch: pytest.MonkeyPatch, root: str, statuses: str) -> None:
    for name in ("time", "monotonic", "perf_counter"):
        monkeypatch.setattr(time, name, lambda: 1e9)
    under_test = run(workspace, root)
    assert under_test.ticks(3) == statuses
    frozen = run(workspace, root)
    frozen.tick()
    for _ in range(9):  # engine time stands still
        frozen.clock.cycle = 0
        frozen.tick()
    assert frozen.executor.status.name == "RUNNING"


@shows("time-equal")
def test_limits_are_reached_when_they_are_equal(workspace: Workspace) -> None:
    for start in range(20):  # times are sums of floats: 0.3 - 0.1 is a little less than 0.2
        wait = run(workspace, "{wait: 0.2}")
        wait.clock.cycle = 100 * start
        assert wait.ticks(3) == "rrs"
        limit = run(workspace, "{timeout: {duration: 0.2, act: }}")
        limit.clock.cycle = 100 * start
        assert limit.ticks(3) == "rrf"
        asks = run(workspace, "{ros_service: {service: /never, type: x/A, timeout: 0.2 s}}")
        asks.clock.cycle = 100 * start
        assert asks.ticks(3) == "rrf"
    assert run(workspace, "{wait: 0.20001}").ticks(3) == "rrr"


@shows("timeout-first", "timeout-limit")
def test_a_success_at_the_limit_comes_too_late(workspace: Workspace) -> None:
    in_time = run(workspace, "{timeout: {duration: 0.3, act: {script: rrs}}}")
    assert in_time.ticks(3) == "rrs"
    late = run(workspace, "{timeout: {duration: 0.2, act: {script: rrs}}}")
    assert late.ticks(3) == "rrf"
    assert late.log == [("start", "act"), ("INVALID", "act")]
    assert vars(late.tree.nodes[1].behaviour)["ticks"] == 2


@shows("timeout-anew")
def test_a_timeout_measures_anew(workspace: Workspace) -> None:
    late = run(workspace, "{retry: {attempts: 2, timeout: {duration: 0.2, act: }}}")
    assert late.ticks(6) == "rrrrrf"
    assert late.feedback("timeout") == "timed out after 0.2 s (limit 0.2 s)"


@shows("wait-limit")
def test_wait(workspace: Workspace) -> None:
    assert run(workspace, "{wait: 0.2}").ticks(3) == "rrs"
    assert run(workspace, "{wait: 0.25}").ticks(4) == "rrrs"
    assert run(workspace, "{wait: 0}").ticks(1) == "s"


@shows("delay-limit")
def test_delay(workspace: Workspace) -> None:
    delay = run(workspace, "{delay: {duration: 0.2, act: {script: s}}}")
    assert delay.ticks(6) == "rrsrrs"
    assert run(workspace, "{delay: {duration: 0, act: {script: s}}}").ticks(1) == "s"


@shows("cooldown-limit")
def test_cooldown(workspace: Workspace) -> None:
    cool = run(workspace, "{cooldown: {duration: 0.2, act: {script: rss}}}")
    assert cool.ticks(6) == "rsfsfs"
    assert [name for event, name in cool.log if event == "start"] == ["act"] * 3


@shows("cooldown-halt", "cooldown-goes-on")
def test_cooldown_counts_from_a_halt_and_goes_on(workspace: Workspace) -> None:
    cool = run(workspace, "{cooldown: {duration: 0.2, act: }}")
    cool.ticks(3)
    cool.halt()  # at 0.3
    assert cool.ticks(3) == "ffr"
    cooldown = "{cooldown: {duration: 0.35, act: {script: s}}}"
    left = run(workspace, f"{{reactive_selector: [{{act: {{script: fssff}}}}, {cooldown}, running]}}")
    assert left.ticks(5) == "sssrs"  # it ran at 0 and at 0.4; in between it was not ticked but at 0.3


@shows("min-duration-limit", "min-duration-child")
@pytest.mark.parametrize(
    ("script", "statuses", "ticked"), [("sf", "rrs", 1), ("rf", "rrf", 2), ("rrrs", "rrrs", 4), ("rrs", "rrs", 3)]
)
def test_min_duration(workspace: Workspace, script: str, statuses: str, ticked: int) -> None:
    least = run(workspace, f"{{min_duration: {{duration: 0.2, act: {{script: {script}}}}}}}")
    assert least.ticks(len(statuses)) == statuses
    assert vars(least.tree.nodes[1].behaviour)["ticks"] == ticked
