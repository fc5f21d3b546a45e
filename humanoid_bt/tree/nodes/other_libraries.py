"""What nodes and parameters of py_trees and BehaviorTree.CPP, and former ones of this package, are called here."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass

from py_trees.behaviour import Behaviour

from humanoid_bt.core.texts import snake_case
from humanoid_bt.decision.skill import node_type_name

PY_TREES, CPP = "py_trees", "BehaviorTree.CPP"


@dataclass(frozen=True)
class Foreign:
    """Node types of another library, and what is meant by them.

    Attributes:
        library: where they are.
        names: what they are called there.
        here: what does the same here, node types and parameters in backquotes.
    """

    library: str
    names: tuple[str, ...]
    here: str


def _py_trees(names: str, here: str) -> Foreign:
    return Foreign(PY_TREES, tuple(names.split()), here)


def _cpp(names: str, here: str) -> Foreign:
    return Foreign(CPP, tuple(names.split()), here)


FOREIGN = (
    Foreign(f"{PY_TREES} and {CPP}", ("Sequence",), "`sequence`; py_trees' with memory=False is `reactive_sequence`"),
    _py_trees("Selector", "`selector`; with memory=False it is `reactive_selector`"),
    _py_trees("Parallel", "`parallel`; `success: all` is SuccessOnAll, `success: one` is SuccessOnOne"),
    _py_trees("OneShot", "`once`; its `policy` is `completion` or `success`"),
    _py_trees("EternalGuard", "`guard`; a condition that is RUNNING keeps the child from running"),
    _py_trees("FailureIsSuccess", "`force_success`"),
    _py_trees("SuccessIsFailure", "`force_failure`"),
    _py_trees("Condition", "as a decorator, `failure_is_running` waits for a success; `condition` is an expression"),
    _py_trees("Count", "nothing; the recording has every change of every node's status"),
    _py_trees("PassThrough", "nothing; leave it out; a `sequence` with one child gives it a name"),
    _py_trees("ForEach", "`for_each`; the list stands in the tree, as `items`"),
    _py_trees("Timer", "`wait`"),
    _py_trees("TickCounter", "`wait`; time is counted, not ticks"),
    _py_trees("Dummy", "`running`"),
    _py_trees("Periodic StatusQueue SuccessEveryN ProbabilisticBehaviour", "nothing; for a test, write a skill"),
    _py_trees("SetBlackboardVariable", "`set_blackboard`"),
    _py_trees("UnsetBlackboardVariable", "`clear_blackboard`"),
    _py_trees("CheckBlackboardVariableExists", "`condition: is_set(key)`"),
    _py_trees("CheckBlackboardVariableValue CheckBlackboardVariableValues", "`condition: key == 'value'`"),
    _py_trees("CompareBlackboardVariables", "`condition: one == other`"),
    _py_trees("WaitForBlackboardVariable", "`wait_until: is_set(key)`"),
    _py_trees("WaitForBlackboardVariableValue", "`wait_until: key == 'value'`"),
    _py_trees("BlackboardToStatus", "`switch` on the key, with `success`, `failure` and `running` as cases"),
    _py_trees("EitherOr", "`if`, or `switch` for more than two; like it they keep to what they chose"),
    _py_trees("PickUpWhereYouLeftOff", "`sequence` with each child below `once: {policy: success}`"),
    _cpp("AsyncSequence", "`sequence`; the next child starts in the same tick"),
    _cpp("Fallback", "`selector`; `fallback` is another name of it"),
    _cpp("AsyncFallback", "`selector`; the next child starts in the same tick"),
    _cpp("ReactiveSequence", "`reactive_sequence`"),
    _cpp("ReactiveFallback", "`reactive_selector`; `reactive_fallback` is another name of it"),
    _cpp(
        "SequenceWithMemory SequenceStar",
        "`sequence`; after a failure it begins with the first child, unless each is below `once`",
    ),
    _cpp("FallbackStar", "`selector`"),
    _cpp("ParallelAll", "`parallel` with `success: all` and a threshold `failure`; it ends when that is reached"),
    _cpp("IfThenElse", "`if`, keys `condition`, `then`, `else`"),
    _cpp("WhileDoElse", "`reactive_if`, keys `condition`, `then`, `else`"),
    _cpp(
        "Switch2 Switch3 Switch4 Switch5 Switch6",
        "`reactive_switch`, keys `value`, `cases`, `default`; `switch` chooses once",
    ),
    _cpp("TryCatch", "`selector`; `on_error` is for exceptions"),
    _cpp("ManualSelector", "nothing; `switch` on a parameter, which `--set` gives"),
    _cpp("Negate", "`inverter`"),
    _cpp("RetryUntilSuccessful RetryUntilSuccesful", "`retry`; `attempts` is num_attempts; one attempt per tick"),
    _cpp("Repeat", "`repeat`; `times` is num_cycles; one run per tick"),
    _cpp("Timeout", "`timeout`, the `duration` with its unit"),
    _cpp("Delay", "`delay`, the `duration` with its unit"),
    _cpp("RunOnce", "`once`; it gives its result again, where then_skip skips"),
    _cpp("LoopInt LoopDouble LoopBool LoopString Loop ConsumeQueue", "`for_each`, keys `item` and `items`"),
    _cpp(
        "BlackboardCheckInt BlackboardCheckDouble BlackboardCheckString BlackboardCheckBool",
        "`precondition` with `condition: key == 'value'`",
    ),
    _cpp("EntryUpdated SkipUnlessUpdated WaitValueUpdate", "nothing; use `condition` or `wait_until` on the value"),
    _cpp("AlwaysSuccess", "`success`"),
    _cpp("AlwaysFailure", "`failure`"),
    _cpp("Sleep", "`wait`"),
    _cpp("Script", "`set_blackboard` with an `expression`"),
    _cpp("ScriptCondition", "`condition`"),
    _cpp("SetBlackboard", "`set_blackboard`"),
    _cpp("UnsetBlackboard", "`clear_blackboard`"),
    _cpp("SaySomething", "`log`"),
    _cpp("SubTree SubTreePlus", "`subtree`; parameters and outputs are declared in its file"),
)
"""Node types of other libraries, those that are called the same here included where something differs."""


def hint(name: str, types: Container[str]) -> str:
    """Return what an unknown node type is called here, "" if the name is not known either.

    Args:
        name: as it is written, in CamelCase or snake_case.
        types: the node types there are.
    """
    wanted, ours = _letters(name), snake_case(name)
    found = [foreign for foreign in FOREIGN if wanted in map(_letters, foreign.names)]
    if ours in types and not found:
        return f"here it is written {ours!r}"
    return "; ".join(f"{name} ({foreign.library}) is here: {foreign.here.replace('`', '')}" for foreign in found)


_REACTIVE = "reactive_"
_IN_TWO_TYPES = ("sequence", "selector", "if", "switch")
"""Node types that go on with what runs, each with one beside it that asks again in every tick."""


_FORMER = {
    ("emergency_stop", "wait_for_reset"): (
        "leave it out: the node always waits for the reset; whether the run does is its option --on-estop wait|end"
    ),
}


def hint_for_parameter(type_name: str, parameter: str, value: object) -> str:
    """Return what does here what a parameter does in another library or did before, "" if that is nothing known.

    Args:
        type_name: the node type that was given the parameter.
        parameter: its name.
        value: its value; what is not plain is not known yet.
    """
    if parameter == "memory":
        return _hint_for_memory(type_name, value)
    return _FORMER.get((type_name, parameter), "")


def _hint_for_memory(type_name: str, value: object) -> str:
    plain = type_name.removeprefix(_REACTIVE)
    reactive = _REACTIVE + plain
    if plain not in _IN_TWO_TYPES:
        return ""
    if not isinstance(value, bool):
        return f"{plain!r} goes on with what runs, {reactive!r} asks again in every tick"
    wanted, does = (plain, "goes on with what runs") if value else (reactive, "asks again in every tick")
    return f"leave it out: {wanted!r} {does}" if wanted == type_name else f"use {wanted!r}, which {does}"


def refuse_parameters(node: Behaviour, values: Mapping[str, object]) -> None:
    """Answer parameters of another library, and former ones, where a node is made in Python.

    Raises:
        TypeError: one is among the values.
    """
    owner = type(node)
    for name, value in values.items():
        if hint := hint_for_parameter(node_type_name(owner), name, value):
            raise TypeError(f"{owner.__name__} has no parameter {name!r}: {hint}")


def _letters(name: str) -> str:
    return name.replace("_", "").lower()
