"""A learned walker that fits its model and a robot: names, shapes and ranges have been compared."""

from __future__ import annotations

import functools
import glob
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.clock import ESTIMATE_PERIOD
from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.messages import Array
from humanoid_bt.core.patterns import matches, matching
from humanoid_bt.core.units import readable
from humanoid_bt.robot.policy.commands import RANGE_KEYS, command_problems, command_range
from humanoid_bt.robot.policy.config import PolicyConfig, TermConfig, load_policy_config
from humanoid_bt.robot.policy.network import FLOAT, FLOATS, Network, is_free, of_one, size
from humanoid_bt.robot.policy.options import PHASES, option_problems
from humanoid_bt.robot.policy.per_joint import Angles, FromModel, Joints, PerJoint, from_model

Indices = NDArray[np.intp]
_T = TypeVar("_T")

# Keys of metadata under which exporters put what the description leaves out: holosoma's, then those of mjlab and of
# others that follow Isaac Lab's motion tracking.
_KEYS = {
    "joints": ("dof_names", "joint_names"),
    "default_pose": ("default_joint_pos", "default_dof_pos"),
    "stiffness": ("kp", "joint_stiffness"),
    "damping": ("kd", "joint_damping"),
    "scale": ("action_scale",),
}
_VECTORS = ("base_ang_vel", "base_lin_vel", "projected_gravity")
_CONTROL_RATE = round(1 / ESTIMATE_PERIOD)  # Hz


@dataclass(frozen=True)
class Term:
    """A term of the observation.

    Attributes:
        config: as it is described.
        joints: of the policy's joints, those that it is about, as indices.
        length: how many numbers it has, without its history.
        history: how many of its latest values are observed.
        scale: shape (length,).
        bounds: to which it is clipped; None if it is not.
    """

    config: TermConfig
    joints: Indices
    length: int
    history: int
    scale: Array
    bounds: tuple[float, float] | None = None


