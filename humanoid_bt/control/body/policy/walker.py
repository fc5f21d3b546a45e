"""The network at work: observation in, position targets of its joints out, as often as its description says."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.policy.inference import Inference
from humanoid_bt.control.body.policy.observation import Observation
from humanoid_bt.core.clock import ESTIMATE_PERIOD
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import Array, Estimate
from humanoid_bt.robot.policy.network import Tensor, of_one, size
from humanoid_bt.robot.policy.policy import Indices, Policy

# Answers in a row after which a policy has failed. It survives a longer silence than either, even as it walks; but the
# sooner another body takes over, the more often it catches the robot:
_WRONG, _LATE = 2, 3


class LearnedWalker:
    """A policy that is asked at its own rate, and whose answers are taken a control period later.

    An answer that is not finite is thrown away, and one that is late is not waited for: the targets of the last good
    one stay. After several of these in a row the policy has failed.

    Args:
        policy: it.
        joints: its joints as indices of the robot's.
        waits: whether time stands still while it computes.

    Attributes:
        targets: of the joints that it moves, shape (m,) [rad].
        fault: why there are no targets of the last answer, "" if there are.
        failure: why it is not asked any more, "" while it is.
        period: time between two answers [s].
    """

    def __init__(self, policy: Policy, joints: Indices, *, waits: bool) -> None:
        self._policy, self._waits = policy, waits
        self.period = policy.period * ESTIMATE_PERIOD
        self._observation = Observation(policy, joints, self.period)
        self._offset = policy.offset
        self._shape = of_one(policy.network.inputs[policy.input])
        self._most = math.inf if policy.config.action.clip is None else policy.config.action.clip
        self._observes_raw = policy.config.action.last_action == "raw"
        self._inference = self._new_inference()
        self.reset()

    def reset(self) -> None:
        """Begin, in the default pose."""
        policy = self._policy
        self._observation.reset()
        self._states: dict[str, Tensor] = {
            name: np.zeros(of_one(policy.network.inputs[name]), np.float32) for name in policy.states
        }
        self.targets: Array = policy.default_pose[policy.moves]
        self.fault = self.failure = ""
        self._missed = 0
        if self._inference.busy:  # what comes is an answer to what was before
            self._inference = self._new_inference()

    def _new_inference(self) -> Inference:
        policy = self._policy
        return Inference(policy.network, [policy.output, *policy.states.values()], waits=self._waits)

    def ask(self, estimate: Estimate, command: Array, stands: bool, masked: Indices) -> None:
        """Ask for new targets, unless it still computes the last ones.

        Args:
            estimate: the robot.
            command: vx, vy [m/s] and wz [rad/s], shape (3,).
            stands: whether that is to stand.
            masked: joints, of the policy's, that others move.
        """
        policy = self._policy
        row = self._observation.observe(estimate, command, stands, masked)
        if self._inference.busy:
            self._miss("the policy does not answer in time", _LATE)
            return
        self._inference.ask({policy.input: row.reshape(self._shape), **self._states})

    def take(self) -> bool:
        """Take the answer, if there is one, and return whether there are new targets."""
        if not self._inference.busy:
            return False
        try:
            answers = self._inference.take()
        except RuntimeError as error:
            return self._miss(f"the policy gives no answer: {error}", _WRONG)
        if answers is None:
            return False
        answer, *states = answers
        raw: Array = answer.reshape(self._offset.shape).astype(float)
        clipped, targets = np.empty_like(raw), np.empty_like(raw)
        finite = _understand(raw, self._most, self._policy.scale, self._offset, clipped, targets)
        if not (finite and _finite(*states)):
            return self._miss("the policy's answer is not finite", _WRONG)
        self.fault, self._missed = "", 0
        self._states = dict(zip(self._policy.states, states, strict=True))
        self._observation.last_action = raw if self._observes_raw else clipped
        self.targets = targets
        return True

    def _miss(self, fault: str, most: int) -> bool:
        self.fault = fault
        self._missed += 1
        if self._missed >= most:
            self.failure = fault
            self._inference.give_up()
        return False

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


@compiled("b1(f8[::1], f8, f8[::1], f8[::1], f8[::1], f8[::1])")
def _understand(raw: Array, most: float, scale: Array, offset: Array, clipped: Array, targets: Array) -> bool:
    """Write what an answer means; return whether it is finite.

    Args:
        raw: the answer, shape (m,).
        most: to which it is clipped on either side.
        scale, offset: to targets, of its joints, shape (m,) [rad].
        clipped, targets: are written, shape (m,).
    """
    for i in range(len(raw)):
        if not math.isfinite(raw[i]):
            return False
        clipped[i] = min(max(raw[i], -most), most)
        targets[i] = offset[i] + scale[i] * clipped[i]
    return True


def _finite(*tensors: Tensor) -> bool:
    return all(size(tensor.shape) == 0 or bool(np.isfinite(tensor).all()) for tensor in tensors)
