"""Tests of one skill, each on a simulated robot that sees what the test says."""

import numpy as np
import pytest


@pytest.mark.parametrize(("ball", "hand"), [((1.2, 0.4, 0.9), "left"), ((1.2, -0.4, 0.7), "right")])
def test_the_palm_is_on_the_way_from_the_chest_to_what_it_points_at(rig, ball, hand):
    result = rig.run("stretch_toward", target=ball)
    assert result.succeeded, result.feedback
    x, y, height = result.states[-1].hands[hand]
    assert np.arctan2(y, x) == pytest.approx(np.arctan2(ball[1], ball[0]), abs=0.1)
    assert height == pytest.approx(0.9, abs=0.1)
    assert not result.stops


def test_it_says_why_it_cannot_stretch_toward_what_it_never_saw(rig):
    result = rig.run("stretch_toward", target="ball")
    assert result.failed
    assert "'ball' was never seen" in result.feedback


def test_it_takes_the_hand_down_when_it_is_halted(rig):
    rig.run("stretch_toward", target=(1.2, 0.4, 0.9), timeout=1.0)
    assert rig.settle().hands["left"][2] < 0.6


def test_it_keeps_what_every_skill_promises(rig):
    rig.check_skill("stretch_toward", target=(1.2, 0.4, 0.9)).assert_passed()
