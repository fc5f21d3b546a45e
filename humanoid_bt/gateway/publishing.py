"""Publishing what a run says of itself."""

from __future__ import annotations

from typing import Any

from humanoid_bt.gateway.file import GatewayFile, Output
from humanoid_bt.gateway.outputs import KINDS, Kind, text
from humanoid_bt.gateway.pictures import MAKE
from humanoid_bt.gateway.qos import profile
from humanoid_bt.gateway.snapshot import Snapshot
from humanoid_bt.gateway.types import interface
from humanoid_bt.link.wire import SeenPicture


class Publishers:
    """The topics that a gateway file names, each at its rate.

    Args:
        node: of rclpy, which publishes.
        config: the file.

    Raises:
        UserError: a type is not installed.
    """

    def __init__(self, node: Any, config: GatewayFile) -> None:
        self._due: list[_Periodic] = []
        self._others: dict[str, Any] = {}
        self._camera = config.frames.camera
        for name, kind, output in wanted(config):
            topic = output.topic or kind.topic
            publisher = node.create_publisher(interface(kind.type), topic, profile(output.qos, kind.qos))
            if kind.message is None:
                self._others[name] = publisher
            else:
                self._due.append(_Periodic(publisher, kind, 1 / (output.rate or kind.rate)))

    def publish(self, now: Snapshot) -> None:
        """Publish what is due."""
        for one in self._due:
            one.publish(now)

    def tell(self, name: str, values: dict[str, Any]) -> None:
        """Publish something that happened, as JSON, if anybody wants it."""
        if (publisher := self._others.get(name)) is not None:
            publisher.publish(text(interface, values))

    def latch(self, name: str, data: str) -> None:
        """Publish a text for everybody who comes later, too."""
        if (publisher := self._others.get(name)) is not None:
            publisher.publish(interface("std_msgs/String")(data=data))

    def show(self, picture: SeenPicture, stamp: float) -> None:
        """Publish what the head camera sees, with a stamp in ROS time [s]."""
        for name, make in MAKE.items():
            if (publisher := self._others.get(name)) is not None:
                publisher.publish(make(interface, picture, stamp, self._camera))


class _Periodic:
    """A topic that is published with a period, in engine time [s]."""

    def __init__(self, publisher: Any, kind: Kind, period: float) -> None:
        self._publisher, self._kind, self._period = publisher, kind, period
        self._next = 0.0

    def publish(self, now: Snapshot) -> None:
        time = now.state.time
        if self._kind.message is not None and time >= self._next - 1e-9:
            self._next = max(self._next + self._period, time)
            self._publisher.publish(self._kind.message(interface, now))


def wants_pictures(config: GatewayFile) -> bool:
    """Return whether a file wants what the head camera sees to be published."""
    return any(name in MAKE for name, *_ in wanted(config))


def wanted(config: GatewayFile) -> list[tuple[str, Kind, Output]]:
    """Return what a file wants to be published: its key, what that is, and how."""
    given = {name: getattr(config.publish, name) for name in KINDS}
    return [(name, KINDS[name], output) for name, output in given.items() if output is not None]
