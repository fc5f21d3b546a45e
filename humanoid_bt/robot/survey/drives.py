"""What a model says of its joints' drives: gains and limits of actuators, limits of joints."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco

from humanoid_bt.core.messages import Array
from humanoid_bt.core.texts import listed
from humanoid_bt.robot.model import LEAST_DAMPING
from humanoid_bt.robot.survey.limbs import Limbs, Surveyor, roles

_STIFFNESS, _DAMPING = 4.0, 0.04  # 1/rad, of the torque; s, of the stiffness: what arms that reach have
_TORQUE = 20.0  # Nm, where nothing says it
_LIMP = 0.15  # of what a joint has that carries a robot: with less nothing stands
_USUAL_TORQUE = 0.2  # rad, times the stiffness: likewise of joints that carry the robot
_NAMED = 4  # joints at most; more are counted
_GRAVITY = 9.81
_AT_JOINT = mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT  # the same for a hinge
_BIAS = 1, 2  # numbers of an actuator's bias that are stiffness and damping
# of the weight times the height of the centre of mass, which is how stiff a support must be not to buckle
_HIP_OR_KNEE, _ANKLE, _TRUNK = 2.4, 1.3, 1.5
_PLACEHOLDER = 20.0  # of the same, as a torque: no joint has so much, and a model that says it does not know


@dataclass(frozen=True)
class Drive:
    """A joint's drive.

    Attributes:
        stiffness, damping: [Nm/rad], [Nm s/rad].
        torque: limit [Nm].
        guessed: which of these the model does not say.
    """

    stiffness: float
    damping: float
    torque: float
    guessed: tuple[str, ...] = ()


def falling(surveyor: Surveyor, limbs: Limbs, height: float) -> float:
    """Return the weight of a robot times the height of its centre of mass as it stands [Nm]."""
    return float(surveyor.model.body_subtreemass[limbs.base]) * _GRAVITY * height


def usual_stiffness(surveyor: Surveyor, limbs: Limbs, falls: float) -> dict[int, float]:
    """Return how stiff the joints that carry the robot are in robots that walk, joint -> [Nm/rad].

    Args:
        surveyor: of the model.
        limbs: the robot's.
        falls: as :func:`falling` says [Nm].
    """
    found = dict.fromkeys(limbs.trunk, _TRUNK * falls)
    for leg in limbs.legs.values():
        ankles = [joint for role, joint in roles(surveyor, leg) if role.startswith("ankle")]
        found |= {joint: (_ANKLE if joint in ankles else _HIP_OR_KNEE) * falls for joint in leg.joints}
    return found


def without_limits(model: mujoco.MjModel) -> str:
    """Return which joints have no limits, "" if all have some."""
    hinges = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE]
    names = [repr(model.joint(j).name) for j in hinges if not model.jnt_limited[j]]
    if not names:
        return ""
    which = listed(names) if len(names) <= _NAMED else f"{len(names)} of {len(hinges)} joints"
    have, them = ("has", "it") if len(names) == 1 else ("have", "them")
    return f"{which} {have} no limits: control turns {them} as far as it likes"


def drive(model: mujoco.MjModel, joint: int, usual: float | None, falls: float) -> Drive:
    """Return what the model says of a joint's drive, and guesses for what it does not.

    Actuators of one joint add up; one without a limit of its own is held to those of the others.

    Args:
        model: of the robot.
        joint: of it.
        usual: how stiff such a joint is if it carries the robot, None if it does not [Nm/rad].
        falls: as :func:`falling` says [Nm].
    """
    actuators = [
        a
        for a in range(model.nu)
        if mujoco.mjtTrn(model.actuator_trntype[a]) in _AT_JOINT and model.actuator_trnid[a, 0] == joint
    ]
    guessed: list[str] = []
    torques = [torque for a in actuators if (torque := _torque(model, a)) < math.inf]
    torque = sum(torques) if torques else math.inf
    if model.jnt_actfrclimited[joint]:
        torque = min(torque, _both_ways(model.jnt_actfrcrange[joint]))
    if not 0 < torque < _PLACEHOLDER * falls:
        torque = _TORQUE if usual is None else _rounded(_USUAL_TORQUE * usual)
        guessed.append("torque")
    stiffness, damping = (sum(_gain(model, a, of) for a in actuators) for of in _BIAS)
    own = float(model.dof_damping[model.jnt_dofadr[joint]].max())
    if stiffness > 0 and damping <= 0 and own > LEAST_DAMPING:
        damping = own  # which stands for the actuator's
    if stiffness <= 0 or (usual is not None and stiffness < _LIMP * usual):
        damping = 0.0  # as those of models whose learned walker brings its own gains
        stiffness = _rounded(_STIFFNESS * torque if usual is None else usual)
        guessed.append("stiffness")
    if damping <= 0:
        damping = _rounded(_DAMPING * stiffness)
        guessed.append("damping")
    return Drive(stiffness, damping, torque, tuple(guessed))


def _gain(model: mujoco.MjModel, actuator: int, of: int) -> float:
    """Return a gain of an actuator at its joint, which its gear multiplies twice: as it turns, and as it pulls.

    Only an affine bias has gains: MuJoCo ignores the numbers of another one.

    Args:
        model: of the robot.
        actuator: of it.
        of: one of :data:`_BIAS`.
    """
    if model.actuator_biastype[actuator] != mujoco.mjtBias.mjBIAS_AFFINE:
        return 0.0
    return -float(model.actuator_biasprm[actuator, of]) * float(model.actuator_gear[actuator, 0]) ** 2


def _torque(model: mujoco.MjModel, actuator: int) -> float:
    """Return the largest torque of an actuator, inf if nothing limits it [Nm]."""
    gear = abs(float(model.actuator_gear[actuator, 0]))
    limits = [math.inf]
    if model.actuator_forcelimited[actuator]:
        limits.append(_both_ways(model.actuator_forcerange[actuator]))
    if model.actuator_ctrllimited[actuator] and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE:
        limits.append(_both_ways(model.actuator_ctrlrange[actuator]) * abs(float(model.actuator_gainprm[actuator, 0])))
    return gear * min(limits)


def _both_ways(limits: Array) -> float:
    """Return how large what has a lower and an upper limit may be either way, shape (2,)."""
    return float(min(-limits[0], limits[1]))


def _rounded(value: float) -> float:
    """Round to two digits: nobody shall take a guess for a measurement."""
    return float(f"{value:.2g}")
