"""The network at work: observation in, position targets of its joints out, as often as its description says."""

from __future__ import annotations

import numpy as np

from humanoid_bt.control.body.policy.observation import Observation
from humanoid_bt.core.clock import WHOLE_BODY_PERIOD
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import Array, Estimate
from humanoid_bt.robot.policy.network import Tensor, size
from humanoid_bt.robot.policy.policy import Indices, Policy

_MISSES = 5  # bad answers in a row after which a policy has failed; it survives such a silence even as it walks


class LearnedWalker:
    """A policy that is asked at its own rate.

    An answer that is not finite, or none, is thrown away: the targets of the last good one stay, and the next one is
    asked for. After several of them in a row the policy has failed.

    Args:
        policy: it.
        joints: its joints as indices of the robot's.

    Attributes:
        targets: of the joints that it moves, shape (m,) [rad].
        fault: why the last answer was none, "" if it was one.
        failure: why it is not asked any more, "" while it is.
        period: time between two answers [s].
    """

    def __init__(self, policy: Policy, joints: Indices) -> None:
        self._policy = policy
        self.period = policy.period * WHOLE_BODY_PERIOD
        self._observation = Observation(policy, joints, self.period)
        self._offset = policy.default_pose[policy.moves]
        self.reset()

    def reset(self) -> None:
        """Begin, in the default pose."""
        policy = self._policy
        self._observation.reset()
        self._states: dict[str, Tensor] = {
            name: np.zeros([1 if length is None else length for length in policy.network.inputs[name]], np.float32)
            for name in policy.states
        }
        self.targets: Array = self._offset.copy()
        self.fault = self.failure = ""
        self._missed = 0

    def ask(self, estimate: Estimate, command: Array, stands: bool, masked: Indices) -> None:
        """Ask for new targets.

        Args:
            estimate: the robot.
            command: vx, vy [m/s] and wz [rad/s], shape (3,).
            stands: whether that is to stand.
            masked: joints, of the policy's, that others move.
        """
        policy, observation = self._policy, self._observation
        row = observation.observe(estimate, command, stands, masked)
        shape = [1 if length is None else length for length in policy.network.inputs[policy.input]]
        inputs = {policy.input: row.reshape(shape), **self._states}
        try:
            answer, *states = policy.network.run([policy.output, *policy.states.values()], inputs)
            self.fault = "" if _finite(answer, *states) else "the policy's answer is not finite"
        except RuntimeError as error:
            self.fault = f"the policy gives no answer: {error}"
        if self.fault:
            self._missed += 1
            if self._missed >= _MISSES:
                self.failure = self.fault
            return
        self._missed = 0
        self._states = dict(zip(policy.states, states, strict=True))
        action = policy.config.action
        raw = answer.reshape(-1).astype(float)
        clipped = clamp(raw, -action.clip, action.clip) if action.clip else raw
        observation.last_action = raw if action.last_action == "raw" else clipped
        self.targets = self._offset + policy.scale * clipped

    def executed(self, moved: Indices, position: Array) -> None:
        """Tell it what was done of its last answer by others.

        Args:
            moved: of the joints that it moves, those, as indices.
            position: their targets, shape (len(moved),) [rad].
        """
        action = self._observation.last_action.copy()
        scale = np.where(self._policy.scale[moved] == 0, 1.0, self._policy.scale[moved])
        action[moved] = (position - self._offset[moved]) / scale
        self._observation.last_action = action


def _finite(*tensors: Tensor) -> bool:
    return all(size(tensor.shape) == 0 or bool(np.isfinite(tensor).all()) for tensor in tensors)
