"""Walk up to something seen."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from humanoid_bt import Gait, Improving, PerceptName, Route, Skill, Status, Track, of_gaze, param, result

_SIDES = np.radians(np.arange(0, 360, 15))  # of the target, at which it may stand; the first is the one it comes from
_FARTHER, _STEP = 1.01, 0.05  # m farther away than asked for, besides the target's own size, if it cannot stand nearer
_WORTH = 10.0  # m of way that it goes to stand a metre nearer
_STAY = 1.0  # m of way that it saves to stay where it stands, once it does: what it sees is never quite the same


class Approach(Skill):
    """Walk until the target is straight ahead at a distance, round everything solid that was seen.

    Succeeds once the robot stands there; follows a target that moves. If something stands in that place, as a table
    does below a cup, or the target itself reaches there, it stands at another side of the target, or as near as it can.
    Waits while something moves in its way. Fails if the target was never seen or is gone; with what is in the way, if
    there is no way to it; and if it stands and makes no step, as for a tolerance that is too small.
    """

    resources = ("base", "gaze")
    bounded = False  # the target may move on and on
    remembered = ("obstacles",)

    target: PerceptName = param(doc="Percept to walk up to.")
    distance: float | None = param(
        None,
        unit="m",
        above=0,
        maximum=10,
        doc="Stop with the target this far ahead; default: within the robot's reach.",
    )
    tolerance: float = param(0.06, unit="m", above=0, doc="Arrived when this close to the place to stand at.")
    angle_tolerance: float = param(0.12, unit="rad", above=0, doc="Arrived when the target is ahead to this angle.")
    clearance: float = param(0.08, unit="m", minimum=0, doc="Keep this far from obstacles, if there is so much room.")
    obstacles: list[PerceptName] = param([], doc="Percepts to go round, too, besides what is solid.")
    patience: float = param(5.0, unit="s", above=0, doc="Fails when it waits, or makes no step, for this long.")
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
        self._straight = False  # whether the goal is straight before the target
        self._stood = False  # at the goal, and not facing the target: it only has to turn
        self._stands = Improving(self.patience, step=0.02)
        self._goal_of = np.full(2, np.inf)  # where the target was when the goal was chosen
        self._route = Route(self.robot, self.clearance, self.obstacles, self.patience)

    def update(self) -> Status:
        """Walk toward the place from which the target is straight ahead."""
        track = self.robot.track(self.target)
        if track is None or track.gone:
            return self.fail(self.robot.why_unseen(self.target))
        state, target = self.robot.state, track.position_world[:2]
        stance = state.stance
        self._goal = self._place(track, stance[:2])

        self.target_distance, self.bearing_error = distance, bearing = track.distance, track.bearing
        to_go = math.dist(self._goal.tolist(), stance[:2].tolist())
        arrived = to_go < self.tolerance and abs(bearing) < self.angle_tolerance
        if arrived and state.base_settled:
            return self.succeed(f"{distance:.2f} m from {self.target}")
        if self.look:
            self.robot.look_at(track.position_world)
        if arrived and state.gait is Gait.STAND:
            return self.running("coming to rest")
        self._stood = to_go < self.tolerance and (self._stood or state.base_settled)
        ahead = target - (stance[:2] if self._stood else self._goal)
        return self._walk(to_go, math.atan2(ahead.item(1), ahead.item(0)))

    def _walk(self, to_go: float, heading: float) -> Status:
        """Walk on to the goal, which is so far away [m], to face in a direction [rad]."""
        sent = self._route.follow(self._goal, heading, ignore=[self.target])
        stands = self.robot.why_no_step()
        if not (sent and stands):
            self._stands.restart()
        if not sent and self._route.hopeless:
            return self.fail(f"no way to {self.target}: {self._route.blocked}")
        if not sent:
            return self.running(f"waiting: {self._route.blocked}")
        if not self._stands.update(to_go, self.robot.clock.now()):
            turn = math.degrees(abs(self.bearing_error))
            return self.fail(f"comes no nearer: {to_go:.2f} m and {turn:.0f} deg to go{stands}")
        return self.running(f"{to_go:.2f} m to go to {self.target}")

    def _place(self, track: Track, here: np.ndarray) -> np.ndarray:
        """Return where to stand: straight before the target if nothing is in the way, else where there is a way to."""
        target = track.position_world[:2]
        holds = self._goal is not None and self._holds(self._goal, target, here)
        if holds and self._straight:
            return self._goal
        stop_at = self.robot.config.reach_distance if self.distance is None else self.distance
        x, y = (target - here).tolist()
        heading = math.atan2(y, x)
        goal = target - stop_at * np.array([math.cos(heading), math.sin(heading)])
        straight = self._leads_straight(goal)
        if holds and not straight:
            return self._goal
        self._goal_of, self._straight = target, straight
        return goal if straight else self._beside(track, heading, stop_at, goal)

    def _holds(self, goal: np.ndarray, target: np.ndarray, here: np.ndarray) -> bool:
        """Return whether the robot can still go where it went before: the target has not moved."""
        moved = math.dist(
            target.tolist(), self._goal_of.tolist()
        )  # or seems to by noise, which grows with the way left
        noise = 0.02 + 0.1 * math.dist(goal.tolist(), here.tolist())
        return moved < noise and self._route.free([goal], [self.target])[0]

    def _leads_straight(self, goal: np.ndarray) -> bool:
        """Return whether nothing is in the way to a place, nor at it."""
        return self._route.is_straight(goal) and self._route.free([goal], [self.target])[0]

    def _beside(self, track: Track, heading: float, stop_at: float, goal: np.ndarray) -> np.ndarray:
        """Return the best place to stand beside a target among obstacles; the one straight ahead if there is none.

        Only where it comes to straight on, and faces the target, does it stand so near to that that it could not turn.
        """
        reach = 0.0 if track.size is None else math.hypot(*track.size[:2]) / 2
        farther = np.arange(0.0, _FARTHER + reach, _STEP)
        directions = np.stack([np.cos(heading + _SIDES), np.sin(heading + _SIDES)], 1)
        places = track.position_world[:2] - (stop_at + farther)[:, None, None] * directions  # (farther, sides, 2)
        free = np.reshape(self._route.free(places.reshape(-1, 2)), places.shape[:2])
        if self._route.is_straight(goal):
            free[:, 0] = self._route.free(places[:, 0], [self.target])
        sides = np.flatnonzero(free.any(axis=0))
        nearest = free.argmax(axis=0)[sides]
        costs = _WORTH * farther[nearest]
        at = np.linalg.norm(places[nearest, sides] - self.robot.state.stance[:2], axis=1) < self.tolerance
        best = self._route.nearest(places[nearest, sides], costs - _STAY * at, [self.target])
        return goal if best is None else np.asarray(places[nearest[best], sides[best]])
