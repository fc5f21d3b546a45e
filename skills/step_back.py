"""Walk backwards."""

import math

import numpy as np

from humanoid_bt import Gait, Improving, Route, Skill, Status, param, result


class StepBack(Skill):
    """Walk straight back by a distance without turning, counted from where the robot stands at the start.

    The robot sees nothing of what is behind it, but remembers what is solid there since it saw it: it fails before it
    steps into that, and says what it is. Fails, too, if it comes no farther.
    """

    resources = ("base",)
    bounded = True  # by its patience

    distance: float = param(0.25, unit="m", above=0, doc="How far.")
    tolerance: float = param(0.06, unit="m", above=0, doc="Done when this close to the place.")
    angle_tolerance: float = param(0.12, unit="rad", above=0, doc="Done when it faces as before to this angle.")
    patience: float = param(4.0, unit="s", above=0, doc="Fails when it comes no farther for this long.")

    distance_made: float = result(unit="m", doc="How far back it came.")

    def initialise(self) -> None:
        """Count from here."""
        self._start = self.robot.state.stance[:2].copy()
        self._heading = float(self.robot.state.stance[2])
        self._left = Improving(self.patience, step=0.02)
        self._route = Route(self.robot)

    def update(self) -> Status:
        """Step to a place that is always so near that the robot does not turn round to walk there."""
        state, gait = self.robot.state, self.robot.config.gait
        back = -np.array([math.cos(self._heading), math.sin(self._heading)])
        self.distance_made = made = float(back @ (state.stance[:2] - self._start))
        goal = self._start + self.distance * back
        to_go = float(np.linalg.norm(goal - state.stance[:2]))
        turned = math.remainder(state.stance[2] - self._heading, math.tau)
        there = to_go < self.tolerance and abs(turned) < self.angle_tolerance
        if there and state.base_settled:
            return self.succeed(f"{made:z.2f} m back")
        if there and state.gait is Gait.STAND:
            return self.await_rest("coming to rest")
        if hit := self._route.hits(goal):
            return self.fail(f"no room to step back {self.distance:.2f} m: {hit} would be stepped into")
        lead = max(gait.near - gait.step_back, gait.step_back)
        self.robot.walk_to(self._start + min(self.distance, made + lead) * back, self._heading)
        if not self._left.update(to_go, self.robot.clock.now()):
            left = f"{made:z.2f} of {self.distance:.2f} m made, {to_go:.2f} m to go"
            return self.fail(f"comes no farther: {left}{self.robot.why_no_step()}")
        return self.running(f"{made:z.2f} of {self.distance:.2f} m back")
