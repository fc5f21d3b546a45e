"""A network that computes in a thread of its own, so that the servo never waits for it."""

from __future__ import annotations

import os
import queue
import threading
import weakref
from collections.abc import Mapping, Sequence

from humanoid_bt.robot.policy.network import Network, Tensor

PATIENCE = 5.0
"""How long time that stands still does so, on the wall clock [s]."""

_Orders = queue.SimpleQueue[Mapping[str, Tensor] | None]
_Answers = queue.SimpleQueue[list[Tensor] | RuntimeError]


class Inference:
    """Asks a network, and takes its answer once there is one.

    Args:
        network: it.
        outputs: what it is asked for.
        waits: whether time stands still while it computes: :meth:`take` waits for the answer then, up to
            :data:`PATIENCE` once; otherwise never.

    Attributes:
        busy: whether an answer is still to come.
    """

    def __init__(self, network: Network, outputs: Sequence[str], *, waits: bool) -> None:
        self._waits = waits
        self.busy = False
        self._orders: _Orders = queue.SimpleQueue()
        self._answers: _Answers = queue.SimpleQueue()
        work = (network, list(outputs), self._orders, self._answers)
        self._thread = threading.Thread(target=_work, args=work, name="policy", daemon=True)
        self._thread.start()
        weakref.finalize(self, self._orders.put, None)
        self._asked = self._ranked = False

    def ask(self, inputs: Mapping[str, Tensor]) -> None:
        """Ask; what was asked before must have been answered."""
        if not self._asked:
            self._asked = True
            self._rank()
        self.busy = True
        self._orders.put(inputs)

    def take(self) -> list[Tensor] | None:
        """Return the answer, None if there is none yet.

        Raises:
            RuntimeError: it cannot be computed.
        """
        try:
            answer = self._answers.get(timeout=PATIENCE) if self._waits else self._answers.get_nowait()
        except queue.Empty:
            self._waits = False  # one that takes so long does not come: time goes on without it
            return None
        self.busy = False
        if isinstance(answer, RuntimeError):
            raise answer
        return answer

    def give_up(self) -> None:
        """Take its priority away: a network that computes for ever is not to keep others from a processor."""
        if self._ranked:
            self._set_scheduler(os.SCHED_OTHER, 0)
        self._asked = self._ranked = False

    def _rank(self) -> None:
        """Run right below whoever asks, if that one has realtime priority: above all else that keeps a machine busy."""
        if hasattr(os, "sched_getscheduler") and os.sched_getscheduler(0) == os.SCHED_FIFO:
            self._set_scheduler(os.SCHED_FIFO, max(1, os.sched_getparam(0).sched_priority - 1))
            self._ranked = True

    def _set_scheduler(self, policy: int, priority: int) -> None:
        if self._thread.native_id is not None:
            os.sched_setscheduler(self._thread.native_id, policy, os.sched_param(priority))


def _work(network: Network, outputs: list[str], orders: _Orders, answers: _Answers) -> None:
    while (inputs := orders.get()) is not None:
        try:
            answers.put(network.run(outputs, inputs))
        except RuntimeError as error:
            answers.put(error)
