"""Walk to a place."""

import math

import numpy as np

from humanoid_bt import Gait, Improving, Skill, Status, param, result


class WalkTo(Skill):
    """Walk to a place on the floor and stand there.

    The way is straight, without regard to what stands in it. Fails if the robot comes no nearer.
    """

    resources = ("base",)
    bounded = True  # by its patience

    x: float = param(unit="m", doc="Where to stand, in the world.")
    y: float = param(unit="m", doc="Where to stand, in the world.")
    heading: float | None = param(
        None, unit="rad", doc="Where to face; 0 is the world's x, left is positive. Default: as it arrives."
    )
    tolerance: float = param(0.06, unit="m", above=0, doc="Arrived when this close.")
    angle_tolerance: float = param(0.12, unit="rad", above=0, doc="Arrived when turned this close.")
    patience: float = param(5.0, unit="s", above=0, doc="Fails when it comes no nearer for this long.")

    position_error: float = result(unit="m", doc="From where it stands to the place.")
    heading_error: float = result(unit="rad", doc="From where it faces to where it is to face; left is positive.")

    def initialise(self) -> None:
        """Choose where to face, once, for the direction to a place that is near means little."""
        gait, stance = self.robot.config.gait, self.robot.state.stance
        self._goal = np.array([self.x, self.y])
        offset = self._goal - stance[:2]
        if self.heading is not None:
            self._heading = self.heading
        elif np.linalg.norm(offset) > gait.near:
            self._heading = math.atan2(offset[1], offset[0])
        else:
            self._heading = float(stance[2])
        self._steps = Improving(self.patience, step=0.2)

    def update(self) -> Status:
        """Walk toward the place."""
        state = self.robot.state
        offset = self._goal - state.stance[:2]
        self.position_error = to_go = float(np.linalg.norm(offset))
        self.heading_error = turn = math.remainder(self._heading - state.stance[2], math.tau)
        there = to_go < self.tolerance and abs(turn) < self.angle_tolerance
        if there and state.base_settled:
            return self.succeed(f"{to_go * 100:.0f} cm from ({self.x:g}, {self.y:g})")
        if there and state.gait is Gait.STAND:
            return self.running("coming to rest")
        self.robot.walk_to(self._goal, self._heading)
        if not self._steps.update(self._steps_left(offset), self.robot.clock.now()):
            return self.fail(f"comes no nearer: {to_go:.2f} m and {math.degrees(abs(turn)):.0f} deg to go")
        return self.running(f"{to_go:.2f} m and {math.degrees(abs(turn)):.0f} deg to go")

    def _steps_left(self, offset: np.ndarray) -> float:
        """Return about how many steps are left: a robot that first turns round comes nearer, too."""
        gait, facing = self.robot.config.gait, float(self.robot.state.stance[2])
        way, turns = float(np.linalg.norm(offset)), [self._heading - facing]
        if way > gait.near:  # it turns to the place, walks there, and turns to the heading
            direction = math.atan2(offset[1], offset[0])
            turns = [direction - facing, self._heading - direction]
        return way / gait.step_forward + sum(abs(math.remainder(turn, math.tau)) for turn in turns) / gait.step_turn
