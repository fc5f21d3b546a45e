"""Walk up to something seen."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from humanoid_bt import Gait, PerceptName, Skill, Status, of_gaze, param, result


class Approach(Skill):
    """Walk until the target is straight ahead at a distance.

    Succeeds once the robot stands there; follows a target that moves. Fails if the target was never seen.
    """

    resources = ("base", "gaze")
    bounded = False  # the target may move on and on

    target: PerceptName = param(doc="Percept to walk up to.")
    distance: float | None = param(
        None, unit="m", above=0, doc="Stop with the target this far ahead; default: within the robot's reach."
    )
    tolerance: float = param(0.06, unit="m", above=0, doc="Arrived when this close to the place to stand at.")
    angle_tolerance: float = param(0.12, unit="rad", above=0, doc="Arrived when the target is ahead to this angle.")
    look: bool = param(True, doc="Look at the target, too.")

    target_distance: float = result(unit="m", doc="From the middle between the feet to the target, seen from above.")
    bearing_error: float = result(unit="rad", doc="From straight ahead to the target; left is positive.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return no gaze unless it is to look."""
        return of_gaze(cls.resources, values["look"])

    def initialise(self) -> None:
        """Forget the last goal."""
        self._goal: np.ndarray | None = None

    def update(self) -> Status:
        """Walk toward the place from which the target is straight ahead."""
        track = self.robot.track(self.target)
        if track is None:
            return self.fail(self.robot.why_unseen(self.target))
        stop_at = self.robot.config.reach_distance if self.distance is None else self.distance
        stance = self.robot.state.stance
        to_target = track.position_world[:2] - stance[:2]
        heading = math.atan2(to_target[1], to_target[0])
        goal = track.position_world[:2] - stop_at * np.array([math.cos(heading), math.sin(heading)])
        self._goal = self._steady(goal, math.dist(goal, stance[:2]))

        self.target_distance, self.bearing_error = track.distance, track.bearing
        to_go = math.dist(self._goal, stance[:2])
        arrived = to_go < self.tolerance and abs(track.bearing) < self.angle_tolerance
        if arrived and self.robot.state.base_settled:
            return self.succeed(f"{track.distance:.2f} m from {self.target}")
        if self.look:
            self.robot.look_at(track.position_world)
        if arrived and self.robot.state.gait is Gait.STAND:
            return self.running("coming to rest")
        self.robot.walk_to(self._goal, heading)
        return self.running(f"{to_go:.2f} m to go to {self.target}")

    def _steady(self, goal: np.ndarray, to_go: float) -> np.ndarray:
        """Keep the last goal while the new one differs by noise only, which grows with the way left."""
        if self._goal is not None and math.dist(goal, self._goal) < 0.02 + 0.1 * to_go:
            return self._goal
        return goal
