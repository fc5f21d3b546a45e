"""What docs/semantics.md says of py_trees, shown on the installed one, beside what this engine does."""

from __future__ import annotations

import inspect
import operator
import time
from collections.abc import Iterator

import py_trees
import pytest
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard, Client
from py_trees.common import Access, ComparisonExpression, OneShotPolicy, ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import EternalGuard, Inverter, OneShot, Repeat, Retry, Timeout

from humanoid_bt.files.workspace import Workspace
from tests.semantics.claims import shows
from tests.tree.helpers import run

STATUSES = {"r": Status.RUNNING, "s": Status.SUCCESS, "f": Status.FAILURE}


class Act(Behaviour):
    """Do what its script says, as the skill of this name in ``tests.tree.helpers``, and note what it is told."""

    def __init__(self, name: str, script: str, log: list[str]) -> None:
        super().__init__(name)
        self.script, self.log, self.ticks = script, log, 0

    def initialise(self) -> None:
        self.log.append(f"{self.name} starts")

    def update(self) -> Status:
        letter = self.script[min(self.ticks, len(self.script) - 1)]
        self.ticks += 1
        self.log.append(f"{self.name} acts")
        if letter == "x":
            raise RuntimeError("out of order")
        return STATUSES.get(letter, letter)  # type: ignore[arg-type]  # what is no status goes through

    def terminate(self, new_status: Status) -> None:
        self.log.append(f"{self.name} {new_status.name}")


@pytest.fixture
def log() -> list[str]:
    return []


@pytest.fixture
def keys() -> Iterator[Client]:
    """The blackboard of py_trees, empty before and after."""
    Blackboard.clear()
    client = Client(name="test")
    for key in ("k", "other"):
        client.register_key(key, access=Access.WRITE)
    yield client
    Blackboard.clear()
    Blackboard.clients.clear()
    Blackboard.metadata.clear()


def letters(root: Behaviour, ticks: int) -> str:
    """Tick often; return the statuses as letters."""
    found = ""
    for _ in range(ticks):
        root.tick_once()
        found += root.status.name[0].lower()
    return found


@shows("differs-memory")
@pytest.mark.parametrize("composite", [Sequence, Selector])
def test_memory_must_be_chosen(composite: type) -> None:
    assert inspect.signature(composite).parameters["memory"].default is inspect.Parameter.empty


@shows("differs-preemption")
def test_the_new_node_acts_before_the_old_one_is_halted(log: list[str]) -> None:
    selector = Selector("selector", False, [Act("high", "fr", log), Act("low", "r", log)])
    assert letters(selector, 1) == "r"
    log.clear()
    selector.tick_once()
    assert log == ["high starts", "high acts", "low INVALID"]


@shows("differs-halt-order")
def test_decorators_are_told_first(log: list[str]) -> None:
    class Told(Inverter):
        def terminate(self, new_status: Status) -> None:
            log.append(f"{self.name} {new_status.name}")

    inverter = Told("inverter", Act("child", "r", log))
    inverter.tick_once()
    inverter.stop(Status.INVALID)
    assert log[2:] == ["inverter INVALID", "child INVALID"]


@shows("differs-never-ran")
def test_a_decorator_tells_a_child_that_never_ran(log: list[str]) -> None:
    Inverter("inverter", Act("child", "r", log)).stop(Status.INVALID)
    assert log == ["child INVALID"]


@shows("differs-ended")
def test_children_that_had_ended_are_told_again(log: list[str]) -> None:
    sequence = Sequence("sequence", True, [Act("a", "s", log), Act("b", "f", log)])
    sequence.tick_once()
    log.clear()
    sequence.tick_once()
    assert log[:2] == ["a INVALID", "b INVALID"]


@shows("differs-exception")
def test_siblings_of_an_exception_go_on(log: list[str]) -> None:
    sibling = Act("sibling", "r", log)
    policy = ParallelPolicy.SuccessOnAll(synchronise=False)
    parallel = Parallel("parallel", policy, [sibling, Act("bad", "rxr", log)])
    parallel.tick_once()
    with pytest.raises(RuntimeError):
        parallel.tick_once()
    assert sibling.status is Status.RUNNING
    assert letters(parallel, 1) == "r"
    assert "sibling INVALID" not in log


@shows("differs-invalid")
def test_another_return_value_becomes_invalid(log: list[str]) -> None:
    selector = Selector("selector", False, [Act("bad", "n", log), Act("next", "s", log)])
    assert letters(selector, 1) == "s"
    assert selector.children[0].status is Status.INVALID
    assert "next acts" in log


