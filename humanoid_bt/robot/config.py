"""``robot.yaml``: everything the engine needs to know of a robot beyond its MJCF model."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from humanoid_bt.core.errors import Place, Problem, UserError, relative
from humanoid_bt.core.items import Item
from humanoid_bt.core.messages import RESOURCES, SIDES
from humanoid_bt.core.params import param
from humanoid_bt.core.patterns import matches
from humanoid_bt.core.reading import read
from humanoid_bt.files import document
from humanoid_bt.files.reading import read_bytes
from humanoid_bt.robot.model_file import model_file
from humanoid_bt.robot.sensor_config import SensorsConfig

_MAX_MODEL = 20_000_000  # bytes of an MJCF file, without its meshes


@dataclass(frozen=True, kw_only=True)
class SiteConfig:
    """A point on the robot; a site is added to the body there."""

    body: str = param(doc="Body that carries the site.")
    position: tuple[float, float, float] = param((0.0, 0.0, 0.0), unit="m", doc="In the body's frame.")


@dataclass(frozen=True, kw_only=True)
class FrameConfig(SiteConfig):
    """A point on the robot and how it is turned there."""

    ahead: tuple[float, float, float] = param(
        (1.0, 0.0, 0.0), doc="What is ahead as it stands, as a direction in the body's frame."
    )
    up: tuple[float, float, float] = param((0.0, 0.0, 1.0), doc="What is up then, likewise.")


@dataclass(frozen=True, kw_only=True)
class HandConfig(SiteConfig):
    """A palm: a point on the hand, and two of the hand's axes, in the frame of the body that carries it."""

    fingers: tuple[float, float, float] | None = param(
        None, doc="Where the fingers point, as a direction; default: from the body's origin to the palm."
    )
    facing: tuple[float, float, float] | None = param(
        None, doc="Where the palm faces, as a direction; default: to the other side (along y), or down (-z)."
    )


@dataclass(frozen=True, kw_only=True)
class GazeConfig(FrameConfig):
    """The eyes: a point on the body that carries them, and where that looks."""

    down: float = param(
        0.0,
        minimum=0,
        maximum=1.2,
        unit="rad",
        doc="How far they look down while that body is upright, as those of a robot without a neck do.",
    )


@dataclass(frozen=True, kw_only=True)
class LegConfig:
    """The joints and the sole of one leg."""

    hip_roll: str = param(doc="Joint that swings the leg sideways.")
    hip_pitch: str = param(doc="Joint that swings the leg forward.")
    ankle_pitch: str = param(doc="Joint that tilts the foot forward.")
    ankle_roll: str | None = param(None, doc="Joint that tilts the foot sideways, if it has one: both legs or none.")
    sole: FrameConfig = param(doc="Centre of the sole, and how it is turned in its body.")


@dataclass(frozen=True, kw_only=True)
class SoleConfig:
    """The rectangle of the sole that carries load."""

    half_length: float = param(above=0, unit="m", doc="From the sole's centre to the toe.")
    half_width: float = param(above=0, unit="m", doc="From the sole's centre to its side.")
    margin: float = param(0.012, minimum=0, unit="m", doc="The centre of pressure is kept this far inside the edge.")
    side_margin: float | None = param(
        None,
        minimum=0,
        unit="m",
        doc="The same for its sides; default: margin, or half_width, its middle line, if no ankle_roll holds the foot.",
    )

    @property
    def bears(self) -> tuple[float, float]:
        """Half length and half width of the part that may bear the centre of pressure [m]."""
        along, aside = self.margins
        return self.half_length - along, max(self.half_width - aside, 0.0)

    @property
    def margins(self) -> tuple[float, float]:
        """How far inside toe and heel, and inside the sides, the centre of pressure is kept [m]."""
        return self.margin, self.margin if self.side_margin is None else self.side_margin


@dataclass(frozen=True, kw_only=True)
class NeckConfig:
    """The joints that turn the head."""

    yaw: str = param(doc="Joint that turns the head left.")
    pitch: str = param(doc="Joint that turns the head down.")


@dataclass(frozen=True, kw_only=True)
class DriveConfig:
    """The drives of a group of joints."""

    joints: list[str] = param(doc="Joint names; * stands for anything.")
    stiffness: float = param(above=0, unit="", doc="Position gain [Nm/rad].")
    damping: float = param(above=0, unit="", doc="Velocity gain [Nm s/rad].")
    torque: float = param(above=0, unit="Nm", doc="Limit of the torque.")
    speed: float = param(12.0, above=0, unit="rad/s", doc="Limit of the setpoint's speed.")


