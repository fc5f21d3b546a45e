"""What a learned walker is told: terms with scale, clip and history, and its phase."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import accumulate

import numpy as np

from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array, Estimate
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS
from humanoid_bt.robot.policy.config import PhaseConfig
from humanoid_bt.robot.policy.network import Tensor
from humanoid_bt.robot.policy.options import PHASES
from humanoid_bt.robot.policy.policy import Indices, Policy

_AXES = {"vx": 0, "vy": 1, "wz": 2}


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
            self.angles[:] = config.standing
        elif config.standing is not None and self._stands:
            self.angles[:] = config.start
        else:
            _turn(self.angles, self._step)
        self._stands = stands

    def show(self, stands: bool, sines: Array, cosines: Array) -> None:
        """Write what is observed of it, of the shape of ``angles`` each.

        Args:
            stands: whether the command is to stand.
            sines, cosines: are written.
        """
        if stands and self._config.standing_zero:
            sines[:] = cosines[:] = 0.0
        else:
            np.sin(self.angles, out=sines)
            np.cos(self.angles, out=cosines)

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
        self._policy = policy
        config, phase = policy.config.observation, policy.config.phase
        self._phase = Phase(phase, period) if phase else None
        now, parts = _parts(policy)
        self._velocity, self._sines, self._cosines = (now[parts[name]] for name in ("base_lin_vel", *PHASES))
        self._sees_velocity = any(term.config.term == "base_lin_vel" for term in policy.terms)
        self._look = _look.bind(joints, policy.default_pose, now)
        self._past: Array = np.zeros(policy.width)
        self._fills = config.fill == "first"
        self._tell = _tell.bind(
            now, _places(policy, parts), *_rules(policy), config.clipped == "before_scale",
            math.inf if config.clip is None else config.clip, _memory(policy), self._past,
        )  # fmt: skip
        self.reset()

    def reset(self) -> None:
        """Begin: nothing was observed, nothing was done."""
        self.last_action: Array = np.zeros(len(self._policy.moves))
        self._past[:] = 0.0
        self._begins = True
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
        if phase := self._phase:
            if phase.is_ahead:
                phase.advance(stands)
            phase.show(stands, self._sines, self._cosines)
            if not phase.is_ahead:
                phase.advance(stands)
        qpos, qvel = estimate.qpos, estimate.qvel
        if self._sees_velocity:
            self._velocity[:] = rotation_matrix(qpos[3:BASE_COORDINATES]).T @ qvel[:3]
        self._look(qpos, qvel, command, self.last_action, masked)
        row: Tensor = np.empty((1, len(self._past)), np.float32)
        self._tell(self._begins and self._fills, row)
        self._begins = False
        return row


def _parts(policy: Policy) -> tuple[Array, dict[str, slice]]:
    """Return a row for all that a policy can be told of a moment, its constants in it, and where each part is."""
    joints, phase = len(policy.joints), policy.config.phase
    constants = [value for term in policy.terms if term.config.term == "constant" for value in term.config.value]
    lengths = {
        **dict.fromkeys(("base_ang_vel", "projected_gravity", "command"), 3),
        **dict.fromkeys(("joint_pos", "joint_pos_rel", "joint_vel"), joints),
        "last_action": len(policy.moves),  # so far :func:`_look` writes it, in this order
        "base_lin_vel": 3,
        **dict.fromkeys(PHASES, len(phase.start) if phase else 0),
        "constant": len(constants),
    }
    ends = list(accumulate(lengths.values()))
    parts = {name: slice(end - length, end) for (name, length), end in zip(lengths.items(), ends, strict=True)}
    row: Array = np.zeros(ends[-1])
    row[parts["constant"]] = constants
    return row, parts


def _places(policy: Policy, parts: Mapping[str, slice]) -> Indices:
    """Return where in that row is what the terms tell of a moment, shape (numbers,)."""
    places, constants = [], 0
    for term in policy.terms:
        name = term.config.term
        part = np.arange(parts[name].start, parts[name].stop)
        if name == "command":
            part = part[[_AXES[axis] for axis in term.config.axes]]
        elif name == "constant":
            part, constants = part[constants:][: term.length], constants + term.length
        elif name.startswith("joint"):
            part = part[term.joints]
        places.append(part)
    return np.concatenate(places)


def _rules(policy: Policy) -> tuple[Array, Array, Array]:
    """Return the scale, the least and the largest of each of these numbers, shape (numbers,) each."""
    rules = [(term.scale, *(term.bounds or (-math.inf, math.inf))) for term in policy.terms]
    scale, low, high = np.concatenate([np.array(np.broadcast_arrays(*rule)) for rule in rules], axis=1)
    return scale, low, high


def _memory(policy: Policy) -> Indices:
    """Return where the observation has each of these numbers: first, then how far from it later ones, and how often.

    Returns:
        Shape (numbers, 3).
    """
    rows: list[tuple[int, int, int]] = []
    start, together = 0, sum(term.length for term in policy.terms)
    for term in policy.terms:
        by_time = policy.config.observation.order == "by_time"
        rows += [(start + i, together if by_time else term.length, term.history) for i in range(term.length)]
        start += term.length if by_time else term.length * term.history
    return np.array(rows, dtype=np.intp)


@compiled("void(f8[::1], f8)")
def _turn(angles: Array, step: float) -> None:
    """Turn angles by a step, to within [-pi, pi)."""
    for i in range(len(angles)):
        angles[i] = (angles[i] + step + math.pi) % math.tau - math.pi


@bindable("void(f8[::1], f8[::1], f8[::1], f8[::1], i8[::1])", "i8[::1], f8[::1], f8[::1]")
def _look(
    qpos: Array, qvel: Array, command: Array, action: Array, masked: Indices, joints: Indices, pose: Array, now: Array
) -> None:
    """Write what is known of a moment, but for the velocity of the base and the phase.

    Args:
        qpos, qvel: of the robot.
        command: vx, vy [m/s] and wz [rad/s].
        action: the last one.
        masked: joints, of the policy's, that are seen at rest in the default pose.
        joints: the policy's as indices of the robot's, shape (n,).
        pose: the default one of these, shape (n,) [rad].
        now: is written.
    """
    now[:3] = qvel[3:BASE_DOFS]
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    now[3] = 0.0 - 2 * (x * z - w * y)
    now[4] = 0.0 - 2 * (y * z + w * x)
    now[5] = 0.0 - (1 - 2 * (x * x + y * y))
    now[6:9] = command
    count = len(joints)
    angles, offsets, speeds = now[9:][:count], now[9 + count :][:count], now[9 + 2 * count :][:count]
    for i in range(count):
        offsets[i], speeds[i] = qpos[BASE_COORDINATES + joints[i]] - pose[i], qvel[BASE_DOFS + joints[i]]
    for i in masked:
        offsets[i] = speeds[i] = 0.0
    for i in range(count):
        angles[i] = offsets[i] + pose[i]
    now[9 + 3 * count :][: len(action)] = action


@inlined
def _within(value: float, low: float, high: float) -> float:
    """Return a value within bounds; nan stays, so that it is found out."""
    if value < low:
        return low
    return high if value > high else value


@bindable("void(b1, f4[:, ::1])", "f8[::1], i8[::1], f8[::1], f8[::1], f8[::1], b1, f8, i8[:, ::1], f8[::1]")
def _tell(
    fills: bool,
    told: Tensor,
    now: Array,
    places: Indices,
    scale: Array,
    low: Array,
    high: Array,
    first_clipped: bool,
    most: float,
    memory: Indices,
    past: Array,
) -> None:
    """Remember what is known of a moment, and write the observation.

    Args:
        fills: whether it is as if it had always been as now.
        told: is written, shape (1, width).
        now: what is known, of which these are seen:
        places, scale, low, high: see :func:`_places` and :func:`_rules`.
        first_clipped: whether a number is clipped before it is scaled.
        most: to which the whole observation is clipped.
        memory: see :func:`_memory`.
        past: the observation so far, not clipped; it goes on by a moment, shape (width,).
    """
    for i in range(len(places)):
        value = now[places[i]]
        if first_clipped:
            value = _within(value, low[i], high[i]) * scale[i]
        else:
            value = _within(value * scale[i], low[i], high[i])
        place, step = memory[i, 0], memory[i, 1]
        for _ in range(memory[i, 2] - 1):
            past[place] = value if fills else past[place + step]
            place += step
        past[place] = value
    for i in range(len(past)):
        told[0, i] = _within(past[i], -most, most)
