"""How a review words what it found."""

from __future__ import annotations

import math

import numpy as np
import pytest

from humanoid_bt.core.messages import ArmTarget, BaseTarget, PostureTarget
from humanoid_bt.review.explanation import Explanation
from humanoid_bt.review.replay import Replay
from humanoid_bt.review.words import target


@pytest.mark.parametrize(("heading", "shown"), [(1193.0, "113"), (-190.0, "170"), (15.0, "15")])
def test_a_heading_is_told_within_half_a_turn(heading: float, shown: str) -> None:
    of = BaseTarget(np.array([1.0, 2.0]), math.radians(heading))
    assert target("base", of) == f"base to (1.00, 2.00) m, heading {shown} deg"


def test_what_rounds_to_nothing_has_no_minus() -> None:
    assert target("posture", PostureTarget(-0.0001)) == "posture +0.0 cm"
    assert target("base", BaseTarget(np.array([-0.001, 1.0]), -0.001)) == "base to (0.00, 1.00) m, heading 0 deg"
    assert target("left_hand", ArmTarget({"left_elbow": -0.001})) == "left arm at left_elbow 0 deg"


@pytest.mark.parametrize(("speed", "shown"), [(12.4, "12x"), (0.042, "0.04x"), (0.0, "0x")])
def test_a_replay_that_took_long_is_told_how_slow_it_was(speed: float, shown: str) -> None:
    replayed = Replay("run.rrd", True, None, 3, 0.06, speed, "success", "", "success", "")
    assert f" {shown} real time" in str(replayed)


def test_a_long_name_of_a_row_is_parted_from_its_text() -> None:
    explanation = Explanation("run.rrd", "failed", "it failed", rows=[("node", "walk"), ("position error", "2 m")])
    assert explanation.text().splitlines()[2:] == ["node       walk", "position error 2 m"]