@dataclass(frozen=True, kw_only=True)
class GaitConfig:
    """Walking: footsteps, timing, balance. Defaults fit a humanoid of about 1.3 m and 40 kg."""

    single_support: float = param(0.36, minimum=0.05, unit="s", doc="Time on one foot.")
    quickest_step: float = param(0.22, above=0, unit="s", doc="Least time on one foot, for a step that catches a push.")
    double_support: float = param(0.06, above=0, unit="s", doc="Time on both feet between steps.")
    first_shift: float = param(0.35, above=0, unit="s", doc="Weight shift before the first step.")
    last_shift: float = param(0.4, above=0, unit="s", doc="Weight shift after the last step.")
    quick_shift: float = param(0.10, above=0, unit="s", doc="Weight shift before a step that catches a push.")
    lift: float = param(0.04, above=0, unit="m", doc="Height of the swing foot.")
    stance_width: float = param(0.18, above=0, unit="m", doc="Distance between the soles' centres.")
    step_forward: float = param(0.22, above=0, unit="m", doc="Longest step forward.")
    step_back: float = param(0.14, above=0, unit="m", doc="Longest step back.")
    step_sideways: float = param(0.10, above=0, unit="m", doc="Longest step sideways.")
    step_turn: float = param(0.55, above=0, unit="rad", doc="Largest turn in a step.")
    near: float = param(0.35, above=0, unit="m", doc="Nearer than this it side-steps instead of turning to the goal.")
    arrived_distance: float = param(0.025, above=0, unit="m", doc="Arrived when nearer.")
    arrived_angle: float = param(0.04, above=0, unit="rad", doc="Arrived when turned this close.")
    leave_distance: float = param(
        0.04, above=0, unit="m", doc="Starts again only when farther (hysteresis); skills' tolerances are no smaller."
    )
    leave_angle: float = param(0.06, above=0, unit="rad", doc="Starts again only when turned farther; likewise.")
    dcm_gain: float = param(2.5, above=1, doc="ZMP answer to an error of the divergent component of motion.")
    momentum_limit: float = param(0.08, minimum=0, unit="m", doc="Limit of the angular momentum's ZMP shift.")
    com_slide: float = param(1.0, minimum=0, doc="Leak of the reference to the measured centre of mass [1/s].")
    adjust_forward: float = param(0.25, minimum=0, unit="m", doc="Largest step adjustment forward.")
    adjust_sideways: float = param(0.30, minimum=0, unit="m", doc="Largest step adjustment sideways.")
    adjust_until: float = param(0.97, above=0, maximum=1, doc="Share of the swing after which the foothold stays.")
    separation_min: float = param(0.13, above=0, unit="m", doc="Least sideways distance of the feet.")
    separation_max: float = param(0.48, above=0, unit="m", doc="Largest sideways distance of the feet.")
    touchdown_force: float = param(50.0, above=0, unit="N", doc="Force on the swing foot that counts as contact.")
    touchdown_after: float = param(0.75, above=0, maximum=1, doc="Share of the swing after which contact counts.")
    arm_swing: float = param(
        1.5, minimum=0, doc="How far the arms swing with the legs, by the distance between the feet ahead [rad/m]."
    )
    toe_off: float = param(
        0.0, minimum=0, maximum=0.6, unit="rad", doc="Pitch of a foot that leaves by its toe, in the longest step."
    )
    heel_strike: float = param(
        0.0, minimum=0, maximum=0.4, unit="rad", doc="Pitch of a foot that lands by its heel, in the longest step."
    )
    rise: float = param(
        0.0,
        minimum=0,
        maximum=0.1,
        unit="m",
        doc="How much higher the body is than standing, in the longest steps straight ahead: knees straighten.",
    )
    lunge: float = param(
        0.6, minimum=0, maximum=0.8, unit="rad", doc="Farthest lean of the trunk after a push that no step catches."
    )
    tilt_stiffness: float = param(300.0, minimum=0, doc="Stance hips against tilt of the base [Nm/rad].")
    tilt_damping: float = param(25.0, minimum=0, doc="Stance hips against tilt rate of the base [Nm s/rad].")


