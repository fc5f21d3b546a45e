"""Leaves that write the blackboard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.params import param
from humanoid_bt.core.units import readable
from humanoid_bt.decision.assign import keys_read
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.linking import Unseen
from humanoid_bt.tree.nodes.leaf import Leaf
from humanoid_bt.tree.results import AT_ONCE, SUCCEEDS, Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, SUCCESS


class SetBlackboard(Leaf):
    """Give a key of the blackboard a value, or the value of an expression.

    Succeeds; fails, and leaves the key as it was, if the expression asks for a percept that was never seen.
    """

    key: Key = param(doc="The key.")
    value: Any = param(None, doc="Its new value, as it is written.")
    expression: Expression | None = param(None, doc="Or what its new value is computed from.")

    def __init__(self, name: str, **values: Any) -> None:
        super().__init__(name, **values)
        self.check_values()

    def check_values(self) -> None:
        """Refuse neither or both of what may be written."""
        if (self.value is None and "value" not in keys_read(self)) == (self.expression is None):
            raise ValueError("it needs either 'value' or 'expression'")

    @classmethod
    def possible_results(cls, values: Mapping[str, Any], _below: Below) -> Results:
        """Return SUCCESS, and FAILURE if it asks something of a percept."""
        expression = values["expression"]
        return AT_ONCE if isinstance(expression, Expression) and expression.percepts else SUCCEEDS

    def update(self) -> Status:
        """Set the key."""
        try:
            value = self.value if self.expression is None else self.expression.evaluate(self.robot)
        except Unseen as unseen:
            self.feedback_message = str(unseen)
            return FAILURE
        self.key.set(value)
        self.feedback_message = f"{self.key.name} = {readable(value, self._unit)}"
        return SUCCESS

    @property
    def _unit(self) -> str:
        """The SI unit of a number that the key gets: as declared, else as computed."""
        if self.key.spec is not None:
            return self.key.spec.unit
        return self.expression.type.unit if self.expression is not None else ""


class ClearBlackboard(Leaf):
    """Take the value of a key of the blackboard away."""

    main = "key"

    key: Key = param(doc="The key.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return SUCCESS."""
        return SUCCEEDS

    def update(self) -> Status:
        """Clear the key."""
        self.key.clear()
        return SUCCESS
