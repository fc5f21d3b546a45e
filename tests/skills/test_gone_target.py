"""What skills say of a target that is gone from where it was seen."""

from __future__ import annotations

from typing import Any

import pytest

from humanoid_bt import Rig

SKILLS: dict[str, dict[str, Any]] = {
    "approach": {},
    "reach": {},
    "look_at": {},
    "point_at": {},
    "offer": {},
    "touch_with_both": {"width": 0.2},
}


@pytest.mark.parametrize("skill", SKILLS)
def test_no_skill_does_anything_with_what_is_gone(rig: Rig, skill: str) -> None:
    rig.see("target", (0.4, 0.2, 0.95))
    rig.at(0.1, lambda: rig.see("target", (0.4, 0.2, 0.95), confidence=0.0))
    result = rig.run(skill, target="target", **SKILLS[skill])
    assert result.failed
    assert result.feedback == "'target' is gone from where it was seen"
    assert result.time < 0.2
