"""Skills that override what makes them a node, and leave out to call it, or cannot be called as it is."""

from __future__ import annotations

import inspect
from collections.abc import Mapping

from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import Problem
from humanoid_bt.core.params import Param
from humanoid_bt.decision.skill import Skill
from humanoid_bt.files.class_files import method_place

_MADE = "leave __init__ alone: parameters are assigned for you; what each start needs belongs into initialise()"
_SET_UP = "def setup(self, **kwargs), and super().setup(**kwargs) before all else in it"


def not_makeable(cls: type[Behaviour], declared: Mapping[str, Param]) -> Problem | None:
    """Return why a class cannot be made as trees do it, by name and with its parameters, None if it can.

    Args:
        cls: of the nodes.
        declared: its parameters; where there are none, the arguments of its constructor are.
    """
    owner, signature = _owner(cls, "__init__"), inspect.signature(cls.__init__)
    bind = signature.bind if declared else signature.bind_partial
    for given in (declared, [name for name, spec in declared.items() if spec.required]):
        try:
            bind(None, name="", **dict.fromkeys(given))
        except TypeError as error:
            message = f"{owner.__name__}.__init__ does not take what trees give it: {error}"
            hint = _MADE if issubclass(cls, Skill) else "def __init__(self, name, ...)"
            return Problem(message, method_place(owner, "__init__"), hint, "broken-skill")
    return None


def not_made(node: Behaviour) -> Problem | None:
    """Return what is wrong with the constructor of a node that has just been made, None if nothing."""
    made = "_results" if isinstance(node, Skill) else "children"
    return None if made in vars(node) else _problem(node, "__init__", "", _MADE)


def not_set_up(node: Behaviour) -> Problem | None:
    """Return what is wrong with the ``setup`` of a node that has just been set up, None if nothing."""
    lacks = isinstance(node, Skill) and "robot" not in vars(node)
    return _problem(node, "setup", "**kwargs", _SET_UP) if lacks else None


def _problem(node: Behaviour, method: str, arguments: str, hint: str) -> Problem:
    cls = _owner(type(node), method)
    message = f"{cls.__name__}.{method} does not call super().{method}({arguments})"
    return Problem(message, method_place(cls, method), hint, "broken-skill")


def _owner(cls: type, method: str) -> type:
    """Return the class whose method it is."""
    return next(base for base in cls.__mro__ if method in vars(base))
