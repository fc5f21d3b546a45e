"""Options of a learned walker's description that would do nothing beside the others, or harm."""

from __future__ import annotations

from collections.abc import Iterator

from humanoid_bt.core.errors import Problem
from humanoid_bt.robot.policy.config import PolicyConfig

PHASES = ("phase_sin", "phase_cos")
_OF: dict[str, tuple[str, ...]] = {
    "axes": ("command",),
    "joints": ("joint_pos", "joint_pos_rel", "joint_vel"),
    "value": ("constant",),
}
_LEAST_ANSWERS = 2  # in a period of the phase: of fewer a network sees no cycle


def option_problems(config: PolicyConfig) -> Iterator[Problem]:
    """Yield the options that nothing reads, and those of which nothing can be made."""
    for number, term in enumerate(config.observation.terms):
        where = ("observation", "terms", number)
        for key, terms in _OF.items():
            if term.term not in terms and config.says(*where, key):
                message = f"{term.term!r} has no {key!r}"
                yield Problem(message, config.place(*where, key), f"only of {', '.join(terms)}", code="misplaced-key")
        if term.term == "constant" and not term.value:
            yield Problem("'constant' has no numbers", config.place(*where), "value: [0, 0]", code="policy")
    phase = config.phase
    if phase is None:
        return
    if not any(term.term in PHASES for term in config.observation.terms):
        message, hint = "no term observes the phase", f"a term {' or '.join(PHASES)}, or no 'phase'"
        yield Problem(message, config.place("phase"), hint, code="misplaced-key")
    if not phase.start:
        hint = "start: [0], or a number for each foot"
        yield Problem("the phase begins nowhere", config.place("phase", "start"), hint, code="policy")
    least = _LEAST_ANSWERS / config.rate
    if phase.period < least:
        message = f"a period of {phase.period:g} s is less than {_LEAST_ANSWERS} answers at {config.rate} Hz"
        yield Problem(message, config.place("phase", "period"), f"at least {least:g} s", code="policy")
