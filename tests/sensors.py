"""Sensors for tests of what is behind them."""

from __future__ import annotations

from dataclasses import replace

from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.sensor_config import (
    AccelerometerConfig,
    EncoderConfig,
    FootForceConfig,
    GyroConfig,
    OrientationConfig,
    SensorsConfig,
)

EXACT = SensorsConfig(
    delay=0.0,
    encoders=EncoderConfig(noise=0, bias=0, resolution=0, speed_noise=0, torque_noise=0),
    gyro=GyroConfig(noise=0, bias=0, resolution=0),
    accelerometer=AccelerometerConfig(noise=0, bias=0, resolution=0),
    orientation=OrientationConfig(noise=0, bias=0, drift=0),
    foot_force=FootForceConfig(noise=0, bias=0, resolution=0),
)
"""Sensors that say at once what is."""


def exact(config: RobotConfig) -> RobotConfig:
    """Return a robot with such sensors."""
    return replace(config, sensors=EXACT)
