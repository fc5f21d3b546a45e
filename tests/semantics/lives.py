"""Random trees on the engine: loaded from text, ticked and halted by hand."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial

from hypothesis import HealthCheck, Phase, settings

from humanoid_bt.core.messages import Command, Mode, Percept, State
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.catching import Catcher
from humanoid_bt.tree.ticking.executor import NodeError
from humanoid_bt.tree.ticking.tick import Raised
from tests.semantics.model import Node, Snapshot
from tests.semantics.random_trees import text_of
from tests.tree.helpers import Run, load, make_state, seen

_MORE = os.environ.get("HUMANOID_BT_EXAMPLES")

settings.register_profile(
    "trees",
    max_examples=int(_MORE or 40),
    derandomize=_MORE is None,
    deadline=None,
    database=None,
    print_blob=False,
    phases=[Phase.generate, Phase.shrink],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)
random_lives = settings(settings.get_profile("trees"))
"""Decorates a property: the same examples in every run, or as many as ``HUMANOID_BT_EXAMPLES`` says, and new ones."""


class Life(Run):
    """One tree in its life; nodes are named, and times are in milliseconds.

    Attributes:
        command: what the last tick commanded; None if it raised, or the tree was halted after it.
        raised: the name of the node that raised in the last tick or halt.
        caught: who caught an exception, and who raised it.
    """

    def __init__(self, tree: Node, workspace: Workspace) -> None:
        super().__init__(load(workspace, text_of(tree)))
        self.nodes = {node.name: node.behaviour for node in self.tree.nodes}
        self.caught: list[tuple[str, str]] = []
        for name, behaviour in self.nodes.items():
            if isinstance(behaviour, Catcher):
                behaviour.on_caught = partial(self._take, name, behaviour.on_caught)
        self.command: Command | None = None
        self.raised: str | None = None

    def step(self, now: Snapshot) -> None:
        """Tick once."""
        self.clock.cycle = now.time
        self.changes.clear()
        self.command = self.raised = None
        try:
            self.command = self.executor.tick(*shown(now))
        except NodeError as error:
            self.raised = _last(error.path)

    def stop(self, time: int) -> None:
        """Halt the tree."""
        self.clock.cycle = time
        self.command = self.raised = None
        try:
            self.halt()
        except NodeError as error:
            self.raised = _last(error.path)

    @property
    def statuses(self) -> dict[str, str]:
        return {name: behaviour.status.name for name, behaviour in self.nodes.items()}

    @property
    def owners(self) -> set[tuple[str, str]]:
        """Who commands each resource: (resource, node)."""
        sources = self.command.sources if self.command else {}
        return {(resource, _last(path)) for resource, path in sources.items()}

    def _take(self, name: str, tell: Callable[[Raised], None], raised: Raised) -> None:
        """Note each exception that a node takes; of those that are alike people are not told every one."""
        self.caught.append((name, raised.node.name))
        tell(raised)

    @property
    def asking(self) -> int:
        """How many calls nobody is done with."""
        return len(self.calls.open)

    @property
    def logged(self) -> list[str]:
        """Which ``log`` nodes told something."""
        return [_last(source) for source, level, _ in self.events if level == "info"]


def shown(now: Snapshot) -> tuple[State, dict[str, Percept]]:
    """Return a snapshot as the engine takes it."""
    percepts = {} if now.stamp is None else seen(now.stamp / 1000)
    return make_state(now.time / 1000, Mode[now.mode]), percepts


def _last(path: str) -> str:
    return path.rpartition("/")[2]