@shows("differs-clock", "differs-deadline")
def test_timeout_reads_the_wall_clock_and_lets_a_late_success_count(
    log: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    late = Timeout("timeout", Act("a", "rs", log), duration=1.0)
    assert letters(late, 1) == "r"
    now[0] = 5.0
    assert letters(late, 1) == "s"
    slow = Timeout("timeout", Act("a", "r", log), duration=1.0)
    assert letters(slow, 1) == "r"
    now[0] = 10.0
    assert letters(slow, 1) == "f"


@shows("differs-retry")
def test_one_attempt_per_tick(log: list[str]) -> None:
    assert letters(Retry("retry", Act("a", "f", log), 3), 3) == "rrf"
    assert log.count("a acts") == 3


@shows("differs-parallel")
def test_all_children_of_a_parallel_are_ticked(log: list[str]) -> None:
    policy = ParallelPolicy.SuccessOnAll(synchronise=False)
    assert letters(Parallel("parallel", policy, [Act("a", "f", log), Act("b", "r", log)]), 1) == "f"
    assert "b acts" in log


@shows("differs-synchronise")
@pytest.mark.parametrize(("synchronise", "acted"), [(False, 2), (True, 1)])
def test_children_that_ended_are_ticked_again(log: list[str], synchronise: bool, acted: int) -> None:
    policy = ParallelPolicy.SuccessOnAll(synchronise=synchronise)
    letters(Parallel("parallel", policy, [Act("a", "s", log), Act("b", "r", log)]), 2)
    assert log.count("a acts") == acted


@shows("differs-snapshot")
def test_a_variable_may_change_within_a_tick(keys: Client) -> None:
    keys.k = 1

    def check(name: str) -> Behaviour:
        return py_trees.behaviours.CheckBlackboardVariableValue(name, ComparisonExpression("k", 1, operator.eq))

    change = py_trees.behaviours.SetBlackboardVariable("change", "k", 2, overwrite=True)
    sequence = Sequence("sequence", False, [check("before"), change, check("after")])
    sequence.tick_once()
    assert [child.status.name for child in sequence.children] == ["SUCCESS", "SUCCESS", "FAILURE"]


@shows("differs-if")
def test_either_or_keeps_to_its_first_choice(keys: Client, log: list[str]) -> None:
    keys.k = 1
    conditions = [ComparisonExpression("k", value, operator.eq) for value in (1, 2)]
    choice = py_trees.idioms.either_or(conditions, [Act("one", "r", log), Act("two", "r", log)])
    assert letters(choice, 1) == "r"
    keys.k = 2
    assert letters(choice, 1) == "r"
    assert log == ["one starts", "one acts", "one acts"]


@shows("differs-guard")
def test_a_guard_in_doubt_lets_its_child_run(log: list[str]) -> None:
    assert letters(EternalGuard("guard", Act("a", "r", log), condition=lambda: Status.RUNNING), 1) == "r"
    assert "a acts" in log


@shows("differs-blackboard", "differs-keys-anew")
def test_the_blackboard_is_global_and_stays(keys: Client) -> None:
    write = py_trees.behaviours.SetBlackboardVariable("write", "k", 7, overwrite=True)
    read = py_trees.behaviours.CheckBlackboardVariableValue("read", ComparisonExpression("k", 7, operator.eq))
    first, second = Sequence("first", False, [write]), Sequence("second", False, [read])
    assert letters(first, 1) + letters(second, 1) == "ss"
    first.stop(Status.INVALID)
    second.stop(Status.INVALID)
    assert letters(second, 1) == "s"


@shows("differs-once")
def test_one_shot_gives_its_result_from_then_on(log: list[str]) -> None:
    once = OneShot("once", Act("a", "rf", log), OneShotPolicy.ON_COMPLETION)
    assert letters(once, 4) == "rfff"
    assert log.count("a acts") == 2


@shows("differs-keep-running")
def test_repeat_for_ever_ends_with_failure(log: list[str]) -> None:
    assert letters(Repeat("repeat", Act("a", "ssf", log), -1), 3) == "rrf"
    assert not hasattr(py_trees.decorators, "KeepRunningUntilFailure")


@shows("differs-exception", "differs-invalid", "differs-deadline", "differs-guard", "differs-snapshot")
@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        ("{on_error: {parallel: [act, {act: {name: b, script: x}}]}}", "f"),
        ("{on_error: {selector: [{act: {script: n}}, success]}}", "f"),
        ("{timeout: {duration: 0.1, act: {script: rs}}}", "rf"),
        ("{guard: {condition: {act: }, success: }}", "r"),
        ("{sequence: [{set_blackboard: {key: k, value: 1}}, {condition: k == 1}]}", "s"),
    ],
)
def test_here(workspace: Workspace, root: str, statuses: str) -> None:
    assert run(workspace, root).ticks(len(statuses)) == statuses
