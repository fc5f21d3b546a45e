"""What happens besides the tree: stops, refused commands, the scene's script, as lines for people."""

from __future__ import annotations

from typing import NamedTuple

from humanoid_bt.core.messages import TORSO, TOUCHED, Level, Mode, State, touch_text
from humanoid_bt.session.engine import Engine

_HOW_TO_GO_ON = "; waiting for a reset: key r or 'humanoid-bt reset'; q or Ctrl-C ends the run"
_REPEAT = 1.0  # s between two lines about commands that are refused for the same reason


class Happening(NamedTuple):
    """Something that happened: when [s], how bad, and a line of text."""

    time: float
    level: Level
    text: str


class Happenings:
    """Finds what is new since it was asked last.

    Args:
        engine: whose supervisor stops the robot and refuses commands, whose scene shows and hides things.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine, self._supervisor, self._scene = engine, engine.supervisor, engine.scene
        self._touched: set[str] = set()
        self._stops = self._rejected = self._notices = 0
        self._until = 0.0
        self._fault, self._fault_told, self._fault_count = "", -_REPEAT, 0

    def until(self, now: float, waits: bool) -> list[Happening]:
        """Return what happened up to now [s].

        Args:
            now: engine time [s].
            waits: whether the run waits for the reset of an emergency stop.
        """
        end = now + 1e-9  # the scene's script counts up to and without the end
        staged = [Happening(at, "info", f"scene: {text}") for at, text in self._scene.events(self._until, end)]
        self._until = end
        found = [*staged, *self.notices(), *self._refusals(now)]
        for stop in self._supervisor.stops.since(self._stops):
            how = _HOW_TO_GO_ON if waits and stop.mode is Mode.EMERGENCY_STOP else ""
            text = f"{stop.mode.value.replace('_', ' ')}: {stop.reason} ({stop.source}){how}"
            found.append(Happening(stop.time, "error", text))
        self._stops = self._supervisor.stops.total
        return found

    def notices(self) -> list[Happening]:
        """Return what the engine has to say."""
        new = self._engine.notices.since(self._notices)
        self._notices = self._engine.notices.total
        return [Happening(notice.time, notice.level, notice.text) for notice in new]

    def touches(self, state: State) -> list[Happening]:
        """Return what begins to touch the robot, or ends to, harder than is expected: a torso, an arm that yields."""
        found: list[Happening] = []
        if not (state.contacts or self._touched):
            return found
        for group in TOUCHED:
            contact = state.contacts.get(group)
            touched = contact is not None and (contact.yields or group == TORSO)
            if contact is not None and touched and group not in self._touched:
                self._touched.add(group)
                more = "; the arm yields" if contact.yields else ""
                found.append(Happening(state.time, "warning", f"{touch_text(group, contact)}{more}"))
            elif not touched and group in self._touched:
                self._touched.discard(group)
                text = f"nothing touches the {group.replace('_', ' ')} any more"
                found.append(Happening(state.time, "info", text))
        return found

    def _refusals(self, now: float) -> list[Happening]:
        """Return refused commands and setpoints; one line a second while the reason stays the same."""
        found: list[Happening] = []
        for text in self._supervisor.rejected.since(self._rejected):
            head, _, fault = text.partition(": ")
            if fault != self._fault:
                self._fault, self._fault_told, self._fault_count = fault, now, 0
                what = "setpoint" if head.startswith("setpoint ") else "command"
                found.append(Happening(now, "warning", f"refused a {what}: {fault}"))
            else:
                self._fault_count += 1
        self._rejected = self._supervisor.rejected.total
        if self._fault_count and now - self._fault_told >= _REPEAT:
            found.append(Happening(now, "warning", f"refused {self._fault_count} more: {self._fault}"))
            self._fault_told, self._fault_count = now, 0
        return found
