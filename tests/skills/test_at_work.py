"""Skills after a walk, pushed, touched, and again and again."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from humanoid_bt import Rig

SKILLS = Path(__file__).parents[2] / "skills"


def test_points_along_the_line_from_the_shoulder_wherever_it_stands(rig: Rig) -> None:
    assert rig.run("walk_to", x=0.5, y=0.3, heading=1.0, timeout=20).succeeded
    target = np.array([0.5, 0.3, 1.0]) + 1.5 * np.array([math.cos(1.2), math.sin(1.2), 0.0])
    result = rig.run("point_at", target=tuple(target.tolist()))
    assert result.succeeded, result.feedback
    line, fingers = target - rig.pose("left_shoulder").position, rig.pose("left_palm").rotation[:, 0]
    assert line @ fingers / np.linalg.norm(line) > math.cos(math.radians(6))


@pytest.mark.parametrize(("heading", "half"), [(0.7, 0.5), (0.7 - math.pi / 2, 0.05)])
def test_a_thing_reaches_as_far_as_it_is_turned(heading: float, half: float) -> None:
    spec = importlib.util.spec_from_file_location("point_at_alone", SKILLS / "point_at.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    thing = SimpleNamespace(size=np.array([1.0, 0.1, 2.0]), heading_world=heading)
    assert module._half(thing, np.array([math.cos(0.7), math.sin(0.7), 0.0])) == pytest.approx(half)


def test_draws_the_palm_back_at_once_from_a_target_that_comes_a_little_nearer(rig: Rig) -> None:
    rig.at(1.5, lambda: rig.see("target", (0.67, 0.0, 1.0)))
    result = rig.run("offer", target=(0.70, 0.0, 1.0), distance=0.6, clearance=0.2, hold=3.0, timeout=2.0)
    ahead = {
        round(command.stamp, 2): float(np.hypot(*command.targets["right_hand"].position[:2]))
        for command in result.commands
        if "right_hand" in command.targets
    }
    assert ahead[1.4] == pytest.approx(0.50, abs=0.01)
    assert ahead[1.66] == pytest.approx(0.47, abs=0.01)


def test_has_new_patience_for_every_stroke(rig: Rig) -> None:
    result = rig.run("wave", times=8, timeout=15)
    assert result.succeeded, result.feedback


@pytest.mark.parametrize(("skill", "values"), [("offer", {"target": (1.2, -0.3, 1.0)}), ("wave", {})])
def test_gives_up_at_once_when_something_touches_the_arm(rig: Rig, skill: str, values: dict[str, object]) -> None:
    rig.at(0.5, lambda: rig.push((-60, 0, 0), duration=0.6, body="right_forearm"))
    result = rig.run(skill, hand="right", patience=5.0, **values)
    assert result.failed
    assert result.feedback.startswith("right arm touched something")
    assert result.time < 1.2


def test_steps_back_to_where_it_faces_as_closely_as_it_is_told(rig: Rig) -> None:
    result = rig.run("step_back", distance=0.3, tolerance=0.1, angle_tolerance=1e-6, patience=1.0)
    assert result.failed
    assert result.feedback.startswith("comes no farther")


def test_comes_back_to_its_spot_when_it_is_pushed_as_it_turns(rig: Rig) -> None:
    for time in (0.8, 1.6, 2.4):
        rig.at(time, lambda: rig.push((70, 0, 0), duration=0.2))
    result = rig.run("turn", angle=3.0, timeout=15)
    assert result.succeeded, result.feedback
    assert np.hypot(*rig.state.stance[:2]) < 0.04
