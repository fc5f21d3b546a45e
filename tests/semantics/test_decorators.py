"""Decorators that run their child again, convert its result, or ask first."""

from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.executor import NodeError
from tests.semantics.claims import shows
from tests.tree.helpers import Run, run


def starts(under_test: Run, name: str = "act") -> int:
    """Return how often an act was started."""
    return under_test.log.count(("start", name))


def ticked(under_test: Run, name: str = "act") -> int:
    """Return how often an act was ticked."""
    ticks: int = next(vars(node.behaviour)["ticks"] for node in under_test.tree.nodes if node.name == name)
    return ticks


# ---- again and again -----------------------------------------------------------------------------------------------


@shows("loop-once-per-tick")
@pytest.mark.parametrize(
    "root",
    [
        "{retry: {attempts: 9, act: {script: f}}}",
        "{repeat: {times: 9, act: {script: s}}}",
        "{while: {condition: state.time >= 0, act: {script: s}}}",
        "{for_each: {item: k, items: [1, 2, 3, 4, 5], act: {script: s}}}",
        "{keep_running_until_failure: {act: {script: s}}}",
    ],
)
def test_one_run_per_tick(workspace: Workspace, root: str) -> None:
    loop = run(workspace, root)
    for count in (1, 2, 3):
        assert loop.ticks(1) == "r"
        assert starts(loop) == count


@shows("retry-ends")
def test_retry(workspace: Workspace) -> None:
    assert run(workspace, "{retry: {attempts: 3, act: {script: frfs}}}").ticks(4) == "rrrs"
    assert run(workspace, "{retry: {attempts: 2, act: {script: fff}}}").ticks(2) == "rf"


@shows("repeat-ends")
def test_repeat(workspace: Workspace) -> None:
    assert run(workspace, "{repeat: {times: 3, act: {script: srsf}}}").ticks(4) == "rrrf"
    assert run(workspace, "{repeat: {times: 2, act: {script: s}}}").ticks(2) == "rs"


@shows("loop-for-ever")
@pytest.mark.parametrize("root", ["{retry: {attempts: -1, failure: }}", "{repeat: {times: -1, success: }}"])
def test_for_ever(workspace: Workspace, root: str) -> None:
    assert run(workspace, root).ticks(100) == "r" * 100


@shows("loop-count-anew")
@pytest.mark.parametrize("root", ["{retry: {attempts: 2, failure: }}", "{repeat: {times: 2, success: }}"])
def test_they_count_anew(workspace: Workspace, root: str) -> None:
    loop = run(workspace, root)
    assert loop.ticks(4) in ("rfrf", "rsrs")
    loop.tick()
    loop.halt()
    assert loop.ticks(2) in ("rf", "rs")


@shows("keep-running")
def test_keep_running_until_failure(workspace: Workspace) -> None:
    assert run(workspace, "{keep_running_until_failure: {act: {script: srsf}}}").ticks(4) == "rrrf"


@shows("for-each-items")
def test_for_each(workspace: Workspace) -> None:
    each = run(workspace, "{for_each: {item: n, items: [1, 2, 3], sequence: [{log: '{n}'}, {condition: n < 3}]}}")
    assert each.ticks(3) == "rrf"
    assert [text for _, _, text in each.events] == ["1", "2", "3"]
    assert run(workspace, "{for_each: {item: n, items: [1, 2], condition: n < 3}}").ticks(2) == "rs"


@shows("for-each-empty")
def test_for_each_of_nothing(workspace: Workspace) -> None:
    each = run(workspace, "{for_each: {item: n, items: [], act: }}")
    assert each.ticks(1) == "s"
    assert starts(each) == 0


@shows("while-asks", "while-ends")
def test_while(workspace: Workspace) -> None:
    loop = run(workspace, "{while: {condition: {act: {name: asked, script: ssf}}, act: }}")
    assert loop.ticks(3) == "rrs"
    loop.log.remove(("start", "asked"))
    assert loop.log[:2] == [("SUCCESS", "asked"), ("start", "act")]
    assert loop.log[-2:] == [("FAILURE", "asked"), ("INVALID", "act")]
    assert ticked(loop) == 2
    assert run(workspace, "{while: {condition: state.time >= 0, act: {script: sf}}}").ticks(2) == "rf"


