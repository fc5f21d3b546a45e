"""Skills that override what makes them a node, and leave out to call it."""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import Problem
from humanoid_bt.decision.skill import Skill
from humanoid_bt.files.class_files import method_place

_MADE = "leave __init__ alone: parameters are assigned for you; what each start needs belongs into initialise()"
_SET_UP = "def setup(self, **kwargs), and super().setup(**kwargs) before all else in it"


def not_made(node: Behaviour) -> Problem | None:
    """Return what is wrong with the constructor of a node that has just been made, None if nothing."""
    made = "_results" if isinstance(node, Skill) else "children"
    return None if made in vars(node) else _problem(node, "__init__", "", _MADE)


def not_set_up(node: Behaviour) -> Problem | None:
    """Return what is wrong with the ``setup`` of a node that has just been set up, None if nothing."""
    lacks = isinstance(node, Skill) and "robot" not in vars(node)
    return _problem(node, "setup", "**kwargs", _SET_UP) if lacks else None


def _problem(node: Behaviour, method: str, arguments: str, hint: str) -> Problem:
    cls = next(cls for cls in type(node).__mro__ if method in vars(cls))
    message = f"{cls.__name__}.{method} does not call super().{method}({arguments})"
    return Problem(message, method_place(cls, method), hint, "broken-skill")
