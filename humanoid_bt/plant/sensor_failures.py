"""How sensors can fail, and which can."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from humanoid_bt.core.messages import SIDES
from humanoid_bt.robot.sensor_config import SensorsConfig

SensorFailure = Literal["frozen", "silent", "jumping"]
"""How a sensor can fail: it says the same for ever, nothing (NaN), or anything."""

FAILURES: tuple[SensorFailure, ...] = get_args(SensorFailure)
"""All of them."""

IMU_SENSORS = ("gyro", "accelerometer", "orientation", "imu")
"""The sensors of the IMU, and all three of them."""

FOOT_SENSORS = tuple(f"{side}_foot" for side in SIDES)
"""The force sensors in the feet, of a robot that has them."""


def sensors_of(config: SensorsConfig, joints: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a robot's sensors."""
    return (*IMU_SENSORS, *(FOOT_SENSORS if config.foot_force else ()), *joints)