# ---- results -------------------------------------------------------------------------------------------------------


@shows("inverter", "force")
@pytest.mark.parametrize(
    ("kind", "statuses"), [("inverter", "rfs"), ("force_success", "rss"), ("force_failure", "rff")]
)
def test_another_result(workspace: Workspace, kind: str, statuses: str) -> None:
    assert run(workspace, f"{{{kind}: {{act: {{script: rsf}}}}}}").ticks(3) == statuses


@shows("running-is")
@pytest.mark.parametrize(("kind", "statuses"), [("running_is_success", "ssf"), ("running_is_failure", "fsf")])
def test_running_as_an_end(workspace: Workspace, kind: str, statuses: str) -> None:
    converted = run(workspace, f"{{{kind}: {{act: {{script: rsf}}}}}}")
    assert converted.ticks(1) == statuses[0]
    assert converted.log == [("start", "act"), ("INVALID", "act")]
    assert converted.ticks(2) == statuses[1:]


@shows("is-running")
@pytest.mark.parametrize(
    ("kind", "script", "end"), [("success_is_running", "srf", "f"), ("failure_is_running", "frs", "s")]
)
def test_an_end_as_running(workspace: Workspace, kind: str, script: str, end: str) -> None:
    converted = run(workspace, f"{{{kind}: {{act: {{script: {script}}}}}}}")
    assert converted.ticks(3) == "rr" + end
    assert starts(converted) == 2


@shows("once-keeps", "once-policy")
@pytest.mark.parametrize(
    ("policy", "script", "statuses", "runs"),
    [("completion", "rs", "rsss", 1), ("completion", "f", "ffff", 1), ("success", "ffs", "ffss", 3)],
)
def test_once(workspace: Workspace, policy: str, script: str, statuses: str, runs: int) -> None:
    once = run(workspace, f"{{once: {{policy: {policy}, act: {{script: {script}}}}}}}")
    assert once.ticks(4) == statuses
    once.halt()
    assert once.ticks(1) == statuses[-1]
    assert starts(once) == runs


@shows("once-halted")
def test_once_starts_a_halted_child_again(workspace: Workspace) -> None:
    once = run(workspace, "{once: {act: {script: rrs}}}")
    once.tick()
    once.halt()
    assert once.ticks(2) == "rs"
    assert starts(once) == 2


@shows("status-to-blackboard")
def test_status_to_blackboard(workspace: Workspace) -> None:
    child = "{force_success: {status_to_blackboard: {key: k, act: {script: rsfx}}}}"
    told = run(workspace, f"{{on_error: {{parallel: [{{repeat: {child}}}, {{repeat: {{log: '{{k}}'}}}}]}}}}")
    told.ticks(4)
    assert [text for _, level, text in told.events if level == "info"] == ["running", "success", "failure"]
    key = next(vars(node.behaviour)["key"] for node in told.tree.nodes if node.name == "status_to_blackboard")
    assert key.value == "invalid"
    halted = run(workspace, "{sequence: [{status_to_blackboard: {key: k, act: }}, {condition: k == 'x'}]}")
    halted.tick()
    halted.halt()
    assert vars(halted.tree.nodes[1].behaviour)["key"].value == "invalid"


# ---- guard and precondition ----------------------------------------------------------------------------------------


@shows("guard-asks")
def test_guard(workspace: Workspace) -> None:
    guard = run(workspace, "{guard: {condition: {act: {name: asked, script: ssf}}, act: }}")
    assert guard.ticks(3) == "rrf"
    assert guard.log[1:3] == [("SUCCESS", "asked"), ("start", "act")]
    assert guard.log[-2:] == [("FAILURE", "asked"), ("INVALID", "act")]
    assert ticked(guard) == 2


@shows("guard-doubt")
def test_nothing_runs_whose_guard_is_in_doubt(workspace: Workspace) -> None:
    guard = run(workspace, "{guard: {condition: {act: {name: asked, script: sr}}, act: }}")
    assert guard.ticks(2) == "rr"
    assert guard.log[-1] == ("INVALID", "act")


@shows("precondition-once", "precondition-fails")
def test_precondition(workspace: Workspace) -> None:
    pre = run(workspace, "{precondition: {condition: {act: {name: asked, script: fsf}}, act: {script: rrs}}}")
    assert pre.ticks(5) == "frrsf"
    assert starts(pre, "asked") == 3
    assert starts(pre) == 1


