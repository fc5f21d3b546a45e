"""Sequence, selector, parallel, if and switch; who preempts whom."""

from __future__ import annotations

import pytest

from humanoid_bt.core.errors import ResourceConflict, UserError
from humanoid_bt.files.workspace import Workspace
from tests.semantics.claims import shows
from tests.tree.helpers import Run, load, run, seen

SWITCHED = "inverter: {act: {name: switch, script: ssf}}"
"""Fails twice, then succeeds."""


def acts(*scripts: str) -> str:
    """Return acts named a, b, c with these scripts, as children."""
    named = zip("abc", scripts, strict=False)
    return "[" + ", ".join(f"{{act: {{name: {name}, script: {script}}}}}" for name, script in named) + "]"


def started(under_test: Run) -> str:
    """Return the names of the acts that were started, in order."""
    return "".join(name for event, name in under_test.log if event == "start")


# ---- sequence and selector -----------------------------------------------------------------------------------------


@shows("sequence-order")
def test_a_sequence_runs_its_children_in_order(workspace: Workspace) -> None:
    sequence = run(workspace, f"{{sequence: {acts('s', 's', 's')}}}")
    assert sequence.ticks(1) == "s"
    assert started(sequence) == "abc"


@shows("sequence-decides")
@pytest.mark.parametrize(("script", "status"), [("f", "f"), ("r", "r")])
def test_a_sequence_ends_at_the_first_that_does_not_succeed(workspace: Workspace, script: str, status: str) -> None:
    sequence = run(workspace, f"{{sequence: {acts('s', script, 's')}}}")
    assert sequence.ticks(1) == status
    assert started(sequence) == "ab"


@shows("selector-order")
def test_a_selector_tries_its_children_in_order(workspace: Workspace) -> None:
    selector = run(workspace, f"{{selector: {acts('f', 'f', 'f')}}}")
    assert selector.ticks(1) == "f"
    assert started(selector) == "abc"


@shows("selector-decides")
@pytest.mark.parametrize(("script", "status"), [("s", "s"), ("r", "r")])
def test_a_selector_ends_at_the_first_that_does_not_fail(workspace: Workspace, script: str, status: str) -> None:
    selector = run(workspace, f"{{selector: {acts('f', script, 's')}}}")
    assert selector.ticks(1) == status
    assert started(selector) == "ab"


@shows("composite-goes-on")
@pytest.mark.parametrize(("kind", "first"), [("sequence", "s"), ("selector", "f")])
def test_they_go_on_with_the_child_that_runs(workspace: Workspace, kind: str, first: str) -> None:
    composite = run(workspace, f"{{{kind}: {acts(first, 'r' + first, 'r')}}}")
    composite.ticks(4)
    assert started(composite) == "abc"


@shows("composite-begins-anew")
@pytest.mark.parametrize("end", ["s", "f", "halt"])
def test_an_end_lets_them_begin_with_the_first_child(workspace: Workspace, end: str) -> None:
    script = "rr" if end == "halt" else "r" + end
    sequence = run(workspace, f"{{sequence: {acts('s', script + 'r')}}}")
    sequence.ticks(2)
    if end == "halt":
        sequence.halt()
    sequence.tick()
    assert started(sequence) == "abab"


@shows("reactive-order")
@pytest.mark.parametrize(("kind", "passed", "decides"), [("sequence", "s", "f"), ("selector", "f", "s")])
def test_the_reactive_ones_take_turns_and_decide_alike(
    workspace: Workspace, kind: str, passed: str, decides: str
) -> None:
    all_passed = run(workspace, f"{{reactive_{kind}: {acts(passed, passed, passed)}}}")
    assert all_passed.ticks(1) == passed
    assert started(all_passed) == "abc"
    for status in (decides, "r"):
        decided = run(workspace, f"{{reactive_{kind}: {acts(passed, status, passed)}}}")
        assert decided.ticks(1) == status
        assert started(decided) == "ab"


@shows("reactive-asks-again")
@pytest.mark.parametrize(("kind", "first"), [("sequence", "s"), ("selector", "f")])
def test_the_reactive_ones_begin_with_the_first_child_in_every_tick(
    workspace: Workspace, kind: str, first: str
) -> None:
    composite = run(workspace, f"{{reactive_{kind}: {acts(first, 'r')}}}")
    composite.ticks(3)
    assert started(composite) == "abaa"


@shows("reactive-starts-again")
@pytest.mark.parametrize(("kind", "passed"), [("sequence", "s"), ("selector", "f")])
def test_what_ran_starts_again_and_preempts(workspace: Workspace, kind: str, passed: str) -> None:
    composite = run(workspace, f"{{reactive_{kind}: {acts('r' + passed + 'r', 'r')}}}")
    assert composite.ticks(3) == "rrr"
    assert started(composite) == "aba"
    assert composite.log[-1] == ("INVALID", "b")


