"""What trees mean: a reference model of the engine, as simple as it can be, to compare the engine with.

It shares no code with the engine, and statuses, times (in whole milliseconds) and modes are plain values. Each node
type is one function below, with what it means in a sentence. Not modelled: sub-trees, percepts in conditions,
feedback, and the reasons of halts.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

SUCCESS, FAILURE, RUNNING, INVALID = "SUCCESS", "FAILURE", "RUNNING", "INVALID"

BOARD = {"n": 0, "s": "running"}
"""The keys that trees use, with their initial values."""

COMMANDS = {"act": (), "hand": ("left_hand",), "look": ("gaze",), "walk": ("base", "gaze")}
"""The resources of each skill."""

SIGNS = {"<": operator.lt, "==": operator.eq, "!=": operator.ne, ">=": operator.ge}


@dataclass(frozen=True)
class Node:
    """One node of a tree.

    Attributes:
        kind: its type in tree files.
        name: unique in its tree.
        values: its parameters; durations in milliseconds.
        children: its children.
        branches: other nodes below it, by slot; those of a ``switch`` by case, and ``default``.
    """

    kind: str
    name: str = ""
    values: dict[str, Any] = field(default_factory=dict)
    children: tuple[Node, ...] = ()
    branches: dict[str, Node] = field(default_factory=dict)

    @property
    def child(self) -> Node:
        return self.children[0]

    @property
    def below(self) -> tuple[Node, ...]:
        """The nodes right below it: what it asks first, then what it runs."""
        asked = [node for slot, node in self.branches.items() if slot == "condition"]
        others = [node for slot, node in self.branches.items() if slot != "condition"]
        return (*asked, *self.children, *others)

    def all(self) -> Iterator[Node]:
        """Return this node and all below it, parents first."""
        yield self
        for node in self.below:
            yield from node.all()


@dataclass(frozen=True)
class Comparison:
    """A condition: a key of the blackboard, or the ``time`` [ms], against a value."""

    left: str
    sign: str
    right: Any


@dataclass(frozen=True)
class Snapshot:
    """What a tick sees.

    Attributes:
        time: [ms].
        stamp: when the percept was seen [ms]; None if nothing new was.
        mode: what the supervisor allows: RUN, PROTECTIVE_STOP, EMERGENCY_STOP or DAMP.
    """

    time: int
    stamp: int | None = None
    mode: str = "RUN"


class Broken(Exception):  # noqa: N818 (it is a verdict, no error)
    """A node raised an exception."""

    def __init__(self, node: Node) -> None:
        super().__init__(node.name)
        self.node = node


class Model:
    """One tree and all that it remembers, by name of the node.

    Attributes:
        status: every node's status.
        memory: what a node remembers while it is RUNNING; None when it starts.
        started: when it started [ms].
        kept: what a node remembers for the whole run.
        events: what leaves were told, in order.
        owners: which leaves command each resource in this tick.
        board: the blackboard.
        caught: (who caught, who raised).
        told: what ``log`` nodes told: their names.
    """

    def __init__(self, tree: Node) -> None:
        self.tree = tree
        names = [node.name for node in tree.all()]
        self.parents = {below.name: node for node in tree.all() for below in node.below}
        self.status = dict.fromkeys(names, INVALID)
        self.memory: dict[str, Any] = dict.fromkeys(names)
        self.started = dict.fromkeys(names, 0)
        self.kept: dict[str, Any] = dict.fromkeys(names)
        self.events: list[tuple[str, str]] = []
        self.owners: set[tuple[str, str]] = set()
        self.board: dict[str, Any] = {}
        self.caught: list[tuple[str, str]] = []
        self.told: list[str] = []
        self.stamp: int | None = None
        self.now = Snapshot(0)

    def step(self, now: Snapshot) -> str | None:
        """Tick the tree; return the name of the node that raised an exception, which halts the whole tree."""
        self.now = now
        self.owners = set()
        if now.stamp is not None and (self.stamp is None or now.stamp > self.stamp):
            self.stamp = now.stamp
        if self.status[self.tree.name] != RUNNING:
            self.board = dict(BOARD)
        try:
            self.tick(self.tree)
        except Broken as broken:
            self.halt_whatever_happens(self.tree)
            return broken.node.name
        return None

    def stop(self, time: int) -> str | None:
        """Halt the tree between two ticks; return the name of the first node that raised an exception meanwhile."""
        self.now = Snapshot(time)
        raised = self.halt_whatever_happens(self.tree)
        return raised[0].node.name if raised else None

    def tick(self, node: Node) -> str:
        """A node starts whenever it was not RUNNING before."""
        name = node.name
        try:
            if self.status[name] != RUNNING:
                self.memory[name], self.started[name] = None, self.now.time
                if node.kind in COMMANDS:
                    self.start(node)
            status = RULES[node.kind](self, node)
        except Broken as broken:
            if broken.node is node:
                self.abandon(node)
            raise
        if node.kind in COMMANDS and status != RUNNING:
            self.end(node, status)
        self.status[name] = status
        return status

    def halt(self, *nodes: Node) -> None:
        """A halt reaches everything below a node, children before parents."""
        for node in nodes:
            if node.kind == "on_error":
                self.halt_whatever_happens(node)
            else:
                self.halt(*node.below)
                self.halt_alone(node)

    def halt_alone(self, node: Node) -> None:
        """``terminate(INVALID)`` is called on nodes that are RUNNING; others only take the status."""
        was, self.status[node.name] = self.status[node.name], INVALID
        if was == RUNNING:
            if node.kind in COMMANDS:
                self.end(node, INVALID)
            if node.kind == "status_to_blackboard":
                self.board[node.values["key"]] = "invalid"
            if node.kind == "cooldown":
                self.kept[node.name] = self.now.time

    def halt_whatever_happens(self, node: Node) -> list[Broken]:
        """A node that raises while it is halted does not keep others from it; ``on_error`` catches what it can."""
        raised = []
        for below in node.below:
            raised += self.halt_whatever_happens(below)
        if node.kind == "on_error":
            self.caught += [(node.name, broken.node.name) for broken in raised]
            raised = []
        try:
            self.halt_alone(node)
        except Broken as broken:
            raised.append(broken)
        return raised

    def start(self, leaf: Node) -> None:
        self.events.append(("start", leaf.name))
        if leaf.values.get("raises") == "start":
            raise Broken(leaf)

    def end(self, leaf: Node, status: str) -> None:
        """A leaf that ends, or is halted, gives back what it commands."""
        self.events.append((status, leaf.name))
        self.owners = {(resource, owner) for resource, owner in self.owners if owner != leaf.name}
        if leaf.values.get("raises") == ("halt" if status == INVALID else "end"):
            self.status[leaf.name] = INVALID
            raise Broken(leaf)

    def abandon(self, node: Node) -> None:
        """A node that raised is told to stop, with everything below it."""
        try:
            self.halt(*node.below)
            if node.kind in COMMANDS:
                self.end(node, INVALID)
        except Broken:
            pass  # the first exception counts
        self.status[node.name] = INVALID

    def read(self, node: Node, key: str) -> Any:
        """Reading a key without a value is an exception."""
        if key not in self.board:
            raise Broken(node)
        return self.board[key]

    def holds(self, node: Node) -> bool:
        asked: Comparison = node.values["expression"]
        left = self.now.time if asked.left == "time" else self.read(node, asked.left)
        return bool(SIGNS[asked.sign](left, asked.right))

    def elapsed(self, node: Node) -> int:
        """Return how long a node has been running [ms]."""
        return self.now.time - self.started[node.name]

    def is_over(self, node: Node) -> bool:
        return self.elapsed(node) >= int(node.values["duration"])


def skill(m: Model, node: Node) -> str:
    """Commands its resources; then does what its script says, one letter per tick of its life, over and over."""
    turn = m.kept[node.name] or 0
    m.kept[node.name] = turn + 1
    m.events.append(("tick", node.name))
    m.owners |= {(resource, node.name) for resource in COMMANDS[node.kind]}
    letter = node.values["script"][turn % len(node.values["script"])]
    if letter == "x":
        raise Broken(node)
    return {"r": RUNNING, "s": SUCCESS, "f": FAILURE}[letter]


def success(m: Model, node: Node) -> str:
    return SUCCESS


def failure(m: Model, node: Node) -> str:
    return FAILURE


def running(m: Model, node: Node) -> str:
    return RUNNING


def wait(m: Model, node: Node) -> str:
    """Run for some time, then succeed."""
    return SUCCESS if m.is_over(node) else RUNNING


def ros_service(m: Model, node: Node) -> str:
    """Ask when it starts, run until the answer is there; fail when the time is over before. It writes its key."""
    if m.elapsed(node) < node.values["after"]:
        return FAILURE if m.is_over(node) else RUNNING
    if node.values["answer"] == SUCCESS:
        m.board["n"] = 5
    return str(node.values["answer"])


def wait_until(m: Model, node: Node) -> str:
    """Run until an expression is true, then succeed."""
    return SUCCESS if m.holds(node) else RUNNING


def condition(m: Model, node: Node) -> str:
    """A condition answers at once, never RUNNING."""
    return SUCCESS if m.holds(node) else FAILURE


def set_blackboard(m: Model, node: Node) -> str:
    """Give a key a value; here also one more than it has."""
    add = node.values.get("add")
    m.board["n"] = node.values["value"] if add is None else m.read(node, "n") + add
    return SUCCESS


def clear_blackboard(m: Model, node: Node) -> str:
    """Take the value of a key away."""
    m.board.pop("n", None)
    return SUCCESS


def log(m: Model, node: Node) -> str:
    """Told once for each start; silent where a composite that is RUNNING, or asks it as condition, asks it again."""
    below, above = node, m.parents.get(node.name)
    while above is not None and m.status[above.name] != RUNNING:
        below, above = above, m.parents.get(above.name)
    asks_again = above is not None and (above.kind in COMPOSITES or above.branches.get("condition") is below)
    if m.status[node.name] == INVALID or not asks_again:
        m.told.append(node.name)
    return SUCCESS


def in_order(m: Model, node: Node, passed: str, first: int) -> str:
    """Tick children in order, from the ``first`` up to one that has not ``passed``; halt the later ones."""
    for index in range(first, len(node.children)):
        status = m.tick(node.children[index])
        if status != passed:
            break
    m.halt(*node.children[index + 1 :])
    m.memory[node.name] = index
    return status


def sequence(m: Model, node: Node) -> str:
    """Go on at the child that runs; fail with the first that fails."""
    return in_order(m, node, SUCCESS, m.memory[node.name] or 0)


def selector(m: Model, node: Node) -> str:
    """Go on at the child that runs; succeed with the first that succeeds."""
    return in_order(m, node, FAILURE, m.memory[node.name] or 0)


def reactive_sequence(m: Model, node: Node) -> str:
    """A sequence that begins with the first child in every tick."""
    return in_order(m, node, SUCCESS, 0)


def reactive_selector(m: Model, node: Node) -> str:
    """A selector that begins with the first child in every tick."""
    return in_order(m, node, FAILURE, 0)


def parallel(m: Model, node: Node) -> str:
    """Tick all that have not ended, up to a threshold; failure counts first. Halt what still runs at the end."""
    ended = m.memory[node.name] or {}
    for child in node.children:
        if child.name not in ended:
            status = m.tick(child)
            if status != RUNNING:
                ended = m.memory[node.name] = {**ended, child.name: status}
    results = list(ended.values())
    count = {"all": len(node.children), "one": 1}
    success, failure = (count.get(node.values[what], node.values[what]) for what in ("success", "failure"))
    if results.count(FAILURE) >= failure:
        status = FAILURE
    elif results.count(SUCCESS) >= success:
        status = SUCCESS
    else:
        status = FAILURE if len(results) == len(node.children) else RUNNING
    if status != RUNNING:
        m.halt(*(child for child in node.children if child.name not in ended))
    return status


def choose(m: Model, node: Node, chosen: Node | None) -> str:
    """Halt the other branches, then tick the one that is chosen; fail if none is."""
    m.halt(*(branch for slot, branch in node.branches.items() if slot != "condition" and branch is not chosen))
    m.memory[node.name] = chosen
    return FAILURE if chosen is None else m.tick(chosen)


def if_(m: Model, node: Node) -> str:
    """Go on with the branch that was chosen; else choose one."""
    return m.tick(m.memory[node.name]) if m.memory[node.name] else reactive_if(m, node)


def reactive_if(m: Model, node: Node) -> str:
    """Run ``then`` while a condition holds, else ``else``; neither while it is RUNNING."""
    status = m.tick(node.branches["condition"])
    if status == RUNNING:
        choose(m, node, None)
        return RUNNING
    return choose(m, node, node.branches.get("then" if status == SUCCESS else "else"))


def switch(m: Model, node: Node) -> str:
    """Go on with the branch that was chosen; else choose one."""
    return m.tick(m.memory[node.name]) if m.memory[node.name] else reactive_switch(m, node)


def reactive_switch(m: Model, node: Node) -> str:
    """Run the case of the value, else ``default``; fail if there is neither."""
    value = str(m.read(node, node.values["value"]))
    return choose(m, node, node.branches.get(value, node.branches.get("default")))


def emergency_stop(m: Model, node: Node) -> str:
    """Hold while the robot is stopped, with the child halted."""
    if m.now.mode == "RUN":
        return m.tick(node.child)
    m.halt(node.child)
    return RUNNING


def watchdog(m: Model, node: Node) -> str:
    """Run the child while the percept is no older than ``max_age``; else halt it and run ``on_stale``, or fail."""
    on_stale = node.branches.get("on_stale")
    if m.stamp is not None and m.now.time - m.stamp <= node.values["max_age"]:
        m.halt(*([on_stale] if on_stale else []))
        return m.tick(node.child)
    m.halt(node.child)
    return m.tick(on_stale) if on_stale else FAILURE


def convert(**becomes: str) -> Callable[[Model, Node], str]:
    """Give another status than the child; what counts as ended is halted if it runs."""

    def rule(m: Model, node: Node) -> str:
        status = m.tick(node.child)
        if status == RUNNING and RUNNING in becomes:
            m.halt(node.child)
        return becomes.get(status, status)

    return rule


def count(m: Model, node: Node, what: str, limit: int) -> str:
    """Run the child anew when it ends with ``what``, until that has happened ``limit`` times (-1: for ever)."""
    status = m.tick(node.child)
    if status != what:
        return status
    m.memory[node.name] = (m.memory[node.name] or 0) + 1
    return what if m.memory[node.name] == limit else RUNNING


def retry(m: Model, node: Node) -> str:
    """One attempt per tick, RUNNING between two attempts."""
    return count(m, node, FAILURE, node.values["attempts"])


def repeat(m: Model, node: Node) -> str:
    """One run per tick, RUNNING between two runs."""
    return count(m, node, SUCCESS, node.values["times"])


def for_each(m: Model, node: Node) -> str:
    """Run the child once for each item, which is in a key when the child starts; an empty list succeeds."""
    items = node.values["items"]
    if not items:
        return SUCCESS
    if m.status[node.child.name] != RUNNING:
        m.board["n"] = items[m.memory[node.name] or 0]
    return count(m, node, SUCCESS, len(items))


def timeout(m: Model, node: Node) -> str:
    """Checked before the child is ticked: at the limit the child is halted and the node fails."""
    if m.is_over(node):
        m.halt(node.child)
        return FAILURE
    return m.tick(node.child)


def delay(m: Model, node: Node) -> str:
    """Wait for some time, then run the child."""
    if m.is_over(node):
        return m.tick(node.child)
    m.halt(node.child)
    return RUNNING


def cooldown(m: Model, node: Node) -> str:
    """Fail, without running the child, for some time after it ended or, see :meth:`Model.halt_alone`, was halted."""
    last = m.kept[node.name]
    if m.status[node.child.name] != RUNNING and last is not None and m.now.time - last < node.values["duration"]:
        m.halt(node.child)
        return FAILURE
    try:
        return m.tick(node.child)
    finally:
        m.kept[node.name] = m.now.time


def min_duration(m: Model, node: Node) -> str:
    """Go on RUNNING until some time is over; then give the child's result."""
    if m.memory[node.name] is None:
        status = m.tick(node.child)
        if status == RUNNING:
            return RUNNING
        m.memory[node.name] = status
    return str(m.memory[node.name]) if m.is_over(node) else RUNNING


