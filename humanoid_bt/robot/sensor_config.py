"""What a robot's sensors are like: noise, bias, resolution, delay."""

from __future__ import annotations

from dataclasses import dataclass

from humanoid_bt.core.params import param


@dataclass(frozen=True, kw_only=True)
class EncoderConfig:
    """The sensors of a joint: its angle, its speed, and the torque that its drive says it applies."""

    noise: float = param(5e-5, minimum=0, unit="rad", doc="Standard deviation of an angle.")
    bias: float = param(5e-4, minimum=0, unit="rad", doc="Standard deviation of what a joint's zero is off.")
    resolution: float = param(1.2e-5, minimum=0, unit="rad", doc="Least step of an angle: 2 pi / 2^19.")
    speed_noise: float = param(0.01, minimum=0, unit="rad/s", doc="Standard deviation of a speed.")
    torque_noise: float = param(0.2, minimum=0, unit="Nm", doc="Standard deviation of a torque.")
    torque_bias: float = param(0.0, minimum=0, unit="Nm", doc="Standard deviation of what a torque is off.")


@dataclass(frozen=True, kw_only=True)
class GyroConfig:
    """The gyroscope of the IMU, after it was calibrated at rest."""

    noise: float = param(2e-3, minimum=0, unit="rad/s", doc="Standard deviation of a sample.")
    bias: float = param(3e-4, minimum=0, unit="rad/s", doc="Standard deviation of what each axis is off.")
    resolution: float = param(1e-4, minimum=0, unit="rad/s", doc="Least step.")


@dataclass(frozen=True, kw_only=True)
class AccelerometerConfig:
    """The accelerometer of the IMU."""

    noise: float = param(0.05, minimum=0, unit="", doc="Standard deviation of a sample [m/s^2].")
    bias: float = param(0.03, minimum=0, unit="", doc="Standard deviation of what each axis is off [m/s^2].")
    resolution: float = param(2e-3, minimum=0, unit="", doc="Least step [m/s^2].")


@dataclass(frozen=True, kw_only=True)
class OrientationConfig:
    """The orientation that the IMU's own filter gives."""

    noise: float = param(1e-3, minimum=0, unit="rad", doc="Standard deviation of each angle.")
    bias: float = param(5e-3, minimum=0, unit="rad", doc="Standard deviation of what roll and pitch are off.")
    drift: float = param(
        3e-4, minimum=0, unit="rad/s", doc="Standard deviation of the speed at which its heading drifts."
    )


@dataclass(frozen=True, kw_only=True)
class FootForceConfig:
    """Sensors in the feet that measure the normal force on them."""

    noise: float = param(2.0, minimum=0, unit="N", doc="Standard deviation.")
    bias: float = param(2.0, minimum=0, unit="N", doc="Standard deviation of what each is off.")
    resolution: float = param(0.5, minimum=0, unit="N", doc="Least step.")


@dataclass(frozen=True, kw_only=True)
class SensorsConfig:
    """What the robot's sensors are like. The defaults are those of good industrial ones."""

    delay: float = param(
        0.002,
        minimum=0,
        maximum=0.05,
        unit="s",
        doc="From what is measured until control has it, to the millisecond.",
    )
    encoders: EncoderConfig = param(EncoderConfig(), doc="Of every joint.")
    gyro: GyroConfig = param(GyroConfig(), doc="Of the base.")
    accelerometer: AccelerometerConfig = param(AccelerometerConfig(), doc="Of the base.")
    orientation: OrientationConfig = param(OrientationConfig(), doc="Of the base.")
    foot_force: FootForceConfig | None = param(None, doc="Force sensors in the feet, if it has any.")
