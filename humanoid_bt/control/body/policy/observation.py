"""What a learned walker is told: terms with scale, clip and history, and its phase."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.geometry import clamp, rotation_matrix
from humanoid_bt.core.messages import Array, Estimate
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS
from humanoid_bt.robot.policy.config import PhaseConfig
from humanoid_bt.robot.policy.network import Tensor
from humanoid_bt.robot.policy.policy import Indices, Policy, Term

_AXES = {"vx": 0, "vy": 1, "wz": 2}
_DOWN = np.array([0.0, 0.0, -1.0])
_NOTHING: Array = np.zeros(0)


class Phase:
    """The clock of a learned walker.

    Args:
        config: its rule.
        period: time between two answers [s].

    Attributes:
        angles: now, shape (len(config.start),) [rad].
    """

    def __init__(self, config: PhaseConfig, period: float) -> None:
        self._config, self._step = config, math.tau * period / config.period
        self.reset()

    def reset(self) -> None:
        """Begin."""
        self.angles: Array = np.array(self._config.start)
        self._stands = False

    def advance(self, stands: bool) -> None:
        """Go on by one answer.

        Args:
            stands: whether the command is to stand; a walk after that begins where the clock begins.
        """
        config = self._config
        if config.standing is not None and stands:
            self.angles = np.array(config.standing)
        elif config.standing is not None and self._stands:
            self.angles = np.array(config.start)
        else:
            self.angles = (self.angles + self._step + math.pi) % math.tau - math.pi
        self._stands = stands

    def seen(self, stands: bool) -> tuple[Array, Array]:
        """Return what is observed of it: sines and cosines, of the shape of ``angles`` each.

        Args:
            stands: whether the command is to stand.
        """
        if stands and self._config.standing_zero:
            return np.zeros_like(self.angles), np.zeros_like(self.angles)
        return np.sin(self.angles), np.cos(self.angles)

    @property
    def is_ahead(self) -> bool:
        """Whether it advances before it is observed."""
        return self._config.advance == "before"


class Observation:
    """Makes the network's input.

    Args:
        policy: whose.
        joints: the policy's joints as indices of the robot's.
        period: time between two answers [s].

    Attributes:
        last_action: as the network gave it, or as it was clipped, shape (m,).
    """

    def __init__(self, policy: Policy, joints: Indices, period: float) -> None:
        self._policy, self._config = policy, policy.config.observation
        self._joints = joints
        phase = policy.config.phase
        self._phase = Phase(phase, period) if phase else None
        self.reset()

    def reset(self) -> None:
        """Begin: nothing was observed, nothing was done."""
        self.last_action: Array = np.zeros(len(self._policy.moves))
        self._history: list[Array] | None = None
        if self._phase:
            self._phase.reset()

    def observe(self, estimate: Estimate, command: Array, stands: bool, masked: Indices) -> Tensor:
        """Return the observation of this moment, shape (1, width).

        Args:
            estimate: the robot.
            command: vx, vy [m/s] and wz [rad/s], shape (3,).
            stands: whether that is to stand.
            masked: joints, of the policy's, that others move: seen at rest in the default pose.
        """
        phase = self._phase
        if phase and phase.is_ahead:
            phase.advance(stands)
        values = self._values(estimate, command, stands, masked)
        if phase and not phase.is_ahead:
            phase.advance(stands)
        latest: list[Array] = []
        for term in self._policy.terms:
            config, known = term.config, values[term.config.term]
            if config.term == "command":
                known = known[[_AXES[axis] for axis in config.axes]]
            elif config.term == "constant":
                known = np.array(config.value)
            elif config.term.startswith("joint"):
                known = known[term.joints]
            latest.append(self._scaled(term, known))
        self._remember(latest)
        return self._row()

    def _scaled(self, term: Term, known: Array) -> Array:
        if term.bounds is None:
            return known * term.scale
        if self._config.clipped == "before_scale":
            return clamp(known, *term.bounds) * term.scale
        return clamp(known * term.scale, *term.bounds)

    def _values(self, estimate: Estimate, command: Array, stands: bool, masked: Indices) -> dict[str, Array]:
        """Return every term as it is before its scale."""
        qpos, qvel = estimate.qpos, estimate.qvel
        to_base = rotation_matrix(qpos[3:BASE_COORDINATES]).T
        angles = qpos[BASE_COORDINATES:][self._joints]
        offset, speeds = angles - self._policy.default_pose, qvel[BASE_DOFS:][self._joints]
        if len(masked):
            offset[masked] = speeds[masked] = 0.0
        sine, cosine = self._phase.seen(stands) if self._phase else (_NOTHING, _NOTHING)
        return {
            "base_ang_vel": qvel[3:BASE_DOFS],
            "base_lin_vel": to_base @ qvel[:3],
            "projected_gravity": to_base @ _DOWN,
            "command": command,
            "joint_pos": offset + self._policy.default_pose,
            "joint_pos_rel": offset,
            "joint_vel": speeds,
            "last_action": self.last_action,
            "phase_sin": sine,
            "phase_cos": cosine,
            "constant": _NOTHING,
        }

    def _remember(self, latest: list[Array]) -> None:
        if self._history is None:
            first = self._config.fill == "first"
            self._history = [
                np.tile(value if first else np.zeros_like(value), (term.history, 1))
                for term, value in zip(self._policy.terms, latest, strict=True)
            ]
        for past, value in zip(self._history, latest, strict=True):
            past[:-1] = past[1:]
            past[-1] = value

    def _row(self) -> Tensor:
        assert self._history is not None
        if self._config.order == "by_time":
            row = np.concatenate(self._history, axis=1).reshape(-1)
        else:
            row = np.concatenate([past.reshape(-1) for past in self._history])
        if self._config.clip:
            row = clamp(row, -self._config.clip, self._config.clip)
        return row.astype(np.float32)[None]
