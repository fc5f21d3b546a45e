"""The built-in skills keep the contract of docs/skills.md."""

import json
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt import Rig, Stage, UserError
from humanoid_bt.control.controller import Controller
from humanoid_bt.decision import skill as skill_module

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


@pytest.fixture(scope="module")
def dry() -> Stage:
    return Stage(dry=True)


@pytest.mark.parametrize("skill", ["look_at", "point_at", "reach", "offer", "touch_with_both"])
def test_a_target_that_moves_now_and_then_does_not_keep_it_for_ever(dry: Stage, tmp_path: Path, skill: str) -> None:
    values = CASES.get(skill, {}) | {"target": "target", "hold": "500 ms", "patience": "200 ms"}
    leaf = json.dumps({skill: values})
    watched = f"{{watchdog: {{percept: target, max_age: 1 s, child: {leaf}}}}}"
    (tmp_path / "t.yaml").write_text(f"format: 1\nscene: empty\nroot: {{emergency_stop: {watched}}}\n")
    script = [
        {"at": f"{200 * i} ms", "see": {"percept": "target", "position": [0.5, 0.2 * (-1) ** i, 1.0]}}
        for i in range(30)
    ]
    run = dry.run(tmp_path / "t.yaml", script=script, duration=6.0)
    assert 3.4 < run.time < 4.0
    *_, last = (change.feedback for change in run.changes if change.path.endswith(skill))
    assert "does not keep" in last or "not stay" in last


RESTS = {"step_back": {"distance": 0.05}, "touch": {}, "turn": {"angle": 0.05}, "walk_to": {"x": 0.0, "y": 0.0}}
"""Skill -> parameters with which it is there before it moves, where those of ``CASES`` are others."""


@pytest.mark.parametrize(
    "skill",
    ["offer", "point_at", "reach", "step_back", "touch", "touch_with_both", "turn", "walk_to", "wave"],
)
def test_does_not_wait_for_ever_for_a_base_that_never_rests(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, skill: str
) -> None:
    monkeypatch.setattr(Controller, "settled", False)
    monkeypatch.setattr(skill_module, "_REST_TIME", 0.3)
    result = rig.run(skill, timeout=1.0, **RESTS.get(skill) or CASES.get(skill, {}))
    assert result.failed
    assert result.feedback == "the base does not come to rest within 0.3 s"
    assert len(result.states) == 16


def test_none_is_left_out(rig: Rig) -> None:
    assert sorted(path.stem for path in (rig.workspace.root / "skills").glob("*.py")) == sorted([*CASES, *ELSEWHERE])
