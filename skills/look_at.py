"""Look at something seen."""

import math

import numpy as np

from humanoid_bt import Improving, Lasting, PerceptName, Skill, Status, param, result


class LookAt(Skill):
    """Turn the view until the target is in its middle, and keep it there for a moment.

    Follows a target that moves. Fails if the target was never seen or is gone, or if the view comes no nearer to it:
    the feet stay where they are, so what is far behind is out of view. Fails, too, if the target was in the middle and
    does not stay there long enough, within five times the hold and the patience.
    """

    resources = ("gaze",)
    bounded = True  # by its patience and its hold

    target: PerceptName = param(doc="Percept to look at.")
    tolerance: float = param(0.15, unit="rad", above=0, doc="In the middle when this close to the view's direction.")
    hold: float = param(0.5, unit="s", minimum=0, doc="How long it must stay there.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when the view comes no nearer for this long.")

    view_error: float = result(unit="rad", doc="From the middle of the view to the target.")

    def initialise(self) -> None:
        """Begin to count anew."""
        self._held = Lasting(self.hold, self.patience)
        self._error = Improving(self.patience, step=0.02)

    def update(self) -> Status:
        """Look at where the target was last seen."""
        track = self.robot.track(self.target)
        if track is None or track.gone:
            return self.fail(self.robot.why_unseen(self.target))
        self.robot.look_at(track.position_world)

        now, state = self.robot.clock.now(), self.robot.state
        self.view_error = error = _angle(state.gaze_direction, track.position_world - state.gaze_position)
        there = error < self.tolerance
        if self._held.update(there, now):
            return self.succeed(f"{math.degrees(error):.0f} deg from {self.target}")
        if self._held.hopeless:
            return self.fail(f"the view does not stay at {self.target} for {self.hold:g} s")
        if there:
            self._error.arrived(error)
        elif not self._error.update(error, now):
            best = math.degrees(self._error.best)
            exact = f"{best:{'.0f' if best >= 1 else '.1g'}} deg"
            return self.fail(f"the view comes no nearer to {self.target} than {exact}")
        return self.running(f"{math.degrees(error):.0f} deg from {self.target}")


def _angle(first: np.ndarray, second: np.ndarray) -> float:
    """Return the angle between two vectors, shape (3,) [rad]."""
    return math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second))
