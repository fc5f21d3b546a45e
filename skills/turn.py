"""Turn on the spot."""

import math

from humanoid_bt import Gait, Improving, Route, Skill, Status, param, result

_LEAD = math.pi / 2  # rad ahead of the robot; less than half a turn, or it would go round the other way


class Turn(Skill):
    """Turn on the spot by an angle, counted from where the robot faces at the start.

    An angle of more than half a turn goes the long way round. Fails if something solid that was seen is too near, and
    says what, or if the robot does not turn.
    """

    resources = ("base",)
    bounded = True  # by its patience

    angle: float = param(unit="rad", doc="How far to turn; left is positive.")
    tolerance: float = param(0.08, unit="rad", above=0, doc="Done when turned this close.")
    patience: float = param(4.0, unit="s", above=0, doc="Fails when it turns no farther for this long.")

    turned: float = result(unit="rad", doc="How far it turned; left is positive.")

    def initialise(self) -> None:
        """Count from here."""
        self._spot = self.robot.state.stance[:2].copy()
        self._facing = float(self.robot.state.stance[2])
        self._angle = self._to_go = self.angle
        self._left = Improving(self.patience, step=0.03)
        self._route = Route(self.robot)

    def update(self) -> Status:
        """Step round."""
        state = self.robot.state
        facing = float(state.stance[2])
        self._to_go -= math.remainder(facing - self._facing, math.tau)
        self._facing = facing
        self.turned = self._angle - self._to_go
        there = abs(self._to_go) < self.tolerance
        if there and state.base_settled:
            return self.succeed(f"turned {math.degrees(self.turned):z.0f} deg")
        turns = self._left.update(abs(self._to_go), self.robot.clock.now())
        if there and (state.gait is Gait.STAND or not turns):  # it may step about its spot: it is let go there
            return self.await_rest("coming to rest")
        if near := self._route.beside():
            return self.fail(f"no room to turn: {near} would be knocked against")
        self.robot.walk_to(self._spot, facing + min(max(self._to_go, -_LEAD), _LEAD))
        if not turns:
            left = math.degrees(self._to_go)
            exact = f"{left:{'.0f' if abs(left) >= 1 else '.1g'}} deg to go"
            return self.fail(f"turns no farther: {exact}{self.robot.why_no_step()}")
        return self.running(f"{math.degrees(self._to_go):z.0f} deg to go")
