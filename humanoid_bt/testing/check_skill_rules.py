"""The rules of the contract, judged by what was seen of a skill."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.class_files import class_place
from humanoid_bt.testing.check_skill_lives import Life, Moment, Subject
from humanoid_bt.testing.check_skill_result import RULES, RuleResult, SkillCheck
from humanoid_bt.testing.check_skill_trial import LONGEST_TICK, Evidence, Trial, estop_in_force

_NOT_TRIED = "an exception, or a tick that does not come back, stands in the way"
_NAMED = re.compile(r"\d|['\"`]\w")  # a number, or something quoted


class Broken(Exception):  # noqa: N818 (it is no error of ours)
    """A rule is broken; its text says what shows it."""


class NotTried(Exception):  # noqa: N818 (it is no error)
    """A rule could not be tried; its text says why."""


def tried(subject: Subject, timeout: float) -> SkillCheck:
    """Try a skill on its robot.

    Args:
        subject: the skill.
        timeout: longest simulated time of one of its lives [s].
    """
    seen, node_type = Trial(subject, timeout).run(), subject.node_type
    rules = {rule: _judged(rule, subject, seen) for rule in RULES}
    return SkillCheck(node_type.type_name, str(class_place(node_type.cls)), rules)


def _judged(rule: str, subject: Subject, seen: Evidence) -> RuleResult:
    ended_early = seen.first.error is not None
    try:
        if ended_early and rule not in _WITHOUT_A_LIFE:
            raise NotTried(_NOT_TRIED)
        return RuleResult(rule, "passed", _JUDGES[rule](subject, seen))
    except Broken as broken:
        return RuleResult(rule, "failed", str(broken))
    except NotTried as reason:
        return RuleResult(rule, "not tried", str(reason))


def _exceptions(_subject: Subject, seen: Evidence) -> str:
    if seen.first.hung:
        raise NotTried(_NOT_TRIED)
    if seen.first.error is not None:
        where = f"tick {len(seen.first.moments) + 1}" if seen.lives else "setup"
        raise Broken(f"in {where} it {seen.first.raised}")
    return _ended(seen.first)


def _blocking(_subject: Subject, seen: Evidence) -> str:
    limit = f"at most {LONGEST_TICK * 1000:g} ms of a tick's {DECISION_PERIOD * 1000:g}"
    if seen.first.hung:
        at = f", at {seen.first.hung_at}" if seen.first.hung_at else ""
        raise Broken(f"tick {len(seen.first.moments) + 1} did not come back{at}; {limit}")
    if seen.first.error is not None:
        raise NotTried(_NOT_TRIED)
    if not seen.took:
        raise NotTried("it cannot be made more than once")
    measured = f"p99 of {len(seen.took)} updates {seen.p99 * 1000:.2f} ms"
    if seen.slow:
        measured += f", the longest {max(seen.took) * 1000:.2f} ms" if len(seen.took) > 1 else ""
        raise Broken(f"{measured}" + (f", at {seen.slow_at}" if seen.slow_at else "") + f"; {limit}")
    return f"{measured}; {limit}"


def _halting(_subject: Subject, seen: Evidence) -> str:
    if seen.halts.problem:
        raise Broken(seen.halts.problem)
    if not seen.took:
        raise NotTried("it cannot be made more than once")
    if not seen.halts.ticks:
        return "it never runs for more than a tick"
    return f"halted in {seen.halts.ticks} of {_several(seen.halts.of, 'tick')}, nothing was commanded any more"


def _restarting(_subject: Subject, seen: Evidence) -> str:
    if not seen.same:
        raise NotTried("it does not do the same twice, so lives cannot be compared")
    if seen.halts.problem:
        raise NotTried("it cannot be halted as it should be")
    if seen.again.error is not None:
        raise Broken(f"started again where it had ended it {seen.again.raised}")
    if seen.renewed:
        raise Broken(f"in its second life, {seen.renewed}")
    if seen.halts.restart:
        raise Broken(f"after it was halted, {seen.halts.restart}")
    return f"again, after {_several(seen.halts.ticks, 'halt')}, and where it had ended: as if made anew"


def _ending(subject: Subject, seen: Evidence) -> str:
    cls = subject.node_type.cls
    for life in seen.lives.values():
        if not getattr(cls, "ends", True) and life.status in (Status.SUCCESS, Status.FAILURE):
            raise Broken(f"it declares ends = False, and {_ended(life)}")
        if not getattr(cls, "runs", True) and any(moment.status is Status.RUNNING for moment in life.moments):
            raise Broken("it declares runs = False, and was RUNNING")
    return _ended(seen.first)


def _commands(subject: Subject, seen: Evidence) -> str:
    try:
        declared = subject.node_type.commands(subject.values)
    except UserError as error:
        raise Broken(error.problems[0].message) from error
    if beyond := [name for name in seen.commanded if name not in declared]:
        raise Broken(f"it commands {_list(beyond)}, and declares {_list(declared)}")
    unused = [name for name in declared if name not in seen.commanded]
    return _list(seen.commanded) + (f"; declared and not commanded here: {_list(unused)}" if unused else "")


def _percepts(subject: Subject, seen: Evidence) -> str:
    declared = {name for names in subject.node_type.percepts(subject.values).values() for name in names}
    if beyond := [name for name in seen.read if name not in declared]:
        raise Broken(f"it asks for {_list(map(repr, beyond))}, and declares {_list(map(repr, sorted(declared)))}")
    return _list(map(repr, seen.read))


def _snapshot(_subject: Subject, seen: Evidence) -> str:
    if seen.overwritten:
        raise Broken(f"it wrote over {_list(seen.overwritten)}")
    return f"unchanged in {_several(sum(len(life.moments) for life in seen.lives.values()), 'tick')}"


def _reasons(subject: Subject, seen: Evidence) -> str:
    failures = [moment for life in seen.lives.values() for moment in life.moments if moment.status is Status.FAILURE]
    said: dict[str, None] = {}
    for moment in failures:
        text = moment.feedback.strip()
        if not text:
            raise Broken(f"it failed without a word at {moment.now:.2f} s")
        if not _tells(text, subject.node_type.complete(subject.values), moment):
            raise Broken(f"it failed with {text!r}: no value, no name of a thing")
        said[text] = None
    return _list(map(repr, said)) if said else "it never failed here"


def _sameness(_subject: Subject, seen: Evidence) -> str:
    if seen.clocks:
        clock, place = next(iter(seen.clocks.items()))
        raise Broken(f"{place} reads {clock}()")
    if seen.dice:
        raise Broken(f"it throws the dice of {_list(seen.dice)}, which everybody shares")
    if seen.repeated:
        raise Broken(f"another instance, shown the same, did otherwise: {seen.repeated}")
    return f"two more instances, shown the same, did the same in {_several(len(seen.first.moments), 'tick')}"


def _estop(subject: Subject, seen: Evidence) -> str:
    life = _life(seen, "stopped")
    stopped = estop_in_force(life)
    _survived(life, "while the robot was stopped", stopped)
    return _came_of(life, stopped) if stopped else f"{_ended(life)} before the robot was stopped"


def _lost(subject: Subject, seen: Evidence) -> str:
    if not seen.read:
        return "it asks for none"
    lost, unseen = _life(seen, "lost"), _life(seen, "never seen")
    _survived(lost, "after its percepts were lost", lost.moments[seen.early :])
    _survived(unseen, "when it had never seen anything", unseen.moments)
    return f"lost: {_came_of(lost, lost.moments)}; never seen: {_came_of(unseen, unseen.moments)}"


def _life(seen: Evidence, name: str) -> Life:
    """Return a life; raises NotTried if it came to none."""
    if name not in seen.lives:
        raise NotTried("it cannot be made more than once")
    return seen.lives[name]


def _survived(life: Life, when: str, moments: list[Moment]) -> None:
    """Raise Broken if it raised something, or waited without a word."""
    if life.error is not None:
        what = f"did not come back from a tick, at {life.hung_at}" if life.hung else life.raised
        raise Broken(f"{when} it {what}")
    for moment in moments:
        if moment.status is Status.RUNNING and not moment.feedback.strip():
            raise Broken(f"{when} it ran on without a word on what it waits for")


def _came_of(life: Life, moments: list[Moment]) -> str:
    words = {Status.SUCCESS: "succeeded", Status.FAILURE: "failed"}
    last = moments[-1] if life.status is Status.RUNNING else life.moments[-1]
    return f"{words.get(last.status, 'waited')}, {last.feedback!r}"


def _tells(text: str, values: Mapping[str, Any], moment: Moment) -> bool:
    """Return whether a reason names a value: a number, something quoted or given, or why the robot is stopped."""
    words = [value for value in values.values() if value and isinstance(value, str)]
    reason = moment.state.stop_reason
    return bool(_NAMED.search(text) or any(word in text for word in words) or (reason and reason in text))


def _ended(life: Life) -> str:
    time = life.moments[-1].now - life.moments[0].now
    how = {Status.SUCCESS: "succeeded", Status.FAILURE: "failed"}.get(life.status, "still ran")
    return f"{how} after {time:.2f} s" + (f": {life.moments[-1].feedback}" if life.moments[-1].feedback else "")


def _list(names: Iterable[str]) -> str:
    return ", ".join(names) or "nothing"


def _several(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


_JUDGES: Mapping[str, Callable[[Subject, Evidence], str]] = {
    "exceptions": _exceptions,
    "blocking": _blocking,
    "halting": _halting,
    "restarting": _restarting,
    "ending": _ending,
    "commands": _commands,
    "percepts": _percepts,
    "snapshot": _snapshot,
    "reasons": _reasons,
    "sameness": _sameness,
    "estop": _estop,
    "lost": _lost,
}
"""Rule -> what returns the evidence that it is kept."""

_WITHOUT_A_LIFE = ("exceptions", "blocking")
"""Rules that can be judged if the first life ended with an exception."""
