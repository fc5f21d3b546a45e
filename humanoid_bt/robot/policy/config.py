"""``walk.policy.yaml``: what a network must be told, and what its answer means, without code."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import param
from humanoid_bt.core.reading import read
from humanoid_bt.files import document
from humanoid_bt.robot.policy.per_joint import Angles, Joints, PerJoint

Axis = Literal["vx", "vy", "wz"]
TermName = Literal[
    "base_ang_vel",
    "base_lin_vel",
    "projected_gravity",
    "command",
    "joint_pos",
    "joint_pos_rel",
    "joint_vel",
    "last_action",
    "phase_sin",
    "phase_cos",
    "constant",
]


@dataclass(frozen=True, kw_only=True)
class TermConfig:
    """A term of the observation."""

    term: TermName = param(
        doc="base_ang_vel, base_lin_vel: of the base, in its frame; projected_gravity: unit vector down, in it; "
        "command: the commanded velocity; joint_pos_rel: less the default pose; last_action: the last answer; "
        "phase_sin, phase_cos: of the phase; constant: value."
    )
    scale: float | list[float] = param(1.0, doc="What the term is multiplied by; a list has one for each number.")
    clip: float | list[float] | None = param(
        None, doc="It is clipped to this on either side, or to [least, largest]; before or after the scale: clipped."
    )
    history: int | None = param(None, minimum=1, doc="How many of its latest values; default: the observation's.")
    axes: list[Axis] = param(["vx", "vy", "wz"], doc="Of a command: which numbers, in which order.")
    joints: list[str] | None = param(None, doc="Of joints: only these, ordered as those of the action; default: all.")
    value: list[float] = param([], doc="Of a constant: its numbers.")


@dataclass(frozen=True, kw_only=True)
class ObservationConfig:
    """What the network is told."""

    terms: list[TermConfig] = param(doc="Its terms, in the order of the input.")
    input: str = param("", doc="The model's input; default: the only one that is no state.")
    history: int = param(1, minimum=1, doc="How many of their latest values all terms have, the oldest first.")
    order: Literal["by_term", "by_time"] = param(
        "by_term", doc="With a history: all values of a term together, or all terms of a time together."
    )
    clipped: Literal["after_scale", "before_scale"] = param("after_scale", doc="When terms with a clip are clipped.")
    fill: Literal["zeros", "first"] = param("zeros", doc="What the history holds at first.")
    clip: float | None = param(None, above=0, doc="The whole of it is clipped to this, on either side.")


@dataclass(frozen=True, kw_only=True)
class ActionConfig:
    """What the network's answer means: position targets of joints, offset + scale x answer."""

    output: str = param("", doc="The model's output; default: the only one that is no state.")
    joints: list[str] | None = param(
        None,
        doc="The joints that it moves, in the order of the answer, by name; with patterns among them, in the order of "
        "the policy's joints. Default: all of them.",
    )
    scale: PerJoint | None = param(None, doc="[rad]; default: action_scale of the model's metadata.")
    offset: Angles | None = param(None, doc="[rad]; default: the default pose.")
    clip: float | None = param(None, above=0, doc="The answer is clipped to this first, on either side.")
    last_action: Literal["clipped", "raw"] = param("clipped", doc="As what it is observed next time.")


@dataclass(frozen=True, kw_only=True)
class PhaseConfig:
    """A clock that the network is told of as sine and cosine: one number, or one for each foot."""

    period: float = param(above=0, unit="s", doc="Of a whole cycle.")
    start: list[float] = param([0.0], unit="rad", doc="Where it begins.")
    standing: list[float] | None = param(
        None, unit="rad", doc="Where it stays while the command is to stand; default: it goes on."
    )
    standing_zero: bool = param(
        False, doc="Whether sine and cosine are both observed as 0 while the command is to stand."
    )
    advance: Literal["before", "after"] = param("before", doc="Whether it moves on before or after it is observed.")


