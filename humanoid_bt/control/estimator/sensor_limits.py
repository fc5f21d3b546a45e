"""What is usual of sensors that work, by what the robot's file says of their noise."""

from __future__ import annotations

import math
import sys

import numpy as np

from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.clock import ESTIMATE_PERIOD
from humanoid_bt.core.messages import Array, Reading
from humanoid_bt.robot.model import RobotModel

_GYRO_JUMP, _ACCELEROMETER_JUMP, _ORIENTATION_JUMP = 4.0, 25.0, 0.1  # from look to look; walking: 0.5, 4 and 0.01
_WILD = 50.0  # m/s^2 from look to look, more than of feet that land hard
_DRIFT = 0.03  # rad that gyro and orientation disagree in two looks
_SAME, _SAME_NOISES = 0.006, 6.0  # rad, and times its noise, that they may disagree in one look in which one jumps
_SPEEDS, _SLACK = 2.0, 0.03  # times its limit that a joint may be fast, and rad beside that
_BLOWS = 2.0  # times as fast as that it may say it is, unless its angle says so, too: in a blow, light ones do
_TORQUES = 2.0  # times its limit that a drive may say it applies
_NOISES = 10.0  # times its noise that a sensor may change in any case: 7 standard deviations of the difference
_PULLS, _BEARS = 0.1, 10.0  # times the weight that a foot cannot pull, or bear; of a robot that was pushed, 4.5
_STILL = 8  # looks; in one of 14 a foot in the air says the same as in the one before
_FLICKERS = 4.0  # times its resolution that the noise is of a force sensor which hardly ever says the same so often


class SensorLimits:
    """How much sensors change, and how far they disagree, while they work.

    Args:
        robot: the robot.

    Attributes:
        most: that a number changes from look to look.
        least: by more than that it does, in the order of a reading; less than 0 where it may stay the same.
        rates: the largest speeds and torques of joints that nothing strikes, in the order of a reading, shape (2 nj,).
        wild: m/s^2 from look to look, by more than that an accelerometer is doubted at once.
        drift: rad that gyro and orientation disagree in two looks.
        same: rad that they do in one in which one of them jumps, if it is right.
        feet: the least and the most that a foot bears [N], and looks in which it never says the same, shape (3,).
        flickers: which sensors have enough noise for it to be seen when they freeze: those of the IMU, and "joints".
        feels: whether there are force sensors in the feet.
    """

    def __init__(self, robot: RobotModel) -> None:
        sensors, joints, weight = robot.config.sensors, len(robot.joint_names), robot.mass * GRAVITY
        gyro, accelerometer, orientation = sensors.gyro, sensors.accelerometer, sensors.orientation
        encoders, feet = sensors.encoders, sensors.foot_force
        self.most = Reading(joints)
        self.most.values[:] = sys.float_info.max
        self.most.gyro[:] = max(_GYRO_JUMP, _NOISES * gyro.noise)
        self.most.accelerometer[:] = max(_ACCELEROMETER_JUMP, _NOISES * accelerometer.noise)
        self.most.orientation[:] = max(_ORIENTATION_JUMP, _NOISES * orientation.noise) / 2  # of a quaternion's numbers
        fast = _SPEEDS * robot.speed_limit * ESTIMATE_PERIOD + _SLACK
        self.most.joint_position[:] = np.maximum(fast, _NOISES * encoders.noise)
        speeds = _BLOWS * fast / ESTIMATE_PERIOD + _NOISES * encoders.speed_noise
        torques = _TORQUES * robot.torque_limit + _NOISES * (encoders.torque_noise + encoders.torque_bias)
        self.rates: Array = np.concatenate([speeds, torques])
        least = Reading(joints)  # orientation, speeds, torques: they hardly ever say the same twice
        least.values[:] = -1.0
        least.joint_velocity[:] = least.joint_torque[:] = least.orientation[:] = 0.0
        self.least: Array = least.values
        self.wild = max(_WILD, _NOISES * accelerometer.noise)
        self.drift = max(_DRIFT, _NOISES * orientation.noise)
        self.same = max(_SAME, _SAME_NOISES * orientation.noise)
        flickers = {
            "gyro": gyro.noise > gyro.resolution,
            "accelerometer": accelerometer.noise > accelerometer.resolution,
            "orientation": orientation.noise > 0,
            "joints": encoders.torque_noise > 0 and encoders.speed_noise > 0,
        }
        self.flickers = {name for name, does in flickers.items() if does}
        self.feels = feet is not None
        self.feet: Array = np.array([-_PULLS * weight, _BEARS * weight, math.inf])
        if feet is not None:
            self.feet[0] -= _NOISES * (feet.noise + feet.bias)
            if feet.noise > 0 and feet.noise >= _FLICKERS * feet.resolution:
                self.feet[2] = _STILL
