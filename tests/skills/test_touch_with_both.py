"""The skill ``touch_with_both``, alone on the simulated robot."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt import Rig

HALF_HAND = 0.03  # m, the skill's clearance


def apart(rig: Rig) -> tuple[np.ndarray, float]:
    """Return the right palm as seen from the left one, shape (3,) [m], and how far they do not face each other."""
    left, right = rig.pose("left_palm"), rig.pose("right_palm")
    facing = float(left.rotation[:, 2] @ right.rotation[:, 2])
    return left.rotation.T @ (right.position - left.position), np.arccos(max(-1.0, -1.0 if facing < -1 else -facing))


@pytest.mark.parametrize(
    ("target", "width"),
    [
        ((0.36, 0.0, 0.85), 0.2),
        *(
            pytest.param(target, width, marks=pytest.mark.trials)
            for target, width in [((0.32, 0.05, 0.75), 0.12), ((0.4, -0.05, 0.95), 0.3), ((0.36, 0.0, 0.7), 0.25)]
        ),
    ],
)
def test_both_palms_face_each_other_at_the_sides_of_the_target(
    rig: Rig, target: tuple[float, float, float], width: float
) -> None:
    result = rig.run("touch_with_both", target=target, width=width)
    assert result.succeeded, result.feedback
    offset, turned = apart(rig)
    np.testing.assert_allclose(offset, [0, 0, width + 2 * HALF_HAND], atol=0.01)
    assert abs(turned) < np.radians(3)
    middle = (rig.state.hands["left"] + rig.state.hands["right"]) / 2
    assert np.linalg.norm(middle - target) < 0.01
    assert result.results["hand_error"] < 0.01
    assert not result.stops


@pytest.mark.trials
def test_a_slow_hand_that_waits_for_the_other_one_goes_on(rig: Rig) -> None:
    result = rig.run("touch_with_both", target=(0.36, 0.0, 0.85), width=0.2, speed=0.03, timeout=60)
    assert result.succeeded, result.feedback


@pytest.mark.trials
def test_passes_beside_the_target_before_it_closes_in(rig: Rig) -> None:
    target, width = np.array([0.36, 0.0, 0.85]), 0.2
    result = rig.run("touch_with_both", target=target, width=width)
    for state in result.states:
        for palm in state.hands.values():
            beside = abs(palm[1]) > width / 2
            assert beside or np.linalg.norm((palm - target)[[0, 2]]) > 0.1


def test_gives_up_at_once_when_something_touches_an_arm(rig: Rig) -> None:
    rig.at(1.0, lambda: rig.push((-60.0, 0.0, 0.0), 0.2, "right_hand"))
    result = rig.run("touch_with_both", target=(0.36, 0.0, 0.85), width=0.2)
    assert result.failed
    assert result.feedback.startswith("right arm touched something: ")
    assert result.states[-1].time < 1.5


@pytest.mark.trials
def test_says_which_hand_comes_no_nearer(rig: Rig) -> None:
    result = rig.run("touch_with_both", target=(1.2, 0.0, 0.9), width=0.2, timeout=15)
    assert result.failed
    assert "hand comes no nearer than" in result.feedback
    assert not result.stops
