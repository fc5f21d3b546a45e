"""What names mean in one tree file: its parameters and the keys of its blackboard."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from humanoid_bt.core.errors import Place, Problem, UserError, also_at
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import Param, PerceptName
from humanoid_bt.core.reading import convert
from humanoid_bt.core.units import base_unit
from humanoid_bt.decision.blackboard import KEY_NAME, Key
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.grammar import names
from humanoid_bt.tree.expressions.quantities import ANYTHING, NODE, NUMBER, TEXT, TRUTH, Type, number, type_of
from humanoid_bt.tree.source.parameters import Declaration, NodeItem, Parameters, meant


class _Written(NamedTuple):
    """What a node writes, and where it names the key."""

    place: Place | None
    output: Param | None = None  # how a sub-tree declares it
    literals: Sequence[Item] = ()  # as it stands in the file

    @property
    def kind(self) -> Type:
        """Its type, if all of it has one; of quantities it is text, as nothing says that it is a number."""
        if self.output is not None:
            return declared_type(self.output)
        values = [item.plain() for item in self.literals if item.value is not None]
        kinds = {type_of(value) for value in values}
        if kinds == {TEXT, NUMBER} and all(base_unit(value) for value in values if isinstance(value, str)):
            return TEXT
        return kinds.pop() if len(kinds) == 1 else ANYTHING


@dataclass
class _Known:
    """A key, and who writes and reads it."""

    key: Key
    place: Place | None = None  # where it is declared
    declared: Param | None = None
    written: list[_Written] = field(default_factory=list)
    read_at: list[tuple[Place, Param | None]] = field(default_factory=list)  # where, and for which parameter
    own: bool = True  # False: the caller's, handed in
    broken: bool = False  # whether its declaration has a mistake, which is enough to tell

    @property
    def spec(self) -> Param | None:
        """What it takes: as declared, else as the first output says that it gets."""
        return self.declared or self.key.spec


class Scope:
    """What names mean in one use of one tree file.

    Keys are named by whoever writes them, or declared in the file. Since one may be read above the node that writes
    it, expressions are linked and keys are judged when the whole file has been read (:meth:`finish`).

    Args:
        parameters: the tree's parameters.
        blackboard: the keys that the file declares, with their initial values.
        outputs: the keys that the file offers to its caller.
        bound: keys of the caller, by the name of the output that they are bound to.
        problems: takes every mistake.
    """

    def __init__(
        self,
        parameters: Parameters,
        blackboard: Mapping[str, Declaration],
        outputs: Mapping[str, Declaration],
        bound: Mapping[str, Key],
        problems: list[Problem],
    ) -> None:
        self.parameters = parameters
        self._outputs = outputs
        self._problems = problems
        self._expressions: list[Expression] = []
        self._refused: list[tuple[str, Problem]] = []
        self._keys: dict[str, _Known] = {}
        for name, declaration in outputs.items():
            key = bound.get(name)
            self._keys[name] = _Known(
                key or _declared(name, declaration.spec),
                declaration.place,
                declaration.spec,
                own=key is None,
            )
        for name, declaration in blackboard.items():
            self._declare(name, declaration)

    @property
    def own_keys(self) -> list[Key]:
        """The keys that belong to this use of the file, and begin anew whenever it starts."""
        return [known.key for known in self._keys.values() if known.own]

    def write(
        self, name: str, place: Place | None = None, output: Param | None = None, literals: Sequence[Item] = ()
    ) -> Key:
        """Return the key of a name for a node that writes it.

        Args:
            name: the key's.
            place: where the node names it.
            output: how a sub-tree declares what is written.
            literals: what is written, if that stands in the file.
        """
        known = self._keys.setdefault(name, _Known(Key(name)))
        known.written.append(_Written(place, output, literals))
        if known.key.spec is None and output is not None:
            known.key.spec = replace(output, name=name)
        return known.key

    def suppose(self, item: Item) -> None:
        """Take every name in what cannot be read for a key that would be written, so that its uses are no mistakes."""
        parts = item.value.values() if isinstance(item.value, dict) else item.value
        if isinstance(parts, str):
            if KEY_NAME.match(parts):
                self.write(parts)
        elif isinstance(parts, Iterable):
            for part in parts:
                self.suppose(part)

    def read(self, name: str, place: Place, spec: Param | None = None) -> Key:
        """Return the key of a name for a node that reads it; whether that can be right is judged at the end.

        Args:
            name: the key's.
            place: where it is read.
            spec: the parameter that gets its value, None for a part of an expression.
        """
        known = self._keys.setdefault(name, _Known(Key(name)))
        known.read_at.append((place, spec))
        return known.key

    def refuse(self, name: str, problem: Problem) -> None:
        """Note that a key is used where none can be: the problem, unless there is no such key at all."""
        if name in set(self.parameters):
            self._problems.append(problem)
        else:
            assert problem.place is not None
            self.read(name, problem.place)
            self._refused.append((name, problem))

    def add(self, expression: Expression) -> None:
        """Take an expression, to be linked when the whole file has been read."""
        self._expressions.append(expression)

    def finish(self) -> None:
        """Link every expression, and note every key that is read and never written, or declared in vain."""
        for expression in self._expressions:
            try:
                expression.link(self)
            except UserError as error:
                self._problems += error.problems
                there = set(self.known)
                expression.keys = [name for name in names(expression.syntax) if name in there]  # not unused as well
            for name in expression.keys:
                if self.parameters.find(name) is None:
                    self.read(name, expression.place)
        for name, known in self._keys.items():
            self._judge(name, known)
        self._problems += [problem for name, problem in self._refused if self._exists(self._keys[name])]

    # ---- what expressions ask (see Names) ------------------------------------------------------------------------

    @property
    def fixed(self) -> Collection[str]:
        """The names of all parameters whose value is known before the run."""
        return self.parameters.values

    @property
    def known(self) -> Iterator[str]:
        """The names of all parameters and keys."""
        yield from self.parameters
        yield from (name for name, known in self._keys.items() if self._exists(known))

    def value(self, name: str) -> tuple[Type, Callable[[], Any]] | None:
        """Return type and value of a parameter or a key, None if there is none of this name."""
        parameter = self.parameters.find(name)
        if parameter is not None:
            kind, value = declared_type(parameter.spec), parameter.value
            return kind, (lambda: value.value) if isinstance(value, Key) else (lambda: value)
        known = self._keys.get(name)
        if known is None or not self._exists(known):
            return None
        key = known.key
        return _of(known), lambda: key.value

    def percept(self, name: str) -> str:
        """Return the percept that a name means: a parameter's value, "" if it has none yet; else the name itself.

        Raises:
            UserError: the parameter is given a key of the blackboard.
        """
        parameter = self.parameters.find(name)
        if parameter is not None and parameter.given is not None and isinstance(parameter.value, Key):
            message = f"{name!r} names a percept: it must be known before the run, and is given a key of the blackboard"
            raise UserError(message, parameter.given.place, "give it a value or a parameter", "not-dynamic")
        if parameter is not None and not parameter.known:
            return ""
        return parameter.value if parameter is not None and isinstance(parameter.value, str) else name

    def is_set(self, name: str) -> Callable[[], bool] | None:
        """Return what tells whether a key has a value, None if there is no such key."""
        known = self._keys.get(name)
        if known is None or self.parameters.find(name) is not None:
            return None
        key = known.key
        return lambda: key.is_set

    # ---- keys ----------------------------------------------------------------------------------------------------

    @staticmethod
    def _exists(known: _Known) -> bool:
        return bool(known.written or known.place)

    def _declare(self, name: str, declaration: Declaration) -> None:
        initial = declaration.default
        key = Key(name)
        if initial is not None:
            try:
                key = Key(name, convert(declaration.spec, initial))
            except UserError as error:
                self._problems += error.problems
        key.spec = declaration.spec
        if name in self._keys or name in set(self.parameters):
            message = f"the name {name!r} is declared twice in one tree"
            self._problems.append(Problem(message, declaration.place, "rename one of them", "taken-name"))
            return
        self._keys[name] = _Known(key, declaration.place, declaration.spec, broken=declaration.broken)

    def _judge(self, name: str, known: _Known) -> None:
        if known.broken:
            return
        if known.place is None and name in set(self.parameters):
            places = list(dict.fromkeys(written.place for written in known.written if written.place))
            if places:
                message = f"the key {name!r} has the name of a parameter of the tree, which is what its name means"
                self._problems.append(Problem(message, places[0], "rename one of them" + also_at(places), "taken-name"))
            return
        if known.read_at and not known.written and not known.key.has_initial:
            hint = meant(name, self.known)
            if known.place is None:
                message, code = f"unknown parameter or key '${name}'", "unknown-reference"
            else:
                message, code = f"the key {name!r} is read, but nothing writes it", "unwritten-key"
                hint = "give it a default where it is declared, or a node that writes it"
            places = list(dict.fromkeys(place for place, _ in known.read_at))
            self._problems.append(Problem(message, places[0], hint + also_at(places), code))
            return
        self._problems += _misfits(name, known)
        self._problems += filter(None, (_misread(name, known, place, spec) for place, spec in known.read_at if spec))
        if name in self._outputs and not known.written:
            message = f"nothing writes the output {name!r}"
            self._problems.append(Problem(message, known.place, "set_blackboard, or a skill's key", "unwritten-key"))
        elif known.place and not known.read_at and name not in self._outputs:
            message = f"nothing reads the key {name!r}"
            self._problems.append(Problem(message, known.place, "remove it", "unused-key", "warning"))


def _of(known: _Known) -> Type:
    """Return the type of a key: as declared, else what all that writes it agrees on."""
    declared = ANYTHING if known.spec is None else declared_type(known.spec)
    if declared.kind != "anything":
        return declared
    kinds = {written.kind for written in known.written}
    return kinds.pop() if len(kinds) == 1 else ANYTHING


def _misread(name: str, known: _Known, place: Place, spec: Param) -> Problem | None:
    """Return what is wrong with a key that a parameter is given, if the parameter can never take what is in it."""
    literal = known.spec is None and known.written and all(written.literals for written in known.written)
    items = [item for written in known.written for item in written.literals] if literal else []
    refused = [problem for item in items for problem in _refused(spec, item)]
    kind, wanted = _of(known), declared_type(spec)
    if not kind.goes_with(wanted) and (refused or not items):
        message = f"{spec.name!r} must be {wanted}, and the key {name!r} is {kind}"
        return Problem(message, place, spec.doc, _mismatch(kind, wanted))
    if refused and all(_refused(spec, item) for item in items):
        hint = "; ".join(filter(None, [refused[0].hint, f"${name} is used at {place}"]))
        return replace(refused[0], hint=hint)
    return None


def _refused(spec: Param, item: Item) -> list[Problem]:
    """Return what a parameter refuses a value for, as it stands in the file: not text such as 50 cm for a length."""
    try:
        convert(spec, item)
    except UserError as error:
        return list(error.problems)
    return []


def _misfits(name: str, known: _Known) -> Iterator[Problem]:
    """Return what is written to a key and does not go with its declaration, or with the first output that it gets."""
    taker = Key(name)  # as the run's takes what is written
    taker.spec = known.spec
    wanted = ANYTHING if known.spec is None else declared_type(known.spec)
    first = next((written.place for written in known.written if written.output), None)
    hint = f"{name!r} is declared at {known.place}" if known.declared else f"it is written at {first}" if first else ""
    for written in known.written:
        for item in written.literals:
            try:
                taker.taken(item.plain(), item.place)
            except UserError as error:
                for problem in error.problems:
                    yield replace(problem, hint="; ".join(filter(None, [problem.hint, hint])))
        if written.output is not None and not written.kind.goes_with(wanted):
            message = f"the output {written.output.name!r} is {written.kind}, and the key {name!r} is {wanted}"
            yield Problem(message, written.place, hint, _mismatch(written.kind, wanted))


def _mismatch(kind: Type, wanted: Type) -> str:
    return "wrong-unit" if kind.kind == wanted.kind else "wrong-type"


def _declared(name: str, spec: Param) -> Key:
    key = Key(name)
    key.spec = spec
    return key


def declared_type(spec: Param) -> Type:
    """Return the type of a declared parameter's value."""
    if spec.type in (float, int):
        return number(spec.unit)
    return {bool: TRUTH, str: TEXT, PerceptName: TEXT, NodeItem: NODE}.get(spec.type, ANYTHING)
