"""E-stops of ROS 2, and what becomes of them."""

from __future__ import annotations

import time
from typing import Any

from humanoid_bt.core.messages import Level
from humanoid_bt.gateway.file import EStopTopic
from humanoid_bt.gateway.inbox import News
from humanoid_bt.gateway.node import Ears
from humanoid_bt.gateway.qos import STOP, profile
from humanoid_bt.gateway.types import interface
from humanoid_bt.link.estop import EStop
from humanoid_bt.link.segment import LinkError

_LOOK = 0.02  # s between two looks whether the topic is silent
SOURCE = "ROS 2"
"""Who raises it, as the reports of a run say."""


class EStopEars:
    """Listens to a topic that stops the robot, and to a service that asks for a reset.

    Args:
        ears: where it listens; nothing else does.
        config: what it listens to.
        estop: an end of the run's e-stop, for this alone.
        news: is told what happens.
    """

    def __init__(self, ears: Ears, config: EStopTopic, estop: EStop, news: News) -> None:
        self._config, self._estop, self._news = config, estop, news
        self._heard, self._silent, self._ever = time.monotonic(), False, False
        ears.listen(config.topic, "std_msgs/Bool", profile(config.qos, STOP), self._hear, self._deaf)
        ears.every(_LOOK, self._look)
        if config.reset:
            ears.serve(config.reset, "std_srvs/Trigger", self._reset)

    @staticmethod
    def check(config: EStopTopic) -> None:
        """Refuse if a type that it needs is not installed; raises UserError."""
        interface("std_msgs/Bool")
        if config.reset:
            interface("std_srvs/Trigger", "srv")

    def _hear(self, message: Any) -> None:
        if message.data:
            self._estop.raise_(SOURCE, f"{self._config.topic} is true")
        self._heard, self._silent, self._ever = time.monotonic(), False, True

    def _deaf(self, why: str) -> None:
        self._estop.raise_(SOURCE, why)

    def _look(self) -> None:
        timeout = self._config.timeout
        if timeout is not None and not self._silent and time.monotonic() - self._heard > timeout:
            self._silent = True
            topic, limit = self._config.topic, f"for more than {timeout:g} s"
            why = f"{topic} has been silent {limit}" if self._ever else f"nobody has been heard yet on {topic}, {limit}"
            self._estop.raise_(SOURCE, why)

    def _reset(self, _request: Any, response: Any) -> Any:
        level: Level = "info"
        try:
            self._estop.request_reset(SOURCE)
            response.success, response.message = True, "asked for: the mode says whether control accepts it"
        except LinkError as error:
            level, response.message = "error", str(error)
        self._news(level, f"{SOURCE} asks for a reset" if response.success else response.message)
        return response
