"""Stand and look alive."""

import math
from collections.abc import Mapping
from typing import Any

from humanoid_bt import Skill, Status, of_gaze, param

_FAR, _NEAR = 0.2, 0.5  # rad below the eyes' height that it looks


class Idle(Skill):
    """Stand, breathe, and look around ever wider, far and near; is RUNNING until it is halted."""

    resources = ("gaze", "posture")
    ends = False

    look_around: bool = param(True, doc="Sweep the view from side to side.")
    sweep_period: float = param(9.0, unit="s", above=0, doc="Time of a sweep from side to side and back.")
    breath: float = param(0.005, unit="m", minimum=0, maximum=0.03, doc="Rise and fall of the body.")
    breath_period: float = param(4.0, unit="s", above=0, doc="Time of a breath.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return no gaze unless it is to look around."""
        return of_gaze(cls.resources, values["look_around"])

    def initialise(self) -> None:
        """Begin with a glance ahead."""
        self._since = self.robot.clock.now()

    def update(self) -> Status:
        """Breathe and sweep the view."""
        elapsed = self.robot.clock.now() - self._since
        self.robot.set_height(-self.breath * (1 - math.cos(2 * math.pi * elapsed / self.breath_period)) / 2)
        if not self.look_around:
            return self.running("standing")
        widest = self.robot.config.whole_body.gaze_yaw
        amplitude = min(widest, 0.4 + 0.25 * elapsed)
        yaw = amplitude * math.sin(2 * math.pi * elapsed / self.sweep_period)
        x, y, heading = self.robot.state.stance.tolist()
        # down as it comes back to the middle, where something near would stand below the view
        down = _FAR + (_NEAR - _FAR) * (1 - math.cos(2 * math.pi * elapsed / self.sweep_period)) / 2
        eyes = self.robot.state.gaze_position.item(2)
        ahead, left = math.cos(heading + yaw), math.sin(heading + yaw)
        self.robot.look_at([x + 2 * ahead, y + 2 * left, eyes - 2 * math.tan(down)])
        return self.running("looking around")