@dataclass(frozen=True, kw_only=True)
class CommandConfig:
    """The velocities that it can be commanded."""

    vx: tuple[float, float] | None = param(
        None, unit="m/s", doc="Least and largest, ahead; default of all three: command_ranges of the model's metadata."
    )
    vy: tuple[float, float] | None = param(None, unit="m/s", doc="Least and largest, to the left.")
    wz: tuple[float, float] | None = param(None, unit="rad/s", doc="Least and largest turn, to the left.")
    stand_below: float = param(0.01, minimum=0, doc="Slower than this [m/s, rad/s] is a command to stand.")
    slowest: float = param(0.12, above=0, unit="m/s", doc="It does not follow a slower walk: that far it rounds up.")
    slowest_turn: float = param(0.12, above=0, unit="rad/s", doc="Likewise of a turn.")


@dataclass(frozen=True, kw_only=True)
class StateConfig:
    """A memory of a recurrent network."""

    input: str = param(doc="The model's input that takes it.")
    output: str = param(doc="The model's output that gives it.")


@dataclass(frozen=True, kw_only=True)
class LendConfig:
    """The joints of the policy that hands and gaze may move, and what it is told of them meanwhile."""

    joints: list[str] | None = param(
        None, doc="By name or pattern; default: those of the arms and the neck of robot.yaml."
    )
    waist: list[str] = param(
        [],
        doc="Further ones, of those that carry the torso, bent slowly: for a hand while it stands, and for the gaze of "
        "a robot without a neck. "
        "Of these the policy is told the truth.",
    )
    observe: Literal["default", "measured"] = param("default", doc="Their angles: the default pose, or what they are.")
    last_action: Literal["own", "executed"] = param("own", doc="Their last action: its own, or what was done.")


@dataclass(frozen=True, kw_only=True)
class PolicyConfig:
    """A learned walker. What is left out is looked for in the model's metadata."""

    format: int = param(doc="Version of this file's form: 1.", minimum=1, maximum=1)
    model: str = param(doc="ONNX file, relative to this one.")
    description: str = param("", doc="One line for people.")
    rate: int = param(50, minimum=1, doc="How often it is asked [Hz]; 200 must be a whole multiple of it.")
    joints: Joints | None = param(None, doc="Names, in the model's order; default: dof_names or joint_names.")
    default_pose: Angles | None = param(None, doc="Default: default_joint_pos or default_dof_pos.")
    stiffness: PerJoint | None = param(None, doc="Of the drives [Nm/rad]; default: kp or joint_stiffness.")
    damping: PerJoint | None = param(None, doc="Of the drives [Nm s/rad]; default: kd or joint_damping.")
    observation: ObservationConfig = param(doc="What it is told.")
    action: ActionConfig = param(ActionConfig(), doc="What its answer means.")
    phase: PhaseConfig | None = param(None, doc="Its clock, if it has one.")
    command: CommandConfig = param(CommandConfig(), doc="What it can be commanded.")
    state: list[StateConfig] = param([], doc="Memories of a recurrent network, which begin as zeros.")
    lend: LendConfig = param(LendConfig(), doc="What others may move.")
    path: Path = field(default=Path(), compare=False)
    written: Item | None = field(default=None, compare=False, repr=False)

    def place(self, *keys: str | int) -> Place | None:
        """Return where something stands, None if it is not from a file."""
        return self.written.place_of(*keys) if self.written else None

    def says(self, *keys: str | int) -> bool:
        """Return whether something is written, and no default."""
        found = self.written
        for key in keys:
            parts = found.value if found else None
            if isinstance(parts, dict):
                found = parts.get(key)
            else:
                found = parts[key] if isinstance(parts, list) and isinstance(key, int) else None
        return found is not None


def load_policy_config(path: Path) -> PolicyConfig:
    """Read a ``walk.policy.yaml``.

    Raises:
        UserError: with every problem found, each with its place.
    """
    item = document.load(path)
    config = read(PolicyConfig, item, "the policy")
    assert isinstance(config, PolicyConfig)
    if "model" in item.value and not (path.parent / config.model).is_file():
        hint = f"looked for {path.parent / config.model}"
        raise UserError(f"the model {config.model!r} is missing", item.place_of("model"), hint, code="no-file")
    return replace(config, path=path, written=item)