# ---- preemption ----------------------------------------------------------------------------------------------------


@shows("preempt-same-tick")
def test_what_runs_behind_is_halted_after_the_earlier_child_was_ticked(workspace: Workspace) -> None:
    selector = run(workspace, f"{{reactive_selector: {acts('fr', 'r')}}}")
    selector.tick()
    selector.log.clear()
    selector.tick()
    assert selector.log == [("start", "a"), ("INVALID", "b")]
    sequence = run(workspace, f"{{reactive_sequence: {acts('sf', 'r')}}}")
    sequence.tick()
    sequence.log.clear()
    sequence.tick()
    assert sequence.log == [("start", "a"), ("FAILURE", "a"), ("INVALID", "b")]


@shows("preempt-release", "preempt-acquire")
def test_resources_are_released_before_they_are_acquired(workspace: Workspace) -> None:
    new, old = f"{{sequence: [{{{SWITCHED}}}, {{idle: {{name: new}}}}]}}", "{idle: {name: old}}"
    taken = run(workspace, f"{{emergency_stop: {{reactive_selector: [{new}, {old}]}}}}")
    owners = [taken.tick().sources["gaze"].rpartition("/")[2] for _ in range(3)]
    assert owners == ["old", "old", "new"]
    later = f"{{parallel: {{failure: one, children: [{old}, {{act: {{script: rf}}}}]}}}}"
    ended = run(workspace, f"{{emergency_stop: {{selector: [{later}, {{idle: {{name: new}}}}]}}}}")
    owners = [ended.tick().sources["gaze"].rpartition("/")[2] for _ in range(2)]
    assert owners == ["old", "new"]  # the old one asked for it in this tick, and was halted


THIEF = """
from humanoid_bt import RobotHandle, Skill, Status

class Thief(Skill):
    def setup(self, **kwargs):
        self.robot = RobotHandle(kwargs["robot"], self.path, ("gaze",))
    def update(self):
        self.robot.look_at([0, 0, 0])
        return Status.RUNNING
"""


@shows("preempt-two-owners")
def test_two_living_owners_are_an_error_that_names_both(workspace: Workspace) -> None:
    (workspace.root / "skills" / "thief.py").write_text(THIEF, encoding="utf-8")  # it does not say what it commands
    thief = run(workspace, "{emergency_stop: {parallel: [idle, thief]}}")
    with pytest.raises(ResourceConflict, match=r"'gaze' .*parallel/idle' and .*parallel/thief'"):
        thief.tick()


# ---- parallel ------------------------------------------------------------------------------------------------------


@shows("parallel-all", "parallel-ended")
def test_a_parallel_ticks_all_that_have_not_ended(workspace: Workspace) -> None:
    parallel = run(workspace, f"{{parallel: {acts('s', 'rrs', 'rs')}}}")
    assert parallel.ticks(3) == "rrs"
    assert [vars(node.behaviour)["ticks"] for node in parallel.tree.nodes[1:]] == [1, 3, 2]
    parallel.tick()
    assert started(parallel) == "abcabc"


@shows("parallel-no-shortcut")
def test_children_behind_the_one_that_decides_are_ticked(workspace: Workspace) -> None:
    parallel = run(workspace, f"{{parallel: {acts('f', 's', 'r')}}}")
    assert parallel.ticks(1) == "f"
    assert started(parallel) == "abc"


@shows("parallel-success", "parallel-failure")
@pytest.mark.parametrize(
    ("success", "failure", "statuses"),
    [
        ("one", "all", "s"),
        ("2", "all", "rs"),
        ("all", "all", "rrf"),
        ("all", "one", "rrf"),
    ],
)
def test_thresholds(workspace: Workspace, success: str, failure: str, statuses: str) -> None:
    root = f"{{parallel: {{success: {success}, failure: {failure}, children: {acts('s', 'rs', 'rrf')}}}}}"
    assert run(workspace, root).ticks(len(statuses)) == statuses


@shows("parallel-both", "parallel-too-few")
def test_in_doubt_it_fails(workspace: Workspace) -> None:
    both = f"{{parallel: {{success: one, failure: one, children: {acts('s', 'f')}}}}}"
    assert run(workspace, both).ticks(1) == "f"
    few = f"{{parallel: {{success: 2, failure: 2, children: {acts('s', 'f')}}}}}"
    assert run(workspace, few).ticks(1) == "f"


