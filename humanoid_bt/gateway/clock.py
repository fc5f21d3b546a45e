"""The engine's clock beside ROS time."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

_WINDOW = 50  # looks, 1 s of them: in one of these the state was just out
_JUMP = 0.05  # s by which ROS time must leave the monotonic clock at once to have jumped


class EngineClock:
    """Translates stamps between ROS time and engine time.

    Engine time is the number of servo cycles, which falls behind the wall clock when control is late; ROS time is a
    wall clock, which somebody may set. Both are compared with the monotonic clock, which does neither.

    Args:
        ros_now: returns ROS time [s].
        monotonic: returns the monotonic clock [s].
    """

    def __init__(self, ros_now: Callable[[], float], monotonic: Callable[[], float] = time.monotonic) -> None:
        self._ros_now, self._monotonic = ros_now, monotonic
        self._looks: deque[float] = deque(maxlen=_WINDOW)  # monotonic clock less engine time
        self._ahead = 0.0  # the least of them: of the look with the newest state
        self._ros_ahead = ros_now() - monotonic()
        self.engine_time = 0.0

    def look(self, engine_time: float) -> float:
        """Take the engine time of the latest state [s]; return by how much ROS time has jumped since the last look."""
        now = self._monotonic()
        if engine_time > self.engine_time or not self._looks:
            self._looks.append(now - engine_time)
            self._ahead, self.engine_time = min(self._looks), engine_time
        ros_ahead = self._ros_now() - now
        jump = ros_ahead - self._ros_ahead
        self._ros_ahead = ros_ahead  # a clock that is slewed goes on from where it is
        return jump if abs(jump) > _JUMP else 0.0

    @property
    def offset(self) -> float:
        """What is to be added to engine time to get ROS time [s]."""
        return self._ros_ahead + self._ahead

    def engine(self, stamp: float) -> float:
        """Return a ROS stamp as engine time [s]."""
        return stamp - self.offset

    def ros(self, engine_time: float) -> float:
        """Return an engine time as ROS time [s]."""
        return engine_time + self.offset

    def now(self) -> float:
        """Return engine time now [s], as far as it can be told between two states."""
        return self.engine(self._ros_now())
