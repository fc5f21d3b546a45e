"""What walks and balances: the one interface of every body, whatever is behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.messages import Array, Estimate, Gait, Side, Target


@dataclass(frozen=True)
class Setpoint:
    """What the servo shall follow; each of shape (nj,), and nobody changes it.

    Attributes:
        position: [rad].
        velocity: [rad/s].
        torque: feedforward [Nm].
        stiffness, damping: gains of the drives [Nm/rad], [Nm s/rad]; None for those of ``robot.yaml``.
    """

    position: Array
    velocity: Array
    torque: Array
    stiffness: Array | None = None
    damping: Array | None = None


class Arms(Protocol):
    """The arms that yield to what pushes them.

    Attributes:
        sides: those that yield; the controller sets it before each update.
        homeward: those that yielded, and are on their way home.
    """

    sides: frozenset[Side]
    homeward: frozenset[Side]


@dataclass(frozen=True)
class Footstep:
    """A foothold: which foot, and its pose (x, y, yaw), world frame."""

    side: Side
    pose: Array


class Body(Protocol):
    """State and targets in, setpoints of all joints out, time and again.

    It balances whatever the targets are, so that a robot without commands goes on standing. Bodies do not know of each
    other, nor of who commands them: the controller gives each the same estimate and takes the same setpoints, and the
    servo clamps them into the same limits.
    """

    @property
    def period(self) -> float:
        """Time between two updates [s]: a whole multiple of the period of the estimate."""

    @property
    def dynamics(self) -> RobotDynamics:
        """The robot as it is estimated, always up to date."""

    @property
    def arms(self) -> Arms:
        """Which of its arms yield."""

    @property
    def gait(self) -> Gait:
        """What the legs do."""

    @property
    def still_for(self) -> float:
        """How long it stands already [s]; 0 while it steps."""

    @property
    def stance(self) -> Array:
        """Middle between the feet on the ground and its heading, shape (3,): x, y [m], yaw [rad], world frame."""

    @property
    def footsteps(self) -> Sequence[Footstep]:
        """Planned footholds ahead, the next first; none where none are planned."""

    @property
    def com_speed(self) -> float:
        """Horizontal speed of the centre of mass [m/s], as far as it tells whether the robot is at rest."""

    @property
    def com_error(self) -> Array:
        """From where the centre of mass was planned to be to where it was to go, shape (3,) [m]; 0 without a plan.

        It is the same array for good.
        """

    def hand_error(self, side: Side) -> float | None:
        """How far a planned palm is from where it is to go [m]; None if nothing commands it."""

    @property
    def hand_obstacles(self) -> Mapping[Side, str]:
        """The own link that keeps a commanded palm from its target, of those that one keeps."""

    @property
    def fault(self) -> str:
        """Why the last setpoint is not what it should be, "" if it is."""

    @property
    def failure(self) -> str:
        """Why this body cannot go on, "" while it can."""

    def reset(self, estimate: Estimate) -> None:
        """Begin a run: the robot stands at rest, and how it stands is its home posture."""

    def restart(self, estimate: Estimate) -> None:
        """Go on from where the robot is, with everything at rest, and return to the home posture slowly."""

    def update(self, estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> Setpoint:
        """Return the setpoints of this control period.

        Args:
            estimate: the robot, as it is believed to be; its dynamics are up to date with it.
            targets: resource -> target; what is missing comes to rest.
            hold: come to a stand, and keep hands, gaze and height where they are relative to the stance.
        """