def once(m: Model, node: Node) -> str:
    """Run the child until it has ended (or succeeded) once; give that result from then on."""
    if m.kept[node.name] is None:
        status = m.tick(node.child)
        if status == SUCCESS or (status == FAILURE and node.values["policy"] == "completion"):
            m.kept[node.name] = status
        return status
    return str(m.kept[node.name])


def status_to_blackboard(m: Model, node: Node) -> str:
    """Write the child's status, ``invalid`` when it raises; :meth:`Model.halt_alone` writes that it was halted."""
    status = INVALID
    try:
        status = m.tick(node.child)
    finally:
        m.board[node.values["key"]] = status.lower()
    return status


def on_error(m: Model, node: Node) -> str:
    """Fail, with everything below halted, instead of passing an exception on."""
    try:
        return m.tick(node.child)
    except Broken as broken:
        m.caught.append((node.name, broken.node.name))
        m.caught += [(node.name, other.node.name) for other in m.halt_whatever_happens(node.child)]
        return FAILURE


def ask(m: Model, node: Node, otherwise: str) -> str | None:
    """Ask the condition; unless it holds the child is halted, and this is the status."""
    status = m.tick(node.branches["condition"])
    if status == SUCCESS:
        return None
    m.halt(node.child)
    return RUNNING if status == RUNNING else otherwise


