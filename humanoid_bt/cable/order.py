"""The order of what comes over a cable: nothing old, nothing twice, and a clock that agrees with the count."""

from __future__ import annotations

from humanoid_bt.core.clock import SERVO_PERIOD

_LONGEST_GAP = 5000  # servo cycles that may be missing: more is no loss, but another sender
_CLOCK_JUMP = 0.1  # s by which a sender's time may run away from its count between two frames


class Order:
    """Judges the frames of one sender, each of which counts its servo cycles.

    Attributes:
        lost: frames that have not come.
        late: frames that came after a later one, or twice.
    """

    def __init__(self) -> None:
        self._sequence: int | None = None
        self._stamp = 0.0
        self.lost = self.late = 0

    def fault(self, sequence: int, stamp: float) -> str:
        """Return why a frame does not count, "" if it does.

        Args:
            sequence: of the frame.
            stamp: the sender's time [s].
        """
        if self._sequence is None:
            self._sequence, self._stamp = sequence, stamp
            return ""
        ahead, passed = sequence - self._sequence, stamp - self._stamp
        if ahead <= 0:
            self.late += 1
            self.lost -= ahead < 0 < self.lost  # it was counted when a later one came
            return f"out of order: {sequence} after {self._sequence}"
        if ahead > _LONGEST_GAP:
            return f"its count jumped from {self._sequence} to {sequence}"
        if abs(passed - ahead * SERVO_PERIOD) > _CLOCK_JUMP:
            return f"its clock jumped by {passed:.3g} s in {ahead} ms"
        self.lost += ahead - 1
        self._sequence, self._stamp = sequence, stamp
        return ""
