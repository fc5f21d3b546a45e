"""Quality of service, from a gateway file to what rclpy takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from humanoid_bt.gateway.file import Qos

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

SENSOR = Qos(reliability="best_effort", durability="volatile", depth=5)
"""Of topics that are listened to: it takes from every publisher, whatever that offers."""

STOP = Qos(reliability="reliable", durability="volatile", depth=10)
"""Of the e-stop: no message may be lost, so its publisher has to be reliable too."""

RELIABLE = Qos(reliability="reliable", durability="volatile", depth=10)
"""Of topics that are published."""

PICTURE = Qos(reliability="reliable", durability="volatile", depth=2)
"""Of the head camera's pictures: who is slow gets the latest."""

LATCHED = Qos(reliability="reliable", durability="transient_local", depth=1)
"""Of what who comes later needs too."""


def profile(given: Qos, default: Qos) -> QoSProfile:
    """Return what rclpy takes, with what a file leaves open from a default."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy  # noqa: PLC0415 (part of the extra)

    qos = given.over(default)
    return QoSProfile(
        depth=qos.depth or 1,
        reliability=ReliabilityPolicy[str(qos.reliability).upper()],
        durability=DurabilityPolicy[str(qos.durability).upper()],
    )