class Policy:
    """A learned walker; all of it in the order of its own joints.

    Args:
        config: its description.
        network: its model.

    Raises:
        UserError: they do not fit each other; with every mistake, each with its place.

    Attributes:
        joints: names of the n joints that it knows.
        default_pose: shape (n,) [rad].
        moves: the m joints that its answer moves, as indices of these.
        scale: of the answer, shape (m,) [rad].
        offset: what is added to it then, shape (m,) [rad].
        stiffness, damping: of their drives, shape (m,) [Nm/rad], [Nm s/rad].
        ranges: least and largest vx, vy [m/s] and wz [rad/s], shape (2, 3).
        terms: of the observation.
        period: how many periods of the whole-body loop there are between two answers.
        input, output: names of the observation and of the answer.
        states: input -> output of memories.
        warnings: what is doubtful.
    """

    def __init__(self, config: PolicyConfig, network: Network) -> None:
        self.config, self.network = config, network
        self._problems: list[Problem] = []
        names = self._try(lambda: self._stated(config.joints, "joints", Joints).names(network.metadata))
        if names is None:
            raise UserError(self._problems)
        self.joints: tuple[str, ...] = tuple(names)
        self.warnings = tuple(self._doubts())
        action = config.action
        moved = self._try(lambda: self._chosen(action.joints, ("action", "joints"), self.joints))
        self.moves: Indices = np.arange(len(names)) if moved is None else moved
        moving = [names[index] for index in self.moves]
        self.default_pose = self._numbers(config.default_pose, "default_pose", names, Angles, others=0.0)
        self.stiffness = self._numbers(config.stiffness, "stiffness", moving, PerJoint)
        self.damping = self._numbers(config.damping, "damping", moving, PerJoint)
        for key, gains in (("stiffness", self.stiffness), ("damping", self.damping)):
            if (gains < 0).any():
                written = "model" if getattr(config, key) is None else key
                self._wrong(f"the {key} of {moving[int(np.argmin(gains))]!r} is negative", written)
        self.scale = self._numbers(action.scale, "scale", moving, PerJoint, within=("action",))
        self.offset: Array = self.default_pose[self.moves]
        if action.offset is not None:
            self.offset = self._numbers(action.offset, "offset", moving, Angles, others=0.0, within=("action",))
        ranges = [self._try(partial(command_range, config, axis, network.metadata)) for axis in RANGE_KEYS]
        self.ranges: Array = np.array([(0.0, 0.0) if one is None else one for one in ranges]).T
        if None not in ranges:
            self._problems += command_problems(config, self.ranges)
        self._problems += option_problems(config)
        self.period = _CONTROL_RATE // config.rate
        if _CONTROL_RATE % config.rate:
            valid = ", ".join(str(rate) for rate in range(10, 201) if _CONTROL_RATE % rate == 0)
            message = f"{_CONTROL_RATE} must be a whole multiple of it: control runs so often"
            self._wrong(message, "rate", hint=f"valid: {valid}")
        self.terms = tuple(self._terms())
        self.states = {state.input: state.output for state in config.state}
        self._judge_phase()
        self.input, self.output = self._judge_tensors()
        if self._problems:
            raise UserError(list(dict.fromkeys(self._problems)))

    @property
    def width(self) -> int:
        """How many numbers the observation has."""
        return sum(term.length * term.history for term in self.terms)

    def problems_with(self, robot_joints: Sequence[str]) -> Iterator[Problem]:
        """Yield the joints of the policy that a robot does not have, as what is wrong."""
        place = self.place("joints") if self.config.joints else self.place("model")
        for name in self.joints:
            if name not in robot_joints:
                hint = nearest(name, robot_joints)
                yield Problem(f"the robot has no joint {name!r}", place, hint, code="unknown-joint")
        lend = self.config.lend
        for key, patterns in (("joints", lend.joints), ("waist", lend.waist)):
            for number, pattern in enumerate(patterns or ()):
                if not matching(self.joints, pattern):
                    hint, where = nearest(pattern, self.joints), self.place("lend", key, number)
                    yield Problem(f"no joint of the policy matches {pattern!r}", where, hint, code="unknown-joint")

    @property
    def pose_place(self) -> Place | None:
        """Where the default pose is written."""
        return self.place("model" if self.config.default_pose is None else "default_pose")

    def angle_place(self, joint: str) -> Place | None:
        """Return where the angle of a joint in the default pose is written."""
        pose = self.config.default_pose
        if pose is not None and isinstance(pose.value, list):
            return self.place("default_pose", self.joints.index(joint))
        patterns = pose.value if pose is not None and isinstance(pose.value, dict) else ()
        pattern = next((one for one in patterns if matches(joint, one)), None)
        return self.pose_place if pattern is None else self.place("default_pose", pattern)

    def place(self, *keys: str | int) -> Place | None:
        """Return where in its description something stands, None if it has none."""
        return self.config.place(*keys)

    def _doubts(self) -> Iterator[Problem]:
        """Yield that the model itself has its joints in another order, or has others."""
        key = next((key for key in _KEYS["joints"] if key in self.network.metadata), None)
        known = None if key is None else self.network.metadata[key]
        if self.config.joints is not None and isinstance(known, list) and known != list(self.joints):
            message = f"'joints' are not as in {key!r} of the model's metadata"
            hint = f"there: {', '.join(map(str, known))}; leave 'joints' out to take these"
            yield Problem(message, self.place("joints"), hint, code="joint-order", severity="warning")

    # ---- reading -----------------------------------------------------------------------------------------------------

    def _try(self, made: Callable[[], _T]) -> _T | None:
        try:
            return made()
        except UserError as error:
            self._problems += error.problems
            return None

    def _wrong(self, message: str, *keys: str | int, hint: str = "") -> None:
        self._problems.append(Problem(message, self.place(*keys), hint, code="policy"))

    def _stated(self, value: Any, key: str, kind: type[_T], within: tuple[str, ...] = ()) -> _T:
        """Return what the description says, or else where the model's metadata has it."""
        if value is not None:
            assert isinstance(value, kind)
            return value
        place = self.place(*within) or Place(str(self.config.path))
        found = next((name for name in _KEYS[key] if name in self.network.metadata), None)
        if found is None:
            message = f"there is no {'.'.join((*within, key))!r}, and the model's metadata has none"
            keys = ", ".join(sorted(self.network.metadata))
            hint = f"it has {keys}; or write it here" if keys else f"it has no keys: write {key!r} here"
            raise UserError(message, place, hint, code="missing-key")
        item = Item({}, self.place("model") or place)
        # every kind of value can be read from metadata, which their common type does not say
        return kind(FromModel(found, item), from_model(found, item))  # type: ignore[call-arg]

    def _numbers(
        self,
        value: PerJoint | None,
        key: str,
        names: Sequence[str],
        kind: type[PerJoint],
        *,
        others: float | None = None,
        within: tuple[str, ...] = (),
    ) -> Array:
        metadata = self.network.metadata
        found = self._try(lambda: self._stated(value, key, kind, within).values(names, metadata, others, self.joints))
        return np.zeros(len(names)) if found is None else found

    def _chosen(self, patterns: list[str] | None, keys: tuple[str | int, ...], names: Sequence[str]) -> Indices:
        """Return which joints are chosen: by names alone as these are written, with patterns in the order of all."""
        if patterns is None:
            return np.arange(len(names))
        found: list[int] = []
        for number, pattern in enumerate(patterns):
            matching = [index for index, name in enumerate(names) if matches(name, pattern)]
            if not matching:
                message, hint = f"no joint of the policy matches {pattern!r}", nearest(pattern, names)
                raise UserError(message, self.place(*keys, number), hint, code="unknown-joint")
            found += [index for index in matching if index not in found]
        return np.array(found if set(patterns) <= set(names) else sorted(found), dtype=np.intp)

    def _terms(self) -> Iterator[Term]:
        observation = self.config.observation
        for number, term in enumerate(observation.terms):
            where: tuple[str | int, ...] = ("observation", "terms", number)
            joints = self._try(partial(self._chosen, term.joints, (*where, "joints"), self.joints))
            chosen = np.zeros(0, dtype=np.intp) if joints is None else joints
            history = term.history or observation.history
            if observation.order == "by_time" and history != observation.history:
                self._wrong("ordered by_time, all terms have the history of the observation", *where, "history")
            length = self._length(term, chosen, where)
            scale = np.asarray(term.scale, dtype=float)
            if scale.ndim and len(scale) != length:
                self._wrong(f"the scale of {term.term} must have {length} numbers, not {len(scale)}", *where, "scale")
                scale = np.ones(())
            bounds = self._bounds(term, (*where, "clip"))
            yield Term(term, chosen, length, history, np.broadcast_to(scale, (length,)), bounds)

    def _bounds(self, term: TermConfig, where: tuple[str | int, ...]) -> tuple[float, float] | None:
        if term.clip is None:
            return None
        pair = term.clip if isinstance(term.clip, list) else [-term.clip, term.clip]
        if len(pair) != 2 or not pair[0] < pair[1]:
            hint = "a positive number, or [least, largest]"
            self._wrong(f"{term.term} cannot be clipped to {readable(term.clip)}", *where, hint=hint)
            return None
        return pair[0], pair[1]

    def _length(self, term: TermConfig, joints: Indices, where: tuple[str | int, ...]) -> int:
        phase = self.config.phase
        if term.term in PHASES and phase is None:
            self._wrong(f"{term.term!r} needs a phase, and there is no 'phase'", *where, "term")
        lengths: dict[str, int] = {
            **dict.fromkeys(_VECTORS, 3),
            **dict.fromkeys(PHASES, len(phase.start) if phase else 1),
            "command": len(term.axes),
            "constant": len(term.value),
            "last_action": len(self.moves),
        }
        return lengths.get(term.term, len(joints))

    def _judge_phase(self) -> None:
        phase = self.config.phase
        if phase and phase.standing is not None and len(phase.standing) != len(phase.start):
            message = f"'standing' must have {len(phase.start)} numbers, as 'start' has, not {len(phase.standing)}"
            self._wrong(message, "phase", "standing")

    def _judge_tensors(self) -> tuple[str, str]:
        network, config = self.network, self.config
        for number, state in enumerate(config.state):
            for end, known in (("input", network.inputs), ("output", network.outputs)):
                name = getattr(state, end)
                taken = [getattr(other, end) for other in config.state[:number]]
                self._named(name, [one for one in known if one not in taken], known, end, "state", number, end)
            ends = network.inputs.get(state.input), network.outputs.get(state.output)
            if None not in ends and of_one(ends[0] or ()) != of_one(ends[1] or ()):
                message = f"the state's input has the shape {ends[0]}, its output {ends[1]}"
                self._wrong(message, "state", number, hint="export the model with one shape for both")
        free = [name for name in network.inputs if name not in self.states]
        given = self._only(config.observation.input, free, network.inputs, "input", "observation")
        answers = [name for name in network.outputs if name not in self.states.values()]
        answer = self._only(config.action.output, answers, network.outputs, "output", "action")
        if len(free) > 1 and given:
            others = ", ".join(repr(name) for name in free if name != given)
            self._wrong(f"nothing is said of the model's other inputs: {others}", "observation", hint="as 'state'?")
        if given and is_free(network.inputs[given]) and size(network.inputs[given]) != self.width:
            hint = f"export it with {self.width} numbers: only the first size, of the batch, may be free"
            self._wrong(f"how many numbers the model's input {given!r} has is left open", "model", hint=hint)
        elif given and size(network.inputs[given]) != self.width:
            parts = ", ".join(f"{term.config.term} {term.length * term.history}" for term in self.terms)
            wanted = size(network.inputs[given])
            message = f"the terms have {self.width} numbers, the model's input {given!r} {wanted}"
            if wanted > self.width > 0 == wanted % self.width and all(term.history == 1 for term in self.terms):
                parts = f"{parts}; is there a history: {wanted // self.width} of them?"
            self._wrong(message, "observation", "terms", hint=parts)
        for name in filter(None, (answer, *self.states.values())):
            kind, valid = network.kinds.get(name, FLOAT), (FLOAT,) if name != answer else FLOATS
            if kind not in valid:
                hint = f"export it as {' or '.join(valid)}"
                self._wrong(f"the model's output {name!r} is a {kind}", "model", hint=hint)
        if answer and is_free(network.outputs[answer]) and size(network.outputs[answer]) != len(self.moves):
            hint = f"export it with {len(self.moves)} numbers: only the first size, of the batch, may be free"
            self._wrong(f"how many numbers the model's output {answer!r} has is left open", "model", hint=hint)
        elif answer and size(network.outputs[answer]) != len(self.moves):
            numbers = size(network.outputs[answer])
            self._wrong(
                f"it moves {len(self.moves)} joints, the model's output {answer!r} has {numbers} numbers", "action"
            )
        return given, answer

    def _named(self, name: str, free: list[str], known: Iterable[str], what: str, *keys: str | int) -> bool:
        if name not in known:
            self._wrong(f"the model has no {what} {name!r}", *keys, hint=nearest(name, known))
        elif name not in free:
            hint = f"free: {', '.join(free)}" if free else ""
            self._wrong(f"the model's {what} {name!r} is a state's already", *keys, hint=hint)
        return name in free

    def _only(self, name: str, free: list[str], known: Iterable[str], what: str, key: str) -> str:
        """Return the name that is given, or the only one there is; "" if neither."""
        if name:
            return name if self._named(name, free, known, what, key, what) else ""
        if len(free) == 1:
            return free[0]
        self._wrong(f"the model has {len(free)} {what}s: say which", key, hint=f"{what}: {' or '.join(free)}")
        return ""


def load_policy(path: Path) -> Policy:
    """Return the policy that a file describes.

    Raises:
        UserError: the description has mistakes, or does not fit its model; with the place of each.
    """
    files = policy_files(path)
    return _loaded(path, tuple((str(file), file.stat().st_mtime_ns, file.stat().st_size) for file in files))


def policy_files(path: Path) -> list[Path]:
    """Return the files of a policy: its description, its model, and weights in files of their own.

    Raises:
        UserError: the description has mistakes.
    """
    model = path.parent / load_policy_config(path).model
    beside = model.parent.glob(f"{glob.escape(model.stem)}*")  # exporters name them after the model
    return [path, *sorted(file for file in beside if file.is_file())]


@functools.lru_cache(maxsize=8)
def _loaded(path: Path, _state: tuple[tuple[str, int, int], ...]) -> Policy:
    config = load_policy_config(path)
    written = config.written
    return Policy(config, Network(path.parent / config.model, written.place_of("model") if written else None))
