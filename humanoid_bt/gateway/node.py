"""A node of ROS 2 that listens in a thread of its own."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from humanoid_bt.gateway.inbox import News
from humanoid_bt.gateway.types import interface

if TYPE_CHECKING:
    from rclpy.context import Context
    from rclpy.qos import QoSProfile

_PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")  # new and old name
_TURN = 0.05  # s between two signs of life of the thread
_STUCK = 1.0  # s without one after which it counts as stuck


def confine(network: str) -> None:
    """Have only nodes of this machine found and heard, unless ROS 2's own variables decide; before rclpy begins.

    The range alone keeps Fast DDS from looking for others, but not from listening on every interface: the profile does,
    unless there is one of the user's own.
    """
    if network == "loopback":
        if not any(name in os.environ for name in _PROFILES):
            os.environ[_PROFILES[0]] = str(Path(__file__).with_name("loopback.xml"))
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        os.environ.pop("ROS_STATIC_PEERS", None)


class Ears:
    """A node, and a thread that hears for it.

    Args:
        context: of rclpy.
        name: of the node.
        news: is told of publishers whose quality of service does not fit.
        parameters: whether others see, and may set, what the node has declared as its parameters.
    """

    def __init__(self, context: Context, name: str, news: News, *, parameters: bool = False) -> None:
        from rclpy.executors import SingleThreadedExecutor  # noqa: PLC0415 (part of the extra)
        from rclpy.node import Node  # noqa: PLC0415 (likewise)

        self.node = Node(name, context=context, start_parameter_services=parameters, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._news = news
        self._alive = time.monotonic()
        self._failed: BaseException | None = None
        self._over = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self.every(_TURN, self._live)

    def listen(
        self,
        topic: str,
        kind: str,
        qos: QoSProfile,
        hear: Callable[[Any], None],
        deaf: Callable[[str], None] | None = None,
    ) -> None:
        """Have messages of a topic heard.

        Args:
            topic: its name.
            kind: its type.
            qos: its quality of service.
            hear: is given every message.
            deaf: is told why a publisher cannot be heard, besides the news.
        """
        from rclpy.event_handler import SubscriptionEventCallbacks  # noqa: PLC0415 (part of the extra)
        from rclpy.qos import qos_policy_name_from_kind  # noqa: PLC0415 (likewise)

        def tell(why: str) -> None:
            text = f"a publisher of {topic} is not heard: {why}"
            self._news("error", text)
            if deaf is not None:
                deaf(text)

        def unfit(event: Any) -> None:
            tell(f"its {qos_policy_name_from_kind(event.last_policy_kind).lower()} does not fit")

        events = SubscriptionEventCallbacks(
            incompatible_qos=unfit, incompatible_type=lambda _event: tell(f"its type is not {kind}")
        )
        self.node.create_subscription(interface(kind), topic, hear, qos, event_callbacks=events)

    def serve(self, service: str, kind: str, answer: Callable[[Any, Any], Any]) -> None:
        """Have a service answered."""
        self.node.create_service(interface(kind, "srv"), service, answer)

    def every(self, period: float, do: Callable[[], None]) -> None:
        """Have something done again and again, with a period [s]."""
        from rclpy.clock import Clock, ClockType  # noqa: PLC0415 (part of the extra)

        self.node.create_timer(period, do, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def future(self) -> Any:
        """Return what a coroutine of the node can wait for, and any thread can fulfil."""
        from rclpy.task import Future  # noqa: PLC0415 (part of the extra)

        return Future(executor=self._executor)

    def begin(self) -> None:
        """Hear from now on."""
        self._thread.start()

    def check(self) -> None:
        """Refuse to go on with a thread that does not hear any more.

        Raises:
            RuntimeError: it has failed, or is stuck.
        """
        if self._failed is not None:
            raise RuntimeError(f"{self._thread.name} failed: {self._failed!r}") from self._failed
        if time.monotonic() - self._alive > _STUCK:
            raise RuntimeError(f"{self._thread.name} has been stuck for more than {_STUCK:g} s")

    def end(self) -> None:
        """Hear no more."""
        self._over = True
        self._thread.join(_STUCK)
        self._executor.shutdown(timeout_sec=_STUCK)
        self.node.destroy_node()

    def _live(self) -> None:
        self._alive = time.monotonic()

    def _run(self) -> None:
        try:
            while not self._over:
                self._executor.spin_once(timeout_sec=_TURN)
        except BaseException as error:
            if not self._over:
                self._failed = error
