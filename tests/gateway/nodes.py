"""A node of ROS 2 for tests, in the test's own process; and one in a process of its own, to be killed."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from humanoid_bt.gateway.file import Qos
from humanoid_bt.gateway.qos import profile
from tests.realtime.helpers import environment, until

BALL = (1.9, 0.5, 0.85)
"""Where the ball of the scene ball_on_stand is, in the engine's world [m]."""

_RELIABLE = Qos(reliability="reliable", durability="volatile", depth=100)


@contextmanager
def punctual() -> Iterator[None]:
    """Let no thread of this process wait for a busy machine, if that is allowed."""
    threads = [int(thread.name) for thread in Path("/proc/self/task").iterdir()]
    before = [(os.sched_getscheduler(thread), os.sched_getparam(thread)) for thread in threads]
    try:
        for thread in threads:
            os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(1))
    except PermissionError:
        yield
        return
    try:
        yield
    finally:
        for thread, (policy, parameters) in zip(threads, before, strict=True):
            with suppress(ProcessLookupError):
                os.sched_setscheduler(thread, policy, parameters)


class Peer:
    """A node that hears in a thread of its own, and keeps what it hears."""

    def __init__(self, context: Any) -> None:
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        self.node = Node("peer", context=context)
        self.heard: dict[str, list[Any]] = {}
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._over = False
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        while not self._over:
            self._executor.spin_once(timeout_sec=0.05)

    def hears(self, kind: Any, topic: str, qos: Qos = _RELIABLE) -> None:
        heard = self.heard[topic] = []
        self.node.create_subscription(kind, topic, heard.append, profile(qos, _RELIABLE))

    def publisher(self, kind: Any, topic: str, qos: Qos = _RELIABLE, *, heard: bool = True) -> Any:
        """Return a publisher; wait until it has a listener."""
        publisher = self.node.create_publisher(kind, topic, profile(qos, _RELIABLE))
        if heard:
            until(f"somebody listens to {topic}", lambda: publisher.get_subscription_count() > 0)
        return publisher

    def client(self, kind: Any, service: str) -> Any:
        client = self.node.create_client(kind, service)
        until(f"the service {service}", client.service_is_ready)
        return client

    def action_client(self, kind: Any, action: str) -> Any:
        """Return a client of an action once its server has found it: what it answers before is lost."""
        from action_msgs.srv import CancelGoal
        from rclpy.action import ActionClient

        client = ActionClient(self.node, kind, action)
        until(f"the action {action}", client.server_is_ready)
        later = self.client(CancelGoal, f"{action}/_action/cancel_goal")  # and so found later, by the same server
        nothing = CancelGoal.Request()
        nothing.goal_info.goal_id.uuid[:] = 1  # of no goal
        asked: list[Any] = []

        def answers() -> bool:
            asked.append(later.call_async(nothing))
            return any(future.done() for future in asked)

        until(f"an answer of the action {action}", answers)
        self.node.destroy_client(later)
        return client

    def close(self) -> None:
        self._over = True
        self._thread.join()
        self._executor.shutdown()
        self.node.destroy_node()


@contextmanager
def ball(detector: str = "tests.gateway.ball") -> Iterator[subprocess.Popen[bytes]]:
    """A node in a process of its own that publishes where the ball is, 20 times a second or more."""
    process = subprocess.Popen([sys.executable, "-m", detector, *map(str, BALL)], env=environment())
    try:
        yield process
    finally:
        process.kill()
        process.wait()
