"""The ways through the house: a percept's from the plant to a skill, a command's from a skill to the plant."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import blocks

from house.rooms import PACKAGE


@dataclass(frozen=True)
class Step:
    """A step of a way.

    Attributes:
        file: where it is taken, from the package, or from the repository if it is not in the package.
        name: of what takes it, in that file.
        does: what happens there, in one sentence.
        between: whether it is taken between two processes, in realtime mode only.
    """

    file: str
    name: str
    does: str
    between: bool = False

    @property
    def path(self) -> Path:
        """The file."""
        inside = blocks.ROOT / PACKAGE / self.file
        return inside if inside.exists() else blocks.ROOT / self.file


PERCEPT = (
    Step("plant/scene.py", "Scene.object_position", "The scene's script says where the thing is now."),
    Step(
        "perception/simulated.py",
        "SimulatedPerception.observe",
        "Looks from where the robot's eyes really are: a `Percept`, in the base frame, with a confidence.",
    ),
    Step(
        "link/wire/percepts.py",
        "encode_percepts",
        "Realtime mode only: to bytes, through a ring in shared memory, and back in decision's process.",
        between=True,
    ),
    Step("session/engine.py", "Engine.sense", "Gives decision the state, and the latest percept of each name."),
    Step("tree/ticking/executor.py", "Executor.tick", "Begins a tick, all of which sees this one snapshot."),
    Step(
        "decision/robot.py",
        "Robot.begin_tick",
        "Places the percept in the world, with the base pose of the moment in which it was seen.",
    ),
    Step(
        "perception/track.py",
        "Track",
        "Answers what is asked of it: its age, its distance and bearing from where the robot stands now.",
    ),
    Step(
        "tree/expressions/vocabulary.py",
        "PERCEPT",
        "What a tree calls these: `distance(target)`, `target.confidence`, each with its unit.",
    ),
    Step(
        "tree/nodes/conditions.py",
        "Condition.update",
        "Compares, with hysteresis, and so decides which branch gets its turn.",
    ),
    Step("skills/reach.py", "Reach.update", "Asks for the same track, and aims at it."),
)
"""From what is there to the skill that acts on it."""

COMMAND = (
    Step("skills/reach.py", "Reach.update", "Sets a target for a hand, in every tick anew."),
    Step(
        "decision/robot_handle.py",
        "RobotHandle.move_hand",
        "Keeps it until the tick ends, in the node's name; a node that is halted gives it back.",
    ),
    Step(
        "tree/ticking/executor.py",
        "Executor.tick",
        "Ends the tick: what the living nodes ask for becomes one `Command`, with one owner per resource.",
    ),
    Step("session/engine.py", "Engine.submit", "Hands it to control; it is also decision's sign of life."),
    Step(
        "link/wire/command.py",
        "encode_command",
        "Realtime mode only: to bytes, through a ring in shared memory, and back in control's process.",
        between=True,
    ),
    Step(
        "control/supervisor.py",
        "Supervisor.submit",
        "Takes it if it is intact, fresh and in order; says in every servo cycle whether it is followed.",
    ),
    Step(
        "control/controller.py",
        "Controller.run_cycle",
        "One servo cycle: supervise, every tenth time plan the whole body, drive the joints, hear the sensors.",
    ),
    Step(
        "control/body/whole_body.py",
        "WholeBody.update",
        "Plans steps, balance, hands and gaze, and from them a setpoint for every joint.",
    ),
    Step(
        "control/servo.py",
        "Servo.follow",
        "Clamps the setpoint into soft limits, speed and torque limits: a `JointCommand`.",
    ),
    Step("plant/mujoco_plant.py", "MujocoPlant.step", "Drives the joints for one millisecond."),
)
"""From the skill that wants something to the joints that move."""
