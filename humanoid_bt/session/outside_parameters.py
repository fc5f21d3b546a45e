"""Parameters of the tree as other programs see them, and as they set them while it runs."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.plain import plain
from humanoid_bt.core.texts import shortened
from humanoid_bt.session.debugger import Debugger
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.setting import checked, uses_of
from humanoid_bt.session.tree_runner import TreeRunner
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.tree import Tree

PATIENCE = 0.5
"""How long somebody who sets a parameter waits for the answer [s]."""

_LONGEST = 300  # characters of why one is not set, each up to 12 bytes: a message that is too long would not arrive


class OutsideParameters:
    """Shows the parameters of the tree that runs, and sets those that others want to be set; between two ticks.

    Args:
        engine: joins the run with other programs, if anything does.
        runner: what runs the tree.
        debugger: sets them, and tells of it.
    """

    def __init__(self, engine: Engine, runner: TreeRunner, debugger: Debugger) -> None:
        self._engine, self._runner, self._debugger = engine, runner, debugger
        self._tree: Tree | None = None
        self._known: list[Described] = []  # of that tree
        self._values: list[Any] = []

    def look(self) -> None:
        """Take what others want, and show what there is now."""
        if not self._engine.shows_parameters:
            return
        tree = self._runner.tree
        for wanted in self._engine.take_settings():
            if time.monotonic() - wanted["at"] < PATIENCE:  # else they have been told that nobody answers
                self._set(tree, wanted)
        new = tree is not self._tree
        if new:
            self._tree, self._known = tree, [Described(tree, name) for name in tree.parameters]
        values = [one.value for one in self._known]
        if new or values != self._values:
            self._values = values
            self._engine.show_parameters([{**one.words, "value": plain(one.value)} for one in self._known])

    def _set(self, tree: Tree, wanted: Mapping[str, Any]) -> None:
        why = ""
        try:
            if self._runner.ended is not None:
                raise UserError("no tree runs now: the next one starts with its own")
            self._debugger.assign(tree, wanted["name"], wanted["value"], wanted["source"])
        except UserError as error:
            why = "; ".join(f"{one.message} ({one.hint})" if one.hint else one.message for one in error.problems)
        now = self._engine.clock.now()
        self._engine.announce("setting", {"time": now, "number": wanted["number"], "why": shortened(why, _LONGEST)})


class Described:
    """A parameter of a tree, as others see it.

    Args:
        tree: the tree.
        name: of the parameter.

    Attributes:
        words: name, unit, doc; ``fixed``, why it cannot be set, "" if it can; ``least`` and ``most`` that nodes take.
    """

    def __init__(self, tree: Tree, name: str) -> None:
        declared = (tree.header.get("parameters") or {}).get(name)
        form = declared if isinstance(declared, dict) else {}
        fixed, least, most, unit = "", None, None, form.get("unit", "")
        self._written = tree.parameters[name]
        self._uses: list[tuple[Node, str]] = []
        try:
            self._uses = uses_of(tree, name)
            for node, parameter in self._uses:
                checked(node, parameter, self.value)
                spec = node.type.params[parameter]
                unit = unit or spec.unit
                lower = spec.above if spec.minimum is None else spec.minimum
                least = lower if least is None or (lower is not None and lower > least) else least
                most = spec.maximum if most is None or (spec.maximum is not None and spec.maximum < most) else most
        except UserError as error:
            fixed = error.problems[0].message
        said = {"name": name, "unit": unit, "doc": form.get("doc", ""), "fixed": fixed}
        self.words: dict[str, Any] = {**said, "least": least, "most": most}

    @property
    def value(self) -> Any:
        """The value that the first node has now which is given it, in SI units; the tree's own if none is."""
        for node, parameter in self._uses[:1]:
            return getattr(node.behaviour, parameter, self._written)
        return self._written