@dataclass(frozen=True, kw_only=True)
class WholeBodyConfig:
    """Weights and limits of whole-body inverse kinematics and of the arms' motion."""

    com: tuple[float, float, float] = param((20.0, 20.0, 10.0), doc="Cost of the centre of mass, x y z.")
    com_damping: float = param(
        2.0,
        minimum=0,
        doc="Damping of all joints by the square of the centre of mass' error, times its cost: a stretched leg does not"
        " chatter.",
    )
    foot_position: float = param(
        50.0, above=0, doc="Cost of the feet's positions; less for the place of one in the air."
    )
    foot_orientation: float = param(20.0, above=0, doc="Cost of the feet's orientations; less for one in the air.")
    base_orientation: float = param(5.0, above=0, doc="Cost of the pelvis' orientation.")
    torso_orientation: float = param(5.0, above=0, doc="Cost of the torso's orientation.")
    posture: float = param(0.3, above=0, doc="Cost of the home posture.")
    spin: float = param(
        0.0,
        minimum=0,
        doc="Cost of the angular momentum about the vertical: arms and trunk turn against legs that swing, and the foot"
        " on the ground need not hold them.",
    )
    hand: float = param(8.0, above=0, doc="Cost of a commanded hand's position.")
    hand_damping: float = param(
        20.0,
        minimum=0,
        doc="Damping of all joints by the square of a hand's error, times its cost: a stretched arm does not chatter.",
    )
    gaze: float = param(1.0, above=0, doc="Cost of the gaze's direction.")
    reach_height: float = param(0.3, minimum=0, doc="Cost of the centre of mass' height while reaching.")
    reach_torso: float = param(0.3, minimum=0, doc="Cost of the torso's orientation while reaching.")
    reach_base: float = param(2.0, minimum=0, doc="Cost of the pelvis' orientation while reaching.")
    walk_firmness: float = param(
        3.0, minimum=1, doc="Factor of the costs of pelvis and torso while it walks with a hand out."
    )
    walk_height_firmness: float = param(
        3.0, minimum=1, doc="Factor of the cost of the centre of mass' height while it walks with a hand out."
    )
    damping: float = param(1e-4, above=0, doc="Damping of the inverse kinematics.")
    hand_speed: float = param(0.4, above=0, unit="m/s", doc="Speed of a hand's reference.")
    hand_lead: float = param(
        0.08, above=0, unit="m", doc="Farthest a hand's reference is ahead of the planned hand: bounds its pull."
    )
    hand_orientation: float = param(1.5, above=0, doc="Cost of a commanded hand's orientation or direction.")
    hand_turn_speed: float = param(1.5, above=0, unit="rad/s", doc="Speed at which a hand's reference turns.")
    hand_turn_lead: float = param(
        0.3, above=0, unit="rad", doc="Farthest a hand's reference is turned ahead of the planned hand."
    )
    hand_integral: float = param(2.0, minimum=0, doc="Gain on a hand's measured error near its target [1/s].")
    hand_farthest: float = param(
        0.6,
        above=0,
        unit="m",
        doc="While it walks, a hand whose target is farther away than this is let go.",
    )
    hand_nearest: float = param(0.1, unit="m", doc="While it walks, a hand whose target is less far ahead is let go.")
    arm: float = param(8.0, above=0, doc="Cost of commanded arm joints.")
    arm_speed: float = param(1.5, above=0, unit="rad/s", doc="Speed of the references of commanded arm joints.")
    arm_lead: float = param(0.2, above=0, unit="rad", doc="Farthest these are ahead of the planned joint.")
    gaze_speed: float = param(1.5, above=0, unit="rad/s", doc="Speed of the gaze's reference.")
    gaze_yaw: float = param(2.35, above=0, unit="rad", doc="Farthest the gaze turns, with the torso's help.")
    gaze_below: float = param(
        0.5,
        minimum=0,
        unit="rad",
        doc="The trunk leans when what it looks at is this far below where the neck can point: out of view soon.",
    )
    gaze_lean: float = param(0.8, minimum=0, maximum=1, unit="rad", doc="Farthest the trunk leans for the gaze.")
    gaze_crouch: float = param(0.1, minimum=0, unit="m", doc="Farthest the body sinks for it when that is not enough.")
    height_speed: float = param(0.05, above=0, unit="m/s", doc="Speed of a posture's height change.")


@dataclass(frozen=True, kw_only=True)
class FallConfig:
    """When the robot counts as falling: drives are damped then."""

    tilt: float = param(0.9, above=0, unit="rad", doc="Tilt of the base.")
    height: float = param(0.6, above=0, maximum=1, doc="Height of the base as a share of its home height.")