@shows("parallel-halts")
def test_the_end_of_a_parallel_halts_what_runs(workspace: Workspace) -> None:
    parallel = run(workspace, f"{{parallel: {{success: one, children: {acts('rs', 'r')}}}}}")
    parallel.ticks(2)
    assert parallel.log[-1] == ("INVALID", "b")


@shows("parallel-overlap")
def test_children_that_command_the_same_are_refused(workspace: Workspace) -> None:
    never_at_once = "{sequence: [failure, idle]}"
    with pytest.raises(UserError, match="run at once and both command gaze"):
        load(workspace, f"root: {{emergency_stop: {{parallel: [idle, {never_at_once}]}}}}")


# ---- if and switch -------------------------------------------------------------------------------------------------

THEN_ELSE = "then: {act: {name: a, script: rrrs}}, else: {act: {name: b, script: rrrs}}"
EARLY = "state.time < 0.15"


@shows("if-chooses-once")
def test_if_asks_up_to_the_first_answer(workspace: Workspace) -> None:
    choice = run(workspace, f"{{if: {{condition: {{act: {{name: c, script: rsf}}}}, {THEN_ELSE}}}}}")
    assert choice.ticks(5) == "rrrrs"
    assert started(choice) == "ca"


@shows("reactive-if-every-tick", "reactive-if-changes")
def test_reactive_if_changes_its_branch(workspace: Workspace) -> None:
    choice = run(workspace, f"{{reactive_if: {{condition: {EARLY}, {THEN_ELSE}}}}}")
    assert choice.ticks(3) == "rrr"
    assert choice.log == [("start", "a"), ("INVALID", "a"), ("start", "b")]


@shows("if-no-else")
def test_without_else_they_fail(workspace: Workspace) -> None:
    assert run(workspace, "{if: {condition: 2 < 1, then: act}}").ticks(1) == "f"
    assert run(workspace, f"{{reactive_if: {{condition: {EARLY}, then: act}}}}").ticks(3) == "rrf"


@shows("if-condition-runs")
@pytest.mark.parametrize("kind", ["if", "reactive_if"])
def test_neither_branch_runs_while_the_condition_runs(workspace: Workspace, kind: str) -> None:
    asking = run(workspace, f"{{{kind}: {{condition: {{act: {{name: c, script: rs}}}}, {THEN_ELSE}}}}}")
    assert asking.ticks(1) == "r"
    assert started(asking) == "c"


@shows("if-condition-runs")
def test_a_condition_that_runs_again_halts_the_branch(workspace: Workspace) -> None:
    choice = run(workspace, f"{{reactive_if: {{condition: {{act: {{name: c, script: srf}}}}, {THEN_ELSE}}}}}")
    choice.tick()
    choice.log.clear()
    assert choice.ticks(1) == "r"
    assert choice.log == [("start", "c"), ("INVALID", "a")]


CASES = "cases: {'true': {act: {name: a, script: rrrs}}, 'false': {act: {name: b}}}"


@shows("switch-chooses-once")
def test_switch_computes_once(workspace: Workspace) -> None:
    switch = run(workspace, f"{{switch: {{value: {EARLY}, {CASES}}}}}")
    assert switch.ticks(4) == "rrrs"
    assert started(switch) == "a"


@shows("reactive-switch-every-tick")
def test_reactive_switch_changes_its_case(workspace: Workspace) -> None:
    switch = run(workspace, f"{{reactive_switch: {{value: {EARLY}, {CASES}}}}}")
    assert switch.ticks(3) == "rrr"
    assert switch.log == [("start", "a"), ("INVALID", "a"), ("start", "b")]


@shows("switch-default")
@pytest.mark.parametrize("kind", ["switch", "reactive_switch"])
def test_a_value_without_a_case_takes_default_or_fails(workspace: Workspace, kind: str) -> None:
    value = "value: state.gait, cases: {step: success}"
    assert run(workspace, f"{{{kind}: {{{value}, default: running}}}}").ticks(1) == "r"
    assert run(workspace, f"{{{kind}: {{{value}}}}}").ticks(1) == "f"


@shows("switch-unseen")
def test_a_value_of_what_was_never_seen_fails_and_halts(workspace: Workspace) -> None:
    never = Run(load(workspace, f"subtree: true\nroot: {{switch: {{value: distance(target) < 1, {CASES}}}}}\n"))
    assert never.ticks(1) == "f"
    value = "state.time < 0.05 or distance(target) < 1"
    switch = Run(load(workspace, f"subtree: true\nroot: {{reactive_switch: {{value: {value}, {CASES}}}}}\n"))
    assert switch.ticks(2) == "rf"
    assert switch.log[-1] == ("INVALID", "a")
    switch.tick(seen(0.2, distance=2))
    assert switch.log[-1] == ("start", "b")