# ---- on_error ------------------------------------------------------------------------------------------------------


@shows("on-error-fails", "on-error-again")
def test_on_error_fails_and_halts(workspace: Workspace) -> None:
    inner = "{sequence: [{act: {name: a, script: s}}, {act: {name: bad, script: rxr}}]}"
    caught = run(workspace, f"{{on_error: {{parallel: [{{act: {{name: other}}}}, {inner}]}}}}")
    assert caught.ticks(2) == "rf"
    assert sorted(caught.told()[:-1]) == [(name, "INVALID") for name in ("a", "bad", "other", "parallel", "sequence")]
    halted = [name for name, _ in caught.told()]
    assert halted.index("bad") < halted.index("sequence") < halted.index("parallel") < halted.index("on_error")
    assert caught.log.count(("INVALID", "other")) == 1
    assert caught.ticks(1) == "r"
    assert [name for event, name in caught.log if event == "start"] == ["other", "a", "bad"] * 2


@shows("on-error-told")
def test_what_on_error_takes_is_told(workspace: Workspace) -> None:
    caught = run(workspace, "{on_error: {act: {name: bad, script: x}}}")
    caught.tick()
    [(source, level, text)] = caught.events
    assert (source, level) == ("t/on_error", "warning")
    for part in ("t/on_error/bad", "t.yaml:2:", "out of order", "test_skills.py:"):
        assert part in text


@shows("on-error-halt")
def test_on_error_takes_what_is_raised_in_a_halt(workspace: Workspace) -> None:
    caught = run(workspace, "{reactive_selector: [{act: {script: fr}}, {on_error: bad_end}]}")
    assert caught.ticks(2) == "rr"
    assert "cannot stop" in caught.events[0][2]


@shows("on-error-inner")
def test_the_inner_one_acts(workspace: Workspace) -> None:
    caught = run(workspace, "{on_error: {name: outer, force_success: {on_error: {name: inner, act: {script: x}}}}}")
    assert caught.ticks(1) == "s"
    assert [source.rpartition("/")[2] for source, _, _ in caught.events] == ["inner"]


@shows("on-error-not")
@pytest.mark.parametrize("error", ["ResourceConflict", "ControlLost"])
def test_what_on_error_does_not_take(workspace: Workspace, error: str) -> None:
    import humanoid_bt.core.errors

    caught = run(workspace, "{on_error: act}")

    def raise_it() -> None:
        raise getattr(humanoid_bt.core.errors, error)("no")

    caught.tree.nodes[1].behaviour.update = raise_it  # type: ignore[assignment, method-assign]  # this node alone
    with pytest.raises(NodeError, match=error):
        caught.tick()


@shows("on-error-not")
def test_on_error_does_not_take_ctrl_c(workspace: Workspace) -> None:
    caught = run(workspace, "{on_error: act}")

    def press() -> None:
        raise KeyboardInterrupt

    caught.tree.nodes[1].behaviour.update = press  # type: ignore[assignment, method-assign]  # this node alone
    with pytest.raises(KeyboardInterrupt):
        caught.tick()


# ---- leaves --------------------------------------------------------------------------------------------------------


@shows("leaves-plain")
@pytest.mark.parametrize(("leaf", "statuses"), [("success", "ss"), ("failure", "ff"), ("running", "rr")])
def test_plain_leaves(workspace: Workspace, leaf: str, statuses: str) -> None:
    assert run(workspace, leaf).ticks(2) == statuses


@shows("log-once")
def test_log_tells_once_for_each_start(workspace: Workspace) -> None:
    log = run(workspace, "{repeat: {times: 3, log: 'at {state.time}'}}")
    assert log.ticks(3) == "rrs"
    assert [text for _, _, text in log.events] == ["at 0 s", "at 0.1 s", "at 0.2 s"]


@shows("log-silent")
@pytest.mark.parametrize(
    "root", ["{reactive_sequence: [{log: hello}, act]}", "{guard: {condition: {log: hello}, act: }}"]
)
def test_log_is_silent_when_it_is_only_asked_again(workspace: Workspace, root: str) -> None:
    log = run(workspace, root)
    assert log.ticks(3) == "rrr"
    assert len(log.events) == 1
