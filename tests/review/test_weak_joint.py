"""Which joint gave way before a fall, seen in the numbers of the servo cycles."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.record.reading import Cycles
from humanoid_bt.review.weak_joint import gave_way

JOINTS = ["left_ankle", "right_ankle", "left_elbow"]


def recorded(torque: float, off: float, joint: str) -> Any:
    """Return a recording of 10 s in which a joint gives so much torque [Nm] so far off its setpoint [rad] from 1 s on.

    It is so for a tenth of each second, as in the swing of a step.
    """
    time = np.arange(10_000) * 1e-3
    late, swings = time > 1.0, (time % 1.0) < 0.1
    position, given = np.zeros((10_000, 3)), np.full((10_000, 3), 20.0)
    position[late & swings, JOINTS.index(joint)] = off
    given[late, JOINTS.index(joint)] = torque
    columns = {"position": position, "torque": given, "setpoint": np.zeros((10_000, 3))}

    def cycles(_kind: str, begin: float, end: float, names: list[str], labels: list[str] | None = None) -> Cycles:
        rows = (time >= begin) & (time <= end)
        places = [JOINTS.index(label) for label in labels or JOINTS]
        return Cycles(time[rows], {name: columns[name][rows][:, places] for name in names}, {}, 0)

    robot = {"joints": JOINTS, "limits": {"torque": [50.0, 50.0, 50.0]}, "arms": {"left_hand": ["left_elbow"]}}
    return SimpleNamespace(setup={"robot": robot}, cycles=cycles)


def test_a_joint_that_was_dead_for_long_is_named() -> None:
    found = gave_way(recorded(0.5, 0.2, "left_ankle"), 5.0, 9.5, 9.9)
    assert found is not None
    assert found.what == "left_ankle gave next to no torque from 1.00 s on"
    assert str(found) == "left_ankle up to 11 deg off its setpoint, 1.00 to 9.50 s, with at most 0.5 of 50 Nm"


@pytest.mark.parametrize(
    ("torque", "off", "joint"),
    [
        (0.5, 0.05, "left_ankle"),  # where it shall be, nothing is asked of it
        (5.0, 0.2, "left_ankle"),  # it does something about it
        (0.5, 0.2, "left_elbow"),  # no robot falls by that
    ],
)
def test_a_joint_that_bears_little_is_not_blamed(torque: float, off: float, joint: str) -> None:
    assert gave_way(recorded(torque, off, joint), 5.0, 9.5, 9.9) is None


@pytest.mark.parametrize(("lost", "late"), [(1.0, False), (0.8, True)])
def test_a_joint_that_gave_way_after_balance_was_lost_is_late(lost: float, late: bool) -> None:
    found = gave_way(recorded(50.0, 0.0, "left_ankle"), 0.0, lost, 9.9)
    assert found is not None
    assert (found.what, found.late) == ("left_ankle was at its torque limit at 1.00 s", late)
