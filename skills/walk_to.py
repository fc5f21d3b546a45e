"""Walk to a place."""

import math

import numpy as np

from humanoid_bt import Gait, Improving, PerceptName, Route, Skill, Status, param, result

_DETOURS = 20  # longer ways than the one before that it takes
_LONGER = 2.0  # steps that such a way has more
_NEARER = 0.2  # steps that count as nearer
_COMES_TO_REST = 3.0  # times the patience that it has to come to rest from when it is there first: it may step on


class WalkTo(Skill):
    """Walk to a place on the floor, round everything solid that was seen, and stand there.

    Waits while something moves in its way, or is about to, also for a moment when that has left the view, and steps
    aside from what comes to where it waits. Fails if that does not get out of the way, if there is no way, or if the
    robot comes no nearer, and says what is in the way.
    """

    resources = ("base",)
    bounded = True  # by its patience
    remembered = ("obstacles",)

    x: float = param(unit="m", minimum=-1000, maximum=1000, doc="Where to stand, in the world.")
    y: float = param(unit="m", minimum=-1000, maximum=1000, doc="Where to stand, in the world.")
    heading: float | None = param(
        None, unit="rad", doc="Where to face; 0 is the world's x, left is positive. Default: as the straight way there."
    )
    tolerance: float = param(0.06, unit="m", above=0, doc="Arrived when this close.")
    angle_tolerance: float = param(0.12, unit="rad", above=0, doc="Arrived when turned this close.")
    clearance: float = param(0.08, unit="m", minimum=0, doc="Keep this far from obstacles, if there is so much room.")
    obstacles: list[PerceptName] = param([], doc="Percepts to go round, too, besides what is solid.")
    patience: float = param(5.0, unit="s", above=0, doc="Fails when it comes no nearer, or has to wait, for this long.")

    position_error: float = result(unit="m", doc="From where it stands to the place.")
    heading_error: float = result(unit="rad", doc="From where it faces to where it is to face; left is positive.")

    def initialise(self) -> None:
        """Choose where to face, once, for the direction to a place that is near means little."""
        gait, stance = self.robot.config.gait, self.robot.state.stance
        self._goal, self._where = np.array([self.x, self.y]), f"({self.x:g}, {self.y:g})"
        offset = self._goal - stance[:2]
        if self.heading is not None:
            self._heading = self.heading
        elif np.linalg.norm(offset) > gait.near:
            self._heading = math.atan2(offset[1], offset[0])
        else:
            self._heading = float(stance[2])
        self._way, self._turns = (Improving(self.patience, step=_NEARER) for _ in range(2))
        self._route = Route(self.robot, self.clearance, self.obstacles, self.patience)
        self._left, self._detours = math.inf, 0
        self._came = math.inf  # when it was there first [s]

    def update(self) -> Status:
        """Walk toward the place."""
        state = self.robot.state
        offset = self._goal - state.stance[:2]
        self.position_error = to_go = float(np.linalg.norm(offset))
        self.heading_error = turn = math.remainder(self._heading - state.stance[2], math.tau)
        there = to_go < self.tolerance and abs(turn) < self.angle_tolerance
        if there:
            self._came = min(self._came, now := self.robot.clock.now())
            if now - self._came < _COMES_TO_REST * self.patience:
                self._restart()
        if there and state.base_settled:
            return self.succeed(f"{to_go * 100:.0f} cm from {self._where}")
        if there and state.gait is Gait.STAND:
            return self.await_rest("coming to rest")
        if not self._route.follow(self._goal, self._heading):
            self._restart()
            if self._route.hopeless:
                return self.fail(f"no way to {self._where}: {self._route.blocked}")
            return self.running(f"waiting: {self._route.blocked}")
        if not self._comes_nearer():
            left = f"{to_go:.2f} m and {math.degrees(abs(turn)):.0f} deg to go"
            return self.fail(f"comes no nearer: {left}{self.robot.why_no_step()}")
        return self.running(f"{self._route.to_go:.2f} m and {math.degrees(abs(turn)):.0f} deg to go")

    def _comes_nearer(self) -> bool:
        """Return whether it still walks on or turns: it may do either away from the goal, as one that goes backward."""
        gait, now = self.robot.config.gait, self.robot.clock.now()
        way, turns = self._route.to_go / gait.step_forward, self._route.turns_to_go / gait.step_turn
        before, self._left = self._left, way + turns
        if self._left > before + _LONGER and self._detours < _DETOURS:
            self._detours += 1
            self._restart()
        walks, turns_on = self._way.update(way, now), self._turns.update(turns, now)
        return walks or turns_on

    def _restart(self) -> None:
        self._way.restart()
        self._turns.restart()