def guard(m: Model, node: Node) -> str:
    """Run the child only while a condition holds; asked in every tick."""
    return ask(m, node, FAILURE) or m.tick(node.child)


def precondition(m: Model, node: Node) -> str:
    """Start the child only if a condition holds; not asked while it runs."""
    return m.tick(node.child) if m.status[node.child.name] == RUNNING else guard(m, node)


def while_(m: Model, node: Node) -> str:
    """Run the child again and again while a condition holds, then succeed; fail when the child fails."""
    return ask(m, node, SUCCESS) or count(m, node, SUCCESS, -1)


COMPOSITES: dict[str, Callable[[Model, Node], str]] = {
    **{"sequence": sequence, "selector": selector, "parallel": parallel, "if": if_, "switch": switch},
    **{"reactive_sequence": reactive_sequence, "reactive_selector": reactive_selector},
    **{"reactive_if": reactive_if, "reactive_switch": reactive_switch},
}

RULES: dict[str, Callable[[Model, Node], str]] = {
    **dict.fromkeys(COMMANDS, skill),
    **{"success": success, "failure": failure, "running": running},
    **{"wait": wait, "wait_until": wait_until, "condition": condition, "log": log},
    **{"ros_service": ros_service, "ros_action": ros_service},
    **{"set_blackboard": set_blackboard, "clear_blackboard": clear_blackboard},
    **COMPOSITES,
    **{"emergency_stop": emergency_stop, "watchdog": watchdog},
    "inverter": convert(SUCCESS=FAILURE, FAILURE=SUCCESS),
    "force_success": convert(FAILURE=SUCCESS),
    "force_failure": convert(SUCCESS=FAILURE),
    "running_is_failure": convert(RUNNING=FAILURE),
    "running_is_success": convert(RUNNING=SUCCESS),
    "failure_is_running": convert(FAILURE=RUNNING),
    "success_is_running": convert(SUCCESS=RUNNING),
    "keep_running_until_failure": convert(SUCCESS=RUNNING),
    **{"retry": retry, "repeat": repeat, "for_each": for_each, "while": while_},
    **{"timeout": timeout, "delay": delay, "cooldown": cooldown, "min_duration": min_duration},
    **{"precondition": precondition, "guard": guard, "once": once, "on_error": on_error},
    "status_to_blackboard": status_to_blackboard,
}
"""What each node type does in a tick; it returns its status."""
