"""The built-in node types, in one place: for the registry, and for trees made in Python.

In Python (see :func:`~humanoid_bt.tree.source.compose.make_tree`) composites take a name and their children, decorators
a name and their child, leaves a name; parameters and branches are keyword arguments with the names that they have in
files (``else_`` for ``else``).
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from humanoid_bt.tree.node_type import Kind
from humanoid_bt.tree.nodes.actions import Failure, Log, RaiseEmergencyStop, Running, Success, Wait, WaitUntil
from humanoid_bt.tree.nodes.blackboard import ClearBlackboard, SetBlackboard
from humanoid_bt.tree.nodes.branching import If, ReactiveIf, ReactiveSwitch, Switch
from humanoid_bt.tree.nodes.composites import ReactiveSelector, ReactiveSequence, Selector, Sequence
from humanoid_bt.tree.nodes.conditions import Condition, Confident, Within
from humanoid_bt.tree.nodes.decorators import Inverter, Repeat, Retry, Timeout
from humanoid_bt.tree.nodes.guards import EmergencyStop, Watchdog
from humanoid_bt.tree.nodes.loops import ForEach, KeepRunningUntilFailure
from humanoid_bt.tree.nodes.on_error import OnError
from humanoid_bt.tree.nodes.parallel import Parallel
from humanoid_bt.tree.nodes.preconditions import Guard, Precondition, While
from humanoid_bt.tree.nodes.ros import RosAction, RosService
from humanoid_bt.tree.nodes.statuses import (
    FailureIsRunning,
    ForceFailure,
    ForceSuccess,
    Once,
    RunningIsFailure,
    RunningIsSuccess,
    StatusToBlackboard,
    SuccessIsRunning,
)
from humanoid_bt.tree.nodes.subtree import SubTree
from humanoid_bt.tree.nodes.timing import Cooldown, Delay, MinDuration

BUILTIN: dict[Kind, tuple[type[Behaviour], ...]] = {
    "composite": (
        *(Sequence, Selector, ReactiveSequence, ReactiveSelector),
        Parallel,
        *(If, Switch, ReactiveIf, ReactiveSwitch),
    ),
    "decorator": (
        *(EmergencyStop, Watchdog),
        *(Inverter, ForceSuccess, ForceFailure),
        *(Retry, Repeat, ForEach, While, KeepRunningUntilFailure),
        *(Timeout, Delay, Cooldown, MinDuration),
        *(Precondition, Guard, Once, OnError, StatusToBlackboard),
        *(RunningIsFailure, RunningIsSuccess, FailureIsRunning, SuccessIsRunning),
    ),
    "subtree": (SubTree,),
    "condition": (Condition, Confident, Within),
    "action": (
        *(Success, Failure, Running),
        *(Wait, WaitUntil, Log),
        *(SetBlackboard, ClearBlackboard),
        *(RosService, RosAction),
        RaiseEmergencyStop,
    ),
}
"""The built-in node types, in the order of the reference."""

__all__ = [
    "BUILTIN",
    "ClearBlackboard",
    "Condition",
    "Confident",
    "Cooldown",
    "Delay",
    "EmergencyStop",
    "Failure",
    "FailureIsRunning",
    "ForEach",
    "ForceFailure",
    "ForceSuccess",
    "Guard",
    "If",
    "Inverter",
    "KeepRunningUntilFailure",
    "Log",
    "MinDuration",
    "OnError",
    "Once",
    "Parallel",
    "Precondition",
    "RaiseEmergencyStop",
    "ReactiveIf",
    "ReactiveSelector",
    "ReactiveSequence",
    "ReactiveSwitch",
    "Repeat",
    "Retry",
    "RosAction",
    "RosService",
    "Running",
    "RunningIsFailure",
    "RunningIsSuccess",
    "Selector",
    "Sequence",
    "SetBlackboard",
    "StatusToBlackboard",
    "SubTree",
    "Success",
    "SuccessIsRunning",
    "Switch",
    "Timeout",
    "Wait",
    "WaitUntil",
    "Watchdog",
    "While",
    "Within",
]
