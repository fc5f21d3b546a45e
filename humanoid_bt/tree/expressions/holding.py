"""Which parameters of nodes hold expressions, and which those are."""

from __future__ import annotations

from typing import Any

from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.fields import Fields
from humanoid_bt.tree.expressions.template import Template


def holds_expressions(kind: Any) -> bool:
    """Return whether values of a type are expressions or hold some: these look up names by themselves."""
    return isinstance(kind, type) and issubclass(kind, (Expression, Template, Fields))


def expressions_of(value: Any) -> list[Expression]:
    """Return the expressions in a parameter's value."""
    if isinstance(value, Expression):
        return [value]
    return value.expressions if isinstance(value, (Template, Fields)) else []
