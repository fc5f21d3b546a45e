"""The perception process as decision sees it: whether it lives, and begun anew without a source that holds it up.

What a source calls may keep Python's lock and never come back. Then no other thread of the process gets its turn, not
even the one that would switch the source off: so it is decision that notices.
"""

from __future__ import annotations

from collections.abc import Sequence

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.link.ring import RingReader
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.perception.choice import Chosen, labels
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.children import Children

ROLE = "perception"
_MODULE = "humanoid_bt.realtime.perception_process"
_PATIENCE = 3.0  # s of silence at least: it may only be starved, or stand still with the machine
_MORE = 1.0  # s beyond the patience that a source asks for, in which perception may switch it off by itself


class PerceptionLife:
    """Looks after the perception process, once per tick.

    Args:
        folder: of the run; signs of the sources are made there.
        children: the processes of the run.
        chosen: the sources.
        percepts: what the process writes, also when there is nothing to see.

    Attributes:
        ended: how it ended, if that was not meant; "" while it is there.
    """

    def __init__(self, folder: RunFolder, children: Children, chosen: Sequence[Chosen], percepts: RingReader) -> None:
        channels.create_source_signs(folder, len(chosen))
        self._folder, self._children, self._percepts = folder, children, percepts
        self._signs = channels.source_signs(folder, len(chosen))
        self._labels = labels(chosen)
        self._patience = [max(one.cls.patience + _MORE, _PATIENCE) for one in chosen]
        self._off: dict[str, str] = {}
        self._heard, self._silent = 0, 0
        self._spoke = self._killed = False
        self.ended = ""

    def start(self) -> None:
        """Start the process; raises as :meth:`Children.start`."""
        self._children.start(ROLE, _MODULE)
        self._spoke = self._killed = False

    @property
    def at_work(self) -> list[str]:
        """The sources that are at work now."""
        return [self._labels[number] for number in self._at_work()]

    def look(self) -> str:
        """Return what happened to it since the last look, "" for nothing; start it again if it was held up."""
        if self.ended:
            return ""
        if how := self._children.how_ended(ROLE):
            if self._killed:
                self.start()
                return ""
            self.ended = f"the perception process ended ({how})"
            return self.ended
        heard = self._percepts.sequence
        self._silent = 0 if heard != self._heard else self._silent + 1  # in looks: who looks may stand still
        self._spoke, self._heard = self._spoke or heard != self._heard, heard
        holding = self._at_work()
        if not holding or not self._spoke or self._killed:
            return ""
        if self._silent * DECISION_PERIOD <= max(self._patience[number] for number in holding):
            return ""
        return self._begin_without(holding)

    def close(self) -> None:
        """Let go of the signs."""
        for sign in self._signs:
            sign.close()

    def _at_work(self) -> list[int]:
        return [number for number, sign in enumerate(self._signs) if sign.count % 2 and not self._is_off(number)]

    def _is_off(self, number: int) -> bool:
        return self._labels[number] in self._off

    def _begin_without(self, holding: Sequence[int]) -> str:
        """End the process, to start it again without some sources; return what is to be told."""
        names = [repr(self._labels[number]) for number in holding]
        several = len(names) > 1
        who = f"sources {' and '.join(names)} are off: one of them" if several else f"source {names[0]} is off: it"
        why = f"held up perception for {self._silent * DECISION_PERIOD:.1f} s"
        self._off |= {self._labels[number]: f"or another {why}" if several else why for number in holding}
        channels.note_off(self._folder, self._off)
        self._children.kill(ROLE)
        self._killed = True
        return f"the percept {who} {why}, which begins anew without {'them' if several else 'it'}"
