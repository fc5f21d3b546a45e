"""What stopped a robot on the wall clock."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.review.explain import explain

pytestmark = pytest.mark.realtime


def test_a_tick_that_takes_too_long_is_named_with_its_line(play: Callable[..., Path]) -> None:
    found = explain(play("sleepy", duration=0.7, mode="realtime"))
    headline = r"one tick took 0\.[5-9]\d s at ([\d.]+) s in 'sleepy', skills/staged\.py:\d+: "
    told = re.match(headline + r"the robot was stopped at ([\d.]+) s", found.headline)
    assert told, found.headline
    assert found.kind == "slow_tick"
    assert found.node == "sleepy/emergency_stop/sleepy"
    assert 0.05 < float(told[2]) - float(told[1]) < 0.2
