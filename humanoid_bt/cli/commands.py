"""Commands that a person types while a run is paused: looking, setting, forcing."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from humanoid_bt.core.errors import UserError, nearest
from humanoid_bt.core.units import readable
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.session.outside_parameters import Described
from humanoid_bt.session.session import Session
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.show import outline_of, unicode_tree
from humanoid_bt.tree.show.fold import fitted

HELP = """\
show                   the tree, with the status of every node
percepts               what was seen
keys                   the blackboard
parameters [NODE]      of the tree, or of a node
set NAME = VALUE       a key, a parameter of the tree, or NODE.PARAMETER: set reach.patience = 5 s
force NODE RESULT      the node's next tick gives SUCCESS or FAILURE
break WHERE            pause there: reach, reach=FAILURE, distance(target) < 0.5 m
clear                  pause nowhere by itself"""

_MOST_LINES = 40  # of a drawn tree; what does not run is folded


def answer(session: Session, line: str, source: str) -> str:
    """Do what a line says, between two ticks; return what there is to show.

    Raises:
        UserError: it says nothing that can be done.
    """
    word, _, rest = line.strip().partition(" ")
    found = [name for name in _COMMANDS if name.startswith(word.lower())]
    if word.lower() in _COMMANDS:
        found = [word.lower()]
    if len(found) != 1:
        raise UserError(f"unknown command {word!r}", hint=nearest(word.lower(), _COMMANDS))
    return _COMMANDS[found[0]](session, rest.strip(), source)


def _show(session: Session, _rest: str, _source: str) -> str:
    tree = session.tree
    statuses = {node.path: node.status for node in tree.nodes}
    feedback = {node.path: node.feedback for node in tree.nodes if node.feedback}
    outline = fitted(
        outline_of(tree), statuses, lambda smaller: len(unicode_tree(smaller, statuses).splitlines()) < _MOST_LINES
    )
    return unicode_tree(outline, statuses, feedback=feedback)


def _percepts(session: Session, _rest: str, _source: str) -> str:
    seen = [
        f"{name}: {readable(track.distance, 'm')} away, {readable(track.bearing, 'rad')} to the left, "
        f"{readable(track.age, 's')} old, confidence {readable(track.confidence)}"
        for name, track in session.percepts.items()
    ]
    return _lines(seen + [f"{name}: never seen, {why}" for name, why in session.engine.unseen.items()])


def _keys(session: Session, _rest: str, _source: str) -> str:
    return _lines([f"{key.name} = {_value(key)}" for key in session.tree.keys])


def _parameters(session: Session, rest: str, _source: str) -> str:
    if not rest:
        shown = [Described(session.tree, name) for name in session.tree.parameters]
        return _lines([f"{one.words['name']} = {readable(one.value, one.words['unit'])}" for one in shown])
    return _lines(list(_parameters_of(session.node(rest))))


def _parameters_of(node: Node) -> Iterator[str]:
    for name, spec in node.type.params.items():
        value = getattr(node.behaviour, name, node.values.get(name))
        yield f"{name} = {_value(value) if isinstance(value, Key) else readable(value, spec.unit)}"


def _set(session: Session, rest: str, source: str) -> str:
    name, equals, value = rest.partition("=")
    if not (equals and name.strip() and value.strip()):
        raise UserError(f"'set {rest}' sets nothing", hint="example: set reach.patience = 5 s")
    session.set(name.strip(), value.strip(), source=source)
    return ""


def _force(session: Session, rest: str, source: str) -> str:
    path, _, result = rest.rpartition(" ")
    if not path.strip():
        raise UserError(f"'force {rest}' forces nothing", hint="example: force reach FAILURE")
    session.force(path.strip(), result, source=source)
    return ""


def _break(session: Session, rest: str, _source: str) -> str:
    session.break_at(rest)
    return _lines(list(session.breakpoints))


def _clear(session: Session, _rest: str, _source: str) -> str:
    session.clear_breakpoints()
    return ""


def _help(_session: Session, _rest: str, _source: str) -> str:
    return HELP


_COMMANDS: dict[str, Callable[[Session, str, str], str]] = {
    "show": _show,
    "percepts": _percepts,
    "keys": _keys,
    "parameters": _parameters,
    "set": _set,
    "force": _force,
    "break": _break,
    "clear": _clear,
    "help": _help,
}


def _value(key: Key) -> str:
    return readable(key.value, key.spec.unit if key.spec else "") if key.is_set else "(not set)"


def _lines(lines: list[str]) -> str:
    return "\n".join(lines) or "none"