@dataclass(frozen=True, kw_only=True)
class ContactConfig:
    """What the robot does when something touches its arms or its torso."""

    notice: float = param(8.0, above=0, unit="N", doc="An arm that is pushed harder than this is touched.")
    limit: float = param(25.0, above=0, unit="N", doc="An arm that is pushed harder than this yields.")
    torso: float = param(40.0, above=0, unit="N", doc="A torso that is pushed harder than this is touched.")
    lasting: float = param(0.5, above=0, unit="s", doc="Something that is in its way for this long stops the robot.")
    quiet: float = param(0.5, above=0, unit="s", doc="Time without contact after which an arm may be stiff again.")
    stiffness: float = param(
        0.05, minimum=0, maximum=1, doc="Position gain of an arm that yields, as a share of that of its drives."
    )


@dataclass(frozen=True, kw_only=True)
class CapsuleConfig:
    """A shape of a link: what is within a radius of the line between two points of it."""

    body: str = param(doc="Body that it belongs to.")
    start: tuple[float, float, float] = param(unit="m", doc="One end of the line, in the body's frame.")
    end: tuple[float, float, float] = param(unit="m", doc="Its other end; the same point makes a ball.")
    radius: float = param(above=0, unit="m", doc="Around the line.")


@dataclass(frozen=True, kw_only=True)
class CollisionConfig:
    """How the robot keeps its own links apart."""

    margin: float = param(0.035, above=0, unit="m", doc="Links are kept this far apart.")
    capsules: list[CapsuleConfig] = param(
        [], doc="Shapes of the links they name, instead of the model's; other links keep the model's collision shapes."
    )
    overlap: dict[str, list[str]] = param(
        {}, doc="Links whose shapes are in each other, and so do not touch: a body to others, as `exclude` in MJCF."
    )


Walk = Literal["dcm", "policy", "own"]
"""What can walk and balance."""


@dataclass(frozen=True, kw_only=True)
class BodyConfig:
    """What walks and balances."""

    walk: Walk = param(
        "dcm",
        doc="dcm: footsteps and whole-body control from the model; policy: a learned walker; own: your own class.",
    )
    policy: str | None = param(None, doc="Of a learned walker: its description, relative to this file.")
    own: str | None = param(None, doc="Of a body of your own: the Python file of its class, relative to this file.")


@dataclass(frozen=True, kw_only=True)
class RobotConfig:
    """A robot. Angles [rad], lengths [m], from ``robot.yaml``."""

    format: int = param(doc="Version of this file's form: 1.", minimum=1, maximum=1)
    name: str = param(doc="The robot's name.")
    description: str = param("", doc="One line for people.")
    model: str = param(doc="MJCF or URDF file, relative to this one; or robot_descriptions:NAME, of that package.")
    base: str = param(doc="Body with the free joint.")
    torso: str = param(doc="Body that carries the arms.")
    legs: dict[str, LegConfig] = param(doc="The legs: left and right.")
    sole: SoleConfig = param(doc="Shape of both soles.")
    hands: dict[str, HandConfig] = param({}, doc="Palms: left and right, one of them, or none.")
    gaze: GazeConfig = param(doc="The eyes, x ahead.")
    neck: NeckConfig | None = param(None, doc="Neck joints, if it has any.")
    drives: list[DriveConfig] = param(doc="Drives of all joints; the first group that matches a joint counts.")
    home: dict[str, float] = param(
        {}, unit="rad", doc="Home posture: joint pattern to angle, the first that matches counts; others 0."
    )
    groups: dict[str, list[str]] = param(
        {}, doc="Joint groups for plots: name to joint patterns, the first that matches counts."
    )
    soft_limit_margin: float = param(
        0.02,
        minimum=0,
        unit="rad",
        doc="Soft limits lie this far inside the model's, but at most a quarter of a joint's range.",
    )
    body: BodyConfig = param(BodyConfig(), doc="What walks and balances.")
    gait: GaitConfig = param(GaitConfig(), doc="How it walks.")
    whole_body: WholeBodyConfig = param(WholeBodyConfig(), doc="How the body shares its work.")
    reach_distance: float = param(0.40, above=0, unit="m", doc="Where to stand to reach: the target this far ahead.")
    walking_radius: float = param(
        0.38,
        above=0,
        unit="m",
        doc="It walks and turns within this circle around the middle between its feet, arms and sway included: so far"
        " away from obstacles it stays.",
    )
    sensors: SensorsConfig = param(SensorsConfig(), doc="What its sensors are like.")
    fall: FallConfig = param(FallConfig(), doc="When it counts as falling.")
    contact: ContactConfig = param(ContactConfig(), doc="What it does when something touches it.")
    collision: CollisionConfig = param(CollisionConfig(), doc="How it keeps its own links apart.")
    path: Path = field(default=Path(), compare=False)
    written: Item | None = field(default=None, compare=False, repr=False)

    @property
    def model_file(self) -> Path:
        """The MJCF file of its model.

        Raises:
            UserError: there is none.
        """
        return model_file(self.model, self.path.parent, self.place("model"))

    @property
    def resources(self) -> tuple[str, ...]:
        """What of :data:`~humanoid_bt.core.messages.RESOURCES` this robot has: what a skill can command of it.

        The view turns with the neck, or with the torso if that is not the base.
        """
        missing = {f"{side}_hand" for side in SIDES if side not in self.hands}
        if self.neck is None and self.torso == self.base:
            missing.add("gaze")
        return tuple(resource for resource in RESOURCES if resource not in missing)

    @property
    def feet_roll(self) -> bool:
        """Whether ankles tilt the feet sideways; where they do not, a foot lies as its leg leans."""
        return all(leg.ankle_roll is not None for leg in self.legs.values())

    def place(self, *keys: str | int) -> Place:
        """Return where a value is written, as in ``place("legs", "left", "sole")``, or what should hold it."""
        item = self.written
        if item is None:
            return Place(relative(self.path))
        for key in keys:
            try:
                item = item.value[key]
            except (KeyError, IndexError, TypeError):
                break
        return item.place

    def drive(self, joint: str) -> DriveConfig | None:
        """Return the drive of a joint, None if no group names it."""
        for drive in self.drives:
            if any(matches(joint, pattern) for pattern in drive.joints):
                return drive
        return None

    def home_key(self, joint: str) -> str | None:
        """Return the pattern in ``home`` that says a joint's angle, None if none does."""
        return next((pattern for pattern in self.home if matches(joint, pattern)), None)

    def home_angle(self, joint: str) -> float:
        """Return a joint's angle in the home posture [rad]."""
        key = self.home_key(joint)
        return 0.0 if key is None else self.home[key]

    def group(self, joint: str) -> str:
        """Return the plot group of a joint, ``other`` if none names it."""
        for name, patterns in self.groups.items():
            if any(matches(joint, pattern) for pattern in patterns):
                return name
        return "other"


