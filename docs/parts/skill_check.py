"""What a skill is tried for."""

from __future__ import annotations

from humanoid_bt.testing.check_skill_result import RULES
from parts.markdown import table


def skill_rules() -> str:
    """Return the rules of the contract."""
    rows = [(f"`{rule}`", title, advice) for rule, (title, advice) in RULES.items()]
    return table(("rule", "a skill", "what to do about one that does not"), rows)
