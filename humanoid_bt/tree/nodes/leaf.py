"""The base of the built-in leaves."""

from __future__ import annotations

from typing import Any

from py_trees.behaviour import Behaviour

from humanoid_bt.core.params import params_of
from humanoid_bt.decision.assign import assign
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions.holding import expressions_of
from humanoid_bt.tree.ticking.tick import INVALID


class Leaf(Behaviour):
    """Base of the built-in leaves: takes its parameters, and the robot.

    Args:
        name: the node's name.
        values: parameter values, already of their declared types.

    Attributes:
        robot: the robot as decision sees it, from ``setup`` on.
    """

    robot: Robot

    def __init__(self, name: str, **values: Any) -> None:
        super().__init__(name)
        assign(self, values)

    def setup(self, **kwargs: Any) -> None:
        """Take ``robot``."""
        self.robot = kwargs["robot"]

    def initialise(self) -> None:
        """Forget what held, in all that it compares, if its branch was left."""
        if self.status is INVALID:
            for name in params_of(type(self)):
                for expression in expressions_of(getattr(self, name)):
                    expression.forget()
