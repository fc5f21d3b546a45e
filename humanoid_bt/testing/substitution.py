"""Stand-ins: nodes that do what a test says in the place of a tree's own."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import Param, param
from humanoid_bt.core.reading import convert, read
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.decision.result import Result, ResultValue, declared_results
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.nodes.ros import RosCall
from humanoid_bt.tree.source.build import paths
from humanoid_bt.tree.tree import Tree

Answered = Literal["success", "failure", "running"]
_ANSWERS: tuple[Answered, ...] = ("success", "failure", "running")
_VALID = "success, failure, running, a list of {status, after, feedback, results}, or {recorded: FILE}"
_AT = 1e-9  # s; engine times are sums of floats


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a stand-in does once it is started."""

    status: Answered = param(doc="What it answers in the end; running if it goes on until it is halted.")
    after: float = param(0.0, minimum=0, unit="s", doc="How long it runs before.")
    feedback: str = param("", doc="What it says.")
    results: dict[str, Any] = param(
        {},
        doc="What it reports in the end, by the names that the skill declares; of a node that asks others, by paths.",
    )

    def __post_init__(self) -> None:
        """Refuse another status, also in Python."""
        if self.status not in _ANSWERS:
            raise UserError(f"'status' cannot be {self.status!r}", hint=nearest(str(self.status), _ANSWERS))


@dataclass(frozen=True)
class Replacement:
    """What stands in a node's place.

    In YAML ``success``, ``failure`` or ``running``, an answer or a list of them, or ``{recorded: FILE}``.

    Attributes:
        answers: what it does each time it is started, one after the other; the last one from then on.
        recorded: the recording in which the node did that, None if the answers say it.
        place: where it is written.
    """

    answers: tuple[Answer, ...] = ()
    recorded: Path | None = None
    place: Place | None = None

    described: ClassVar[str] = "replacement"

    @classmethod
    def of(cls, value: Any, node: str) -> Replacement:
        """Return what a value of a test stands for.

        Raises:
            UserError: nothing.
        """
        if isinstance(value, Replacement):
            return value
        written = value if not isinstance(value, Answer) else [vars(value)]
        return cls.from_item(item_of(written, Place(f"replace {node}")), node)

    @classmethod
    def from_item(cls, item: Item, name: str) -> Self:
        """Read a replacement from a YAML value; raises UserError."""
        value = item.value
        if isinstance(value, str) and value in _ANSWERS:
            return cls((read(Answer, Item({"status": item}, item.place), repr(name)),), place=item.place)
        if isinstance(value, dict) and "recorded" in value:
            return cls(recorded=Path(read(_Recorded, item, repr(name)).recorded), place=value["recorded"].place)
        answers = value if isinstance(value, list) else [item]
        if isinstance(value, (dict, list)) and answers:
            return cls(tuple(_answer(answer, name) for answer in answers), place=item.place)
        hint = nearest(value, _ANSWERS) if isinstance(value, str) else f"valid: {_VALID}"
        raise UserError(f"nothing can stand in for {name!r} like this", item.place, hint, "wrong-type")

    def __str__(self) -> str:
        if self.recorded is not None:
            return f"as in {self.recorded}"
        return ", then ".join(
            answer.status + (f" after {answer.after:g} s" if answer.after else "") for answer in self.answers
        )


@dataclass(frozen=True, kw_only=True)
class _Recorded:
    recorded: str = param(doc="A recording in which the node ran.")


def _answer(item: Item, name: str) -> Answer:
    """Read an answer, which may be its status alone."""
    whole = item if isinstance(item.value, dict) else Item({"status": item}, item.place, {"status": item.place})
    answer: Answer = read(Answer, whole, f"the answer of {name!r}")
    return answer


class StandIn(Behaviour):
    """A node that answers what a test says, and commands nothing.

    Attributes:
        answers: what it does each time it is started.
        keys: the keys that get what it reports, of a node that asks other programs.
    """

    answers: ClassVar[tuple[Answer, ...]]
    keys: ClassVar[Mapping[str, Key]] = {}
    ends: ClassVar[bool] = True

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._started = -1
        self._since = 0.0
        self._results: dict[str, ResultValue] = {}
        self._robot: Robot

    def setup(self, **kwargs: Any) -> None:
        """Take the robot, whose clock it goes by."""
        self._robot = kwargs["robot"]

    def initialise(self) -> None:
        """Begin with the next answer."""
        self._started = min(self._started + 1, len(self.answers) - 1)
        self._since, self._results = self._robot.clock.now(), {}

    def update(self) -> Status:
        """Answer."""
        answer = self.answers[self._started]
        self.feedback_message = answer.feedback or "a stand-in of the test"
        if answer.status == "running" or self._robot.clock.now() - self._since < answer.after - _AT:
            return Status.RUNNING
        for name, value in answer.results.items():
            if name in self.keys:
                self.keys[name].set(value)
            else:
                setattr(self, name, value)
        return Status.SUCCESS if answer.status == "success" else Status.FAILURE


