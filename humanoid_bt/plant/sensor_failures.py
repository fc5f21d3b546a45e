"""How sensors can fail, and which can."""

from __future__ import annotations

from typing import Literal, get_args

SensorFailure = Literal["frozen", "silent", "jumping"]
"""How a sensor can fail: it says the same for ever, nothing (NaN), or anything."""

FAILURES: tuple[SensorFailure, ...] = get_args(SensorFailure)
"""All of them."""

IMU_SENSORS = ("gyro", "accelerometer", "orientation", "imu")
"""The sensors of the IMU, and all three of them."""
