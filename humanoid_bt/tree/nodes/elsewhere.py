"""What nodes of py_trees and BehaviorTree.CPP are called here."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass

from humanoid_bt.decision.skill import snake_case

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
    Foreign(f"{PY_TREES} and {CPP}", ("Sequence",), "`sequence`; it is reactive unless it has `memory: true`"),
    _py_trees("Selector", "`selector`; it is reactive unless it has `memory: true`"),
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
    _py_trees("EitherOr", "`if`, or `switch` for more than two"),
    _py_trees("PickUpWhereYouLeftOff", "`sequence` with each child below `once: {policy: success}`"),
    _cpp("AsyncSequence", "`sequence` with `memory: true`"),
    _cpp("Fallback AsyncFallback", "`selector` with `memory: true`; `fallback` is another name of it"),
    _cpp("ReactiveSequence", "`sequence`; it is reactive unless it has `memory: true`"),
    _cpp("ReactiveFallback", "`selector`; it is reactive unless it has `memory: true`"),
    _cpp(
        "SequenceWithMemory SequenceStar",
        "`sequence` with `memory: true`; after a failure it begins with the first child, unless each is below `once`",
    ),
    _cpp("FallbackStar", "`selector` with `memory: true`"),
    _cpp("ParallelAll", "`parallel` with `success: all` and a threshold `failure`; it ends when that is reached"),
    _cpp("IfThenElse", "`if` with `memory: true`, keys `condition`, `then`, `else`"),
    _cpp("WhileDoElse", "`if`, keys `condition`, `then`, `else`; the condition is checked in every tick"),
    _cpp("Switch2 Switch3 Switch4 Switch5 Switch6", "`switch`, keys `value`, `cases` and `default`"),
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


def _letters(name: str) -> str:
    return name.replace("_", "").lower()
