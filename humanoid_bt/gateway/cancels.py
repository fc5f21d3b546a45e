"""Goals of actions of others that are not wanted any more: canceled, also those that a gateway that died has sent."""

from __future__ import annotations

import time
from typing import Any

from humanoid_bt.gateway.inbox import News
from humanoid_bt.gateway.types import interface

_CANCEL = "action_msgs/CancelGoal"
_PATIENCE = 10.0  # s for a node that offers the action to be found, and to answer
_AGAIN = 1.0  # s without an answer after which it is asked again: a node that was just found may not hear yet
_REFUSED = 1  # action_msgs/CancelGoal; the other codes say that the goal is over or was never there


class Cancels:
    """Cancels goals, each by its identity.

    Args:
        node: of rclpy, which asks for it.
        news: is told of those that cannot be canceled.
    """

    def __init__(self, node: Any, news: News) -> None:
        self._node, self._news = node, news
        self._clients: dict[str, Any] = {}
        self._waiting: list[tuple[str, bytes, float]] = []  # action, goal, when it is given up
        self._asked: list[tuple[str, bytes, float, Any, float]] = []  # the same, future, when it is asked again

    @property
    def waiting(self) -> bool:
        """Whether a goal is not canceled yet."""
        return bool(self._waiting or self._asked)

    def add(self, action: str, goal: bytes) -> None:
        """Cancel a goal of an action as soon as that is there."""
        self._waiting.append((action, goal, time.monotonic() + _PATIENCE))

    def look(self) -> None:
        """Go on with it."""
        waiting, self._waiting = self._waiting, []
        for action, goal, until in waiting:
            if self._client(action).service_is_ready():
                again = time.monotonic() + _AGAIN
                self._asked.append((action, goal, until, self._ask(action, goal), again))
            elif time.monotonic() < until:
                self._waiting.append((action, goal, until))
            else:
                self._news("warning", f"a goal of {action} is not canceled: nobody offers that action any more")
        asked, self._asked = self._asked, []
        for action, goal, until, future, again in asked:
            if future.done():
                if future.result().return_code == _REFUSED:
                    self._news("warning", f"a goal of {action} goes on: its node refuses to cancel it")
            elif time.monotonic() >= until:
                self._news("warning", f"a goal of {action} is not canceled: its node does not answer")
            elif time.monotonic() >= again:
                self._waiting.append((action, goal, until))
            else:
                self._asked.append((action, goal, until, future, again))

    def _ask(self, action: str, goal: bytes) -> Any:
        request = interface(_CANCEL, "srv").Request()
        request.goal_info.goal_id = interface("unique_identifier_msgs/UUID")(uuid=list(goal))
        return self._client(action).call_async(request)

    def _client(self, action: str) -> Any:
        if action not in self._clients:
            kind = interface(_CANCEL, "srv")
            self._clients[action] = self._node.create_client(kind, f"{action}/_action/cancel_goal")
        return self._clients[action]