def substituted(tree: Tree, root: Draft, replacements: Mapping[str, Replacement]) -> Draft:
    """Return the draft of a tree in which stand-ins have the places of nodes.

    Args:
        tree: it.
        root: its draft.
        replacements: by the path of a node, the end of it, or the type of nodes.

    Raises:
        UserError: there is no such node, or it cannot be replaced so.
    """
    problems: list[Problem] = []
    found: dict[str, Replacement] = {}
    for name, replacement in replacements.items():
        try:
            found |= dict.fromkeys(_named(tree, name), replacement)
        except UserError as error:
            problems += [replace(problem, place=replacement.place) for problem in error.problems]
    if problems:
        raise UserError(problems)
    at = {id(draft): path for path, draft in paths(root, tree.name)}
    return _with_stand_ins(root, at, found)


def _named(tree: Tree, name: str) -> list[str]:
    """Return the paths of the nodes that a name stands for: those of a type, or one by its path."""
    of_type = [node.path for node in tree.nodes if node.type_name == name]
    return of_type or [tree.node(name).path]


def _with_stand_ins(draft: Draft, at: Mapping[int, str], found: Mapping[str, Replacement]) -> Draft:
    """Return a draft, or another in its place if a stand-in is in it."""
    path = at[id(draft)]
    if path in found:
        return _stand_in(draft, path, found[path])
    children = [_with_stand_ins(child, at, found) for child in draft.children]
    branches = {
        key: {name: _with_stand_ins(child, at, found) for name, child in branch.items()}
        if isinstance(branch, dict)
        else _with_stand_ins(branch, at, found)
        for key, branch in draft.branches.items()
    }
    return replace(draft, children=children, branches=branches)


def _stand_in(draft: Draft, path: str, replacement: Replacement) -> Draft:
    answers = replacement.answers
    if replacement.recorded is not None:
        from humanoid_bt.testing.recorded import recorded  # noqa: PLC0415 (what reads recordings takes a while to import)

        try:
            answers = tuple(Answer(**answer) for answer in recorded(replacement.recorded, path))
        except UserError as error:
            raise UserError([replace(problem, place=replacement.place) for problem in error.problems]) from None
    declared = declared_results(draft.type.cls)
    place = replacement.place or Place(f"replace {path}")
    keys: Mapping[str, Key] = {}
    if issubclass(draft.type.cls, RosCall):
        keys = draft.values.get(draft.type.cls.taken, {})
        for answer in answers:
            _check_reported(answer, keys, place, "the node takes")
    else:
        answers = tuple(_in_si(answer, declared, place) for answer in answers)
    cls = type("StandIn", (StandIn,), {"answers": answers, "keys": keys})
    for name, result in declared.items():
        setattr(cls, name, result)  # it stays the skill's own: its type is looked up there
    node_type = replace(draft.type, kind="action", cls=cls, params={}, resources=(), takes="none", branches={})
    return Draft(node_type, draft.place, draft.name)


def _check_reported(answer: Answer, known: Collection[str], place: Place, what: str) -> None:
    """Refuse results that a node does not have."""
    if unknown := [name for name in answer.results if name not in known]:
        hint = nearest(unknown[0], known) or "it reports nothing"
        raise UserError(f"{what} no {unknown[0]!r}", place, hint, "unknown-key")


def _in_si(answer: Answer, declared: Mapping[str, Result], place: Place) -> Answer:
    """Return an answer with results as a skill declares them; raises UserError."""
    _check_reported(answer, declared, place, "the skill reports")
    words = {"true": True, "false": False}  # as a recording has them
    given = {
        name: words.get(value, value) if declared[name].type is bool and isinstance(value, str) else value
        for name, value in answer.results.items()
    }
    specs = {name: Param(name, declared[name].type, unit=declared[name].unit) for name in answer.results}
    results = {name: convert(spec, item_of(given[name], place)) for name, spec in specs.items()}
    return replace(answer, results=results)
