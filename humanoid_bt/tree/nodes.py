"""The built-in node types, in one place: for the registry, and for trees made in Python.

In Python (see :func:`~humanoid_bt.tree.compose.make_tree`) composites take a name and their children, decorators a
name and their child, leaves a name; parameters and branches are keyword arguments with the names that they have in
files (``else_`` for ``else``).
"""

from __future__ import annotations

from typing import Literal

from py_trees.behaviour import Behaviour

from humanoid_bt.tree.actions import RaiseEmergencyStop, Wait, WaitUntil
from humanoid_bt.tree.blackboard_nodes import ClearBlackboard, SetBlackboard
from humanoid_bt.tree.branching import If
from humanoid_bt.tree.composites import Selector, Sequence
from humanoid_bt.tree.conditions import Condition, Confident, Within
from humanoid_bt.tree.decorators import Inverter, Repeat, Retry, Timeout
from humanoid_bt.tree.guards import EmergencyStop, Watchdog
from humanoid_bt.tree.loops import ForEach
from humanoid_bt.tree.parallel import Parallel
from humanoid_bt.tree.subtree import SubTree

Kind = Literal["composite", "decorator", "subtree", "condition", "action", "skill"]

BUILTIN: dict[Kind, tuple[type[Behaviour], ...]] = {
    "composite": (Sequence, Selector, Parallel, If),
    "decorator": (Inverter, Retry, Repeat, Timeout, EmergencyStop, Watchdog, ForEach),
    "subtree": (SubTree,),
    "condition": (Condition, Confident, Within),
    "action": (Wait, WaitUntil, SetBlackboard, ClearBlackboard, RaiseEmergencyStop),
}
"""The built-in node types, in the order of the reference."""

__all__ = [
    "BUILTIN",
    "ClearBlackboard",
    "Condition",
    "Confident",
    "EmergencyStop",
    "ForEach",
    "If",
    "Inverter",
    "Kind",
    "Parallel",
    "RaiseEmergencyStop",
    "Repeat",
    "Retry",
    "Selector",
    "Sequence",
    "SetBlackboard",
    "SubTree",
    "Timeout",
    "Wait",
    "WaitUntil",
    "Watchdog",
    "Within",
]