def load_robot_config(path: Path) -> RobotConfig:
    """Read a ``robot.yaml``.

    Raises:
        UserError: with every problem found, each with its place.
    """
    item = document.load(path)
    problems: list[Problem] = []
    config: RobotConfig | None = None
    try:
        config = read(RobotConfig, item, "the robot")
    except UserError as error:
        problems += error.problems
    problems += _mistakes(item, path.parent)
    if config is None or problems:
        raise UserError(problems)
    if not config.feet_roll and config.sole.side_margin is None:
        config = dataclasses.replace(config, sole=dataclasses.replace(config.sole, side_margin=config.sole.half_width))
    return dataclasses.replace(config, path=path, written=item)


def _one_ankle_that_rolls(legs: Item | None) -> Iterator[Problem]:
    """Yield that one leg has an ankle_roll and the other one has none."""
    if legs is None or not isinstance(legs.value, dict):
        return
    rolls = {side: leg for side, leg in legs.value.items() if isinstance(leg.value, dict) and "ankle_roll" in leg.value}
    if len(legs.value) == len(SIDES) and len(rolls) == 1:
        ((side, leg),) = rolls.items()
        hint = "name the joint of the other leg, or leave it out for both if neither foot tilts sideways"
        yield Problem(f"only the {side} leg has an 'ankle_roll'", leg.place, hint, code="missing-key")


def _mistakes(item: Item, folder: Path) -> Iterator[Problem]:
    """Return what is wrong with its sides and its model, whatever else is."""
    parts = item.value if isinstance(item.value, dict) else {}
    for what in ("legs", "hands"):
        sides = parts.get(what)
        if sides is None or not isinstance(sides.value, dict) or (what == "hands" and not sides.value):
            continue
        missing = [side for side in SIDES if side not in sides.value] if what == "legs" else []
        if missing or not set(sides.value) <= set(SIDES):
            hint = f"{', '.join(missing)} is missing" if missing else "left and right, and no other"
            wanted = "the keys left and right" if what == "legs" else "the keys left and right, or one of them"
            yield Problem(f"{what!r} must have {wanted}", sides.place, hint, code="missing-key")
    yield from _one_ankle_that_rolls(parts.get("legs"))
    model = parts.get("model")
    if model is None or not isinstance(model.value, str):
        return
    try:
        # MuJoCo would wait for a pipe, or read for ever
        read_bytes(model_file(model.value, folder, model.place), _MAX_MODEL)
    except UserError as error:
        yield from error.problems
