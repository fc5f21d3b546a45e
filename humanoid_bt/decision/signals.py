"""What skills need to judge what they see and measure: is it steady, does it last, does it improve.

Time is always given, from the engine's clock; nothing here reads one.
"""

from __future__ import annotations

import math

from humanoid_bt.core.messages import Array

_MOVED_ON = 5  # steps by which an error has grown where something has moved on; more than the noise
_TRIES = 5  # to keep something up; what moves now and then lets some of them fail
_ROUNDING = 1e-9  # s


class Steady:
    """A position without its noise: low-passed once per observation, but followed at once where it really moves.

    Args:
        time: of the low-pass [s].
        jump: what is farther away than this has moved [m]; more than the noise.
    """

    def __init__(self, time: float, jump: float = 0.04) -> None:
        self._time, self._jump = time, jump
        self._position: Array | None = None
        self._stamp = -math.inf

    def update(self, position: Array, stamp: float) -> Array:
        """Return the steady position, a copy of it.

        Args:
            position: observed, shape (3,) [m].
            stamp: when it was observed [s]; the same observation may be given many times.
        """
        if self._position is None or math.sqrt((step := position - self._position) @ step) > self._jump:
            self._position = position.copy()
        elif stamp > self._stamp:
            elapsed = stamp - self._stamp
            self._position = self._position + step * (elapsed / (elapsed + self._time))
        self._stamp = max(self._stamp, stamp)
        return self._position.copy()


class Lasting:
    """Whether something has been true without a break for a time.

    Args:
        duration: that time [s]; 0 is at once.
        patience: how long it may take to come true again after a break [s].

    Attributes:
        hopeless: whether it was true, and has not been for long enough in five times the duration and the patience
            since then.
    """

    def __init__(self, duration: float, patience: float = math.inf) -> None:
        self._duration = duration
        self._longest = _TRIES * (duration + patience)
        self._since: float | None = None
        self._first = math.inf  # when it was true first [s]
        self.hopeless = False

    def update(self, holds: bool, now: float) -> bool:
        """Note whether it is true now, and return whether it has been for long enough."""
        if holds:
            self._first = min(self._first, now)
        self.hopeless = now - self._first > self._longest
        if not holds:
            self._since = None
            return False
        if self._since is None:
            self._since = now
        return now - self._since >= self._duration - _ROUNDING


class Improving:
    """Whether an error still becomes smaller.

    Args:
        patience: how long it may not [s].
        step: what counts as smaller, in the error's unit.

    Attributes:
        best: the smallest error that counted.
    """

    def __init__(self, patience: float, step: float) -> None:
        self._patience, self._step = patience, step
        self.restart()

    def restart(self) -> None:
        """Forget the errors so far, as when another way begins."""
        self.best, self._waited = math.inf, math.inf
        self._last: float | None = None  # time of the last error [s]
        self._arrived = False

    def arrived(self, error: float) -> None:
        """Note an error that is small enough: until the next one that is not, no time counts.

        One that is much larger later, as of something that has moved on, may become smaller anew.
        """
        self.best, self._arrived, self._last = error, True, None

    def update(self, error: float, now: float) -> bool:
        """Note an error; return False once none has been smaller than the best for longer than the patience."""
        if error < self.best - self._step or (self._arrived and error > self.best + _MOVED_ON * self._step):
            self.best, self._waited, self._arrived = error, 0.0, False
        elif self._last is not None:
            self._waited += now - self._last
        self._last = now
        return self._waited <= self._patience + _ROUNDING
