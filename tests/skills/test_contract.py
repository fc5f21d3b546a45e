"""The built-in skills keep the contract of docs/skills.md."""

from typing import Any

import pytest

from humanoid_bt import Rig, UserError

CASES: dict[str, dict[str, Any]] = {
    "approach": {"target": (0.9, 0.2, 1.0)},
    "idle": {"timeout": 2.0},
    "look_at": {"target": (1.0, 0.5, 1.0)},
    "offer": {"target": (1.0, 0.2, 1.2), "hold": 0.5},
    "point_at": {"target": (1.2, 0.4, 0.9), "hold": 0.3},
    "reach": {"target": (0.4, 0.15, 0.95)},
    "retract": {},
    "step_back": {},
    "touch_with_both": {"target": (0.36, 0.0, 0.85), "width": 0.2},
    "turn": {"angle": 0.6},
    "walk_to": {"x": 0.4, "y": 0.1},
    "wave": {"times": 1},
}
"""Skill -> parameters with which it succeeds."""

QUICK = ("look_at",)
ELSEWHERE = ("touch",)
"""Needs something that is there: ``test_touch.py``."""


@pytest.mark.parametrize(
    "skill", [name if name in QUICK else pytest.param(name, marks=pytest.mark.trials) for name in CASES]
)
def test_keeps_the_contract(rig: Rig, skill: str) -> None:
    rig.check_skill(skill, **CASES[skill]).assert_passed()


@pytest.mark.parametrize(
    ("skill", "parameter"),
    [
        ("approach", "distance"),
        ("offer", "height"),
        ("touch", "height"),
        ("touch", "distance"),
        ("touch_with_both", "clearance"),
    ],
)
def test_no_place_is_out_of_the_world(rig: Rig, skill: str, parameter: str) -> None:
    with pytest.raises(UserError, match=f"'{parameter}' must be .* <= 10, not 1500"):
        rig.run(skill, **CASES.get(skill, {}) | {parameter: 1500.0})


def test_none_is_left_out(rig: Rig) -> None:
    assert sorted(path.stem for path in (rig.workspace.root / "skills").glob("*.py")) == sorted([*CASES, *ELSEWHERE])
