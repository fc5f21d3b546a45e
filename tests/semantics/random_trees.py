"""Random trees and what happens to them, for hypothesis; what it prints when it finds something is a file to try."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import yaml
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from tests.semantics.model import BOARD, COMMANDS, Comparison, Node, Snapshot

SKILLS = '''
from humanoid_bt.core.params import param
from humanoid_bt.decision.skill import Skill, Status

LOG = []
"""What skills were told, in order: (event, node name)."""

LETTERS = {"r": Status.RUNNING, "s": Status.SUCCESS, "f": Status.FAILURE}


class Act(Skill):
    """Command all it may and do what its script says, one letter per tick, over and over; x raises."""

    script: str = param(doc="r(unning), s(uccess), f(ailure), x (raise).")
    raises: str = param("", doc="Where else it raises: start, end, halt.")
    ticks = 0

    def initialise(self):
        self.note("start", "start")

    def update(self):
        LOG.append(("tick", self.name))
        if "gaze" in self.resources:
            self.robot.look_at([1, 0, 1])
        if "base" in self.resources:
            self.robot.walk_to([1, 0], 0)
        if "left_hand" in self.resources:
            self.robot.move_hand("left", [1, 0, 1])
        letter = self.script[self.ticks % len(self.script)]
        self.ticks += 1
        if letter == "x":
            raise RuntimeError("out of order")
        return LETTERS[letter]

    def terminate(self, new_status):
        self.note(new_status.name, "halt" if new_status is Status.INVALID else "end")

    def note(self, event, where):
        LOG.append((event, self.name))
        if self.raises == where:
            raise RuntimeError("cannot " + where)


class Hand(Act):
    """Command a hand."""

    resources = ("left_hand",)


class Look(Act):
    """Command the gaze."""

    resources = ("gaze",)


class Walk(Act):
    """Command the base and the gaze."""

    resources = ("base", "gaze")
'''
"""The skills of random trees; :data:`~tests.semantics.model.COMMANDS` says what they command."""

_ORDERED = ("sequence", "selector", "reactive_sequence", "reactive_selector")
_CONDITIONAL = ("guard", "while", "precondition")
_DECORATORS = {
    "plain": ("inverter", "force_success", "force_failure", "running_is_failure", "running_is_success"),
    "again": ("failure_is_running", "success_is_running", "keep_running_until_failure"),
    "timed": ("timeout", "delay", "cooldown", "min_duration"),
    "safe": ("watchdog", "emergency_stop"),
    "kept": ("once", "status_to_blackboard"),
    "count": ("retry", "repeat", "for_each"),
}

MS = st.sampled_from([20, 40, 60, 100, 140])
"""Durations [ms]: multiples of the decision period."""


@dataclass(frozen=True)
class Moment:
    """What happens between one tick and the next, and what the next one sees.

    Attributes:
        pause: time since the tick before [ms].
        age: how old the percept is that arrives [ms]; None if none does.
        mode: what the supervisor allows.
        halt: whether the tree is halted before the tick.
    """

    pause: int = 20
    age: int | None = None
    mode: str = "RUN"
    halt: bool = False

    def __str__(self) -> str:
        percept = "" if self.age is None else f", a percept of {self.age} ms"
        mode = "" if self.mode == "RUN" else f", {self.mode}"
        return f"{'halt, ' * self.halt}tick after {self.pause} ms{percept}{mode}"


@dataclass(frozen=True)
class Story:
    """A tree and all that happens to it.

    Attributes:
        tree: the tree.
        moments: what happens, tick by tick.
        culprit: the node that was made to raise, if one was.
    """

    tree: Node
    moments: tuple[Moment, ...]
    culprit: str = ""

    def __repr__(self) -> str:
        ticks = "\n".join(f"#   {moment}" for moment in self.moments)
        return f"\n{text_of(self.tree)}# then:\n{ticks}\n"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """Let hypothesis print the same."""
        printer.text(repr(self))


def snapshots(moments: tuple[Moment, ...]) -> list[Snapshot]:
    """Return what each tick sees."""
    time, found = 0, []
    for moment in moments:
        time += moment.pause
        stamp = None if moment.age is None else time - moment.age
        found.append(Snapshot(time, stamp, moment.mode))
    return found


def text_of(tree: Node) -> str:
    """Return a tree as a tree file."""
    body = yaml.safe_dump({"root": item_of(tree)}, sort_keys=False, width=100, default_flow_style=None)
    return f"format: 1\nblackboard: {yaml.safe_dump(BOARD, default_flow_style=True)}{body}"


def item_of(node: Node) -> dict[str, Any]:
    """Return a node as it stands in a tree file."""
    if node.kind in ("ros_service", "ros_action"):
        return {node.kind: _call(node)}
    body: dict[str, Any] = {"name": node.name}
    for name, value in node.values.items():
        if name in ("duration", "max_age"):
            body[name] = f"{value} ms"
        elif isinstance(value, Comparison):
            left, right = (
                ("state.time", f"{value.right} ms") if value.left == "time" else (value.left, repr(value.right))
            )
            body[name] = f"{left} {value.sign} {right}"
        elif name == "add":
            body["expression"] = f"n + {value}"
        else:
            body[name] = value
    if node.kind in ("set_blackboard", "clear_blackboard"):
        body["key"] = "n"
    below = {slot: item_of(branch) for slot, branch in node.branches.items()}
    if node.kind in ("switch", "reactive_switch"):
        body["cases"] = {case: item for case, item in below.items() if case != "default"}
        below = {"default": below["default"]} if "default" in below else {}
    body.update(below)
    if node.kind in (*_ORDERED, "parallel"):
        body["children"] = [item_of(child) for child in node.children]
    elif node.children:
        body.update(item_of(node.child))
    return {node.kind: body}


def _call(node: Node) -> dict[str, Any]:
    """Return the body of a node that asks; what it asks says how it is answered."""
    service, values = node.kind == "ros_service", node.values
    what = "service" if service else "action"
    name = f"/{values['answer'].lower()}_{values['after']}"
    called = {"name": node.name, what: name, "type": "some_interfaces/Some", "timeout": f"{values['duration']} ms"}
    return {**called, "response" if service else "result": {"some.number": "n"}}


def numbered(tree: Node) -> Node:
    """Return a tree with a name for every node, in the order of the file."""
    count = 0

    def name(node: Node) -> Node:
        nonlocal count
        count += 1
        named = f"{node.kind}{count}"
        branches = {slot: name(branch) for slot, branch in node.branches.items()}
        return replace(node, name=named, branches=branches, children=tuple(name(child) for child in node.children))

    return name(tree)


def changed(tree: Node, name: str, **values: Any) -> Node:
    """Return a tree with other values in one node."""
    branches = {slot: changed(branch, name, **values) for slot, branch in tree.branches.items()}
    children = tuple(changed(child, name, **values) for child in tree.children)
    own = {**tree.values, **values} if tree.name == name else tree.values
    return replace(tree, values=own, branches=branches, children=children)


def moments(least: int = 1) -> SearchStrategy[tuple[Moment, ...]]:
    """Return what may happen to a tree, in ``least`` ticks or more."""
    moment = st.builds(
        Moment,
        pause=st.sampled_from([20, 20, 40, 100]),
        age=st.sampled_from([0, None, 20, 60]),
        mode=st.sampled_from(["RUN"] * 12 + ["PROTECTIVE_STOP", "EMERGENCY_STOP", "DAMP"]),
        halt=st.sampled_from([False] * 12 + [True]),
    )
    several = st.integers(least, 24).flatmap(lambda count: st.lists(moment, min_size=count, max_size=count))
    return several.map(tuple)


def trees(caught: bool = True, overlaps: bool = False, raising: bool = False) -> SearchStrategy[Node]:
    """Return random trees.

    Args:
        caught: whether there are ``on_error`` nodes.
        overlaps: whether children of a ``parallel`` may command one resource, which no tree may.
        raising: whether nodes raise where no ``on_error`` stands above them.
    """
    free = frozenset({"left_hand", "gaze", "base"})
    return _stoppable(_Rules(caught, overlaps, raising), free).map(numbered)


@st.composite
def stories(draw: DrawFn, raising: bool = False) -> Story:
    """Return random trees with random lives."""
    return Story(draw(trees(raising=raising)), draw(moments()))


@st.composite
def long_stories(draw: DrawFn) -> Story:
    """Return long lives of all decorators that remember something, side by side and started again and again."""
    act = _skill(_Rules(False, False, False), frozenset())
    decorated = [_decorator(group, act, kind) for group in ("timed", "kept", "count") for kind in _DECORATORS[group]]
    children = tuple(
        Node("success_is_running", children=(Node("failure_is_running", children=(draw(child),)),))
        for child in decorated
    )
    side_by_side = Node("parallel", values={"success": "all", "failure": "all"}, children=children)
    tree = Node("emergency_stop", children=(side_by_side,))
    return Story(numbered(tree), draw(moments(least=16)))


@dataclass(frozen=True)
class _Rules:
    caught: bool
    overlaps: bool
    raising: bool


@st.composite
def _stoppable(draw: DrawFn, rules: _Rules, free: frozenset[str]) -> Node:
    """A tree that may command the robot."""
    child = draw(_node(rules, free, 5))
    return Node("emergency_stop", children=(child,))


@st.composite
def _node(draw: DrawFn, rules: _Rules, free: frozenset[str], depth: int) -> Node:
    """A node; those below it command what is ``free``."""
    groups = ["skill", "leaf"] if depth < 4 else []
    if depth:
        groups += ["ordered", "ordered", "ordered", "parallel", "parallel", "choice", "choice", "conditional"]
        groups += ["conditional", "plain", "again", "timed", "timed", "safe", "safe", "kept", "count"]
        groups += ["on_error"] if rules.caught else []
    group = draw(st.sampled_from(groups))
    below = _node(rules, free, depth - 1)
    made: dict[str, SearchStrategy[Node]] = {
        "skill": _skill(rules, free),
        "leaf": _leaf(rules),
        "ordered": _ordered(below),
        "parallel": _parallel(rules, free, depth),
        "choice": _choice(below),
        "conditional": _conditional(below),
        "on_error": st.builds(_on_error, _node(replace(rules, raising=True), free, depth - 1)),
    }
    return draw(made[group] if group in made else _decorator(group, below))


def _on_error(child: Node) -> Node:
    return Node("on_error", children=(child,))


@st.composite
def _ordered(draw: DrawFn, below: SearchStrategy[Node]) -> Node:
    kind = draw(st.sampled_from(_ORDERED))
    return Node(kind, children=tuple(draw(st.lists(below, min_size=1, max_size=3))))


@st.composite
def _conditional(draw: DrawFn, below: SearchStrategy[Node]) -> Node:
    asked, child = draw(st.one_of(_condition(), below)), draw(below)
    if child.kind == "condition":  # in a file there is no room for it beside the key of the slot
        child = replace(child, kind="wait_until")
    return Node(draw(st.sampled_from(_CONDITIONAL)), branches={"condition": asked}, children=(child,))


@st.composite
def _decorator(draw: DrawFn, group: str, below: SearchStrategy[Node], kind: str = "") -> Node:
    values: dict[str, Any] = {}
    branches: dict[str, Node] = {}
    kind = kind or draw(st.sampled_from(_DECORATORS[group]))
    if group == "timed":
        values["duration"] = draw(MS)
    elif kind == "watchdog":
        values = {"percept": "target", "max_age": draw(MS)}
        branches = {"on_stale": draw(below)} if draw(st.booleans()) else {}
    elif kind == "once":
        values["policy"] = draw(st.sampled_from(["completion", "success"]))
    elif kind == "status_to_blackboard":
        values["key"] = "s"
    elif kind == "for_each":
        values = {"item": "n", "items": draw(st.lists(st.integers(0, 3), max_size=3))}
    elif group == "count":
        values["attempts" if kind == "retry" else "times"] = draw(st.sampled_from([1, 2, 3, -1]))
    return Node(kind, values=values, branches=branches, children=(draw(below),))


@st.composite
def _skill(draw: DrawFn, rules: _Rules, free: frozenset[str]) -> Node:
    kind = draw(st.sampled_from([kind for kind, resources in COMMANDS.items() if free.issuperset(resources)]))
    letters = "rrrssffx" if rules.raising else "rsf"
    values = {"script": draw(st.text(st.sampled_from(letters), min_size=1, max_size=6))}
    if rules.raising and (raises := draw(st.sampled_from([""] * 8 + ["start", "end", "halt"]))):
        values["raises"] = raises
    return Node(kind, values=values)


@st.composite
def _leaf(draw: DrawFn, rules: _Rules) -> Node:
    kinds = ["success", "failure", "running", "wait", "wait_until", "condition", "set_blackboard", "log"]
    kinds += ["ros_service", "ros_action"]
    kind = draw(st.sampled_from(kinds + ["clear_blackboard"] * rules.raising))
    if kind == "wait":
        return Node(kind, values={"duration": draw(MS)})
    if kind in ("wait_until", "condition"):
        return replace(draw(_condition()), kind=kind)
    if kind in ("ros_service", "ros_action"):
        answer, after = draw(st.sampled_from(["SUCCESS", "FAILURE"])), draw(st.sampled_from([0, 20, 60, 100]))
        return Node(kind, values={"answer": answer, "after": after, "duration": draw(MS)})
    if kind == "set_blackboard":
        # a key that was cleared cannot be counted up: that raises
        return Node(kind, values=draw(st.sampled_from([{"value": 0}, {"value": 2}, {"add": 1}])))
    return Node(kind, values={"text": "here"} if kind == "log" else {})


@st.composite
def _condition(draw: DrawFn) -> Node:
    left = draw(st.sampled_from(["n", "s", "time"]))
    if left == "time":
        asked = Comparison(left, draw(st.sampled_from(["<", ">="])), draw(st.sampled_from([40, 100, 200])))
    elif left == "n":
        asked = Comparison(left, draw(st.sampled_from(["<", "==", "!=", ">="])), draw(st.integers(0, 3)))
    else:
        states = st.sampled_from(["running", "success", "failure", "invalid"])
        asked = Comparison(left, draw(st.sampled_from(["==", "!="])), draw(states))
    return Node("condition", values={"expression": asked})


@st.composite
def _parallel(draw: DrawFn, rules: _Rules, free: frozenset[str], depth: int) -> Node:
    children = []
    count = draw(st.integers(1, 3))
    left = free
    for _ in range(count):
        own = left if rules.overlaps else frozenset(name for name in sorted(left) if draw(st.booleans()))
        children.append(draw(_node(rules, own, depth - 1)))
        left = left if rules.overlaps else left - own
    threshold = st.sampled_from(["all", "one", *range(1, count + 1)])
    return Node("parallel", values={"success": draw(threshold), "failure": draw(threshold)}, children=tuple(children))


@st.composite
def _choice(draw: DrawFn, below: SearchStrategy[Node]) -> Node:
    reactive = draw(st.sampled_from(["", "reactive_"]))
    if draw(st.booleans()):
        branches = {"condition": draw(st.one_of(_condition(), below)), "then": draw(below)}
        if draw(st.booleans()):
            branches["else"] = draw(below)
        return Node(f"{reactive}if", branches=branches)
    key = draw(st.sampled_from(["n", "s"]))
    cases = ["0", "1", "2"] if key == "n" else ["running", "success", "failure"]
    chosen = draw(st.lists(st.sampled_from(cases), min_size=1, max_size=2, unique=True))
    branches = {case: draw(below) for case in chosen}
    if draw(st.booleans()):
        branches["default"] = draw(below)
    return Node(f"{reactive}switch", values={"value": key}, branches=branches)
