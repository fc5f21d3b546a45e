"""Percept sources alone: shown pictures, scenes or what was recorded, without a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Percept, State
from humanoid_bt.core.odometry import truth_of
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, written
from humanoid_bt.perception.eyes import Eyes
from humanoid_bt.perception.picture import Picture
from humanoid_bt.perception.source import Moment, PerceptSource
from humanoid_bt.perception.source_files import whole_ticks
from humanoid_bt.perception.worker import looked
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.review.recording import open_recording
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.testing.scripted_perception import ScriptedPerception

_SEES = 1.745  # rad, from left to right of a picture that a test draws: as the head camera


class SourceRig:
    """Gives percept sources something to look at.

    The robot stands at the start of a scene, in its home posture.

    Args:
        workspace: where sources and scenes are found; the working directory if None.
        robot: name of the robot whose eyes they look with.

    Raises:
        UserError: the robot has mistakes.
    """

    def __init__(self, workspace: str | PathLike[str] | Workspace | None = None, robot: str = "humanoid") -> None:
        self.workspace = workspace if isinstance(workspace, Workspace) else Workspace(workspace)
        self._robot, self._start = load_robot(self.workspace.find_robot(robot))
        self._standing: dict[tuple[str, int], tuple[Scene, State]] = {}
        self._eyes: dict[tuple[str, int], Eyes] = {}

    def load(self, source: str, *, scene: str = "empty", seed: int = 0, **values: Any) -> SourceTrial:
        """Return a source, set up.

        Args:
            source: its name.
            scene: name or path of what surrounds the robot, for a source that needs it.
            seed: of its random numbers.
            values: its parameters, as in a scene file: 0.45, or text, "45 cm".

        Raises:
            UserError: there is no such source, scene or parameter, or a file in ``perception/`` has mistakes, or the
                source's own ``__init__`` raises.
        """
        sources = written({source: values})
        around, _ = self._stand(scene, seed)
        (chosen,) = choose(sources, self.workspace, around.config)
        made = chosen.make(chosen.name, around)
        made.setup()
        return SourceTrial(made, source)

    def moment(self, scene: str = "empty", *, seed: int = 0, time: float = 0.0, picture: bool = True) -> Moment:
        """Return everything there is to look at in a scene: state, truth, and the head camera's picture.

        Args:
            scene: its name or path.
            seed: of what it leaves to chance.
            time: engine time [s]; things are where its script says.
            picture: whether there shall be a picture.

        Raises:
            UserError: there is no such scene, or no OpenGL to render with.
        """
        around, standing = self._stand(scene, seed)
        state = replace(standing, time=time)
        truth, key = truth_of(state), (scene, seed)
        taken: Picture | None = None
        if picture:
            if key not in self._eyes:
                eyes = Eyes(self._robot, around)
                eyes.open()
                self._eyes[key] = eyes
            taken = self._eyes[key].look(truth, state)
        return Moment(time, state, taken, truth)

    def drawn(self, color: Any, depth: Any, *, time: float = 0.0, horizontal: float = _SEES) -> Moment:
        """Return a moment with a picture of your own, seen by the robot as it stands.

        Args:
            color: shape (height, width, 3), from 0 to 255.
            depth: along the camera's axis, shape (height, width), or one for all [m].
            time: engine time [s].
            horizontal: angle from the left to the right of the picture [rad].

        Raises:
            UserError: these are no such arrays.
        """
        colors, distances = _numbers(color, "color"), _numbers(depth, "depth")
        if colors.ndim != 3 or colors.shape[2] != 3:
            raise UserError(f"'color' has the shape {colors.shape}", hint="height x width x 3: red, green, blue")
        if not ((colors >= 0) & (colors <= 255)).all():
            raise UserError(f"'color' goes from {colors.min()} to {colors.max()}", hint="valid: from 0 to 255")
        pixels = colors.astype(np.uint8)
        try:
            depths = np.broadcast_to(distances.astype(np.float32), pixels.shape[:2])
        except ValueError:
            hint = f"one for each pixel, {pixels.shape[:2]}, or one for all"
            raise UserError(f"'depth' has the shape {distances.shape}", hint=hint) from None
        _, standing = self._stand("empty", 0)
        state = replace(standing, time=time)
        ahead = state.gaze_direction
        left = np.cross([0.0, 0.0, 1.0], ahead)
        left /= np.linalg.norm(left)
        base = rotation_matrix(state.base_quaternion)
        turn = np.stack([ahead, left, np.cross(ahead, left)], axis=1)
        focal = pixels.shape[1] / 2 / np.tan(horizontal / 2)
        eye = base.T @ (state.gaze_position - state.base_position)
        return Moment(time, state, Picture(pixels, depths, float(focal), eye, base.T @ turn), truth_of(state))

    def recorded(self, recording: str | PathLike[str]) -> Iterator[Moment]:
        """Yield the states of every tick of a recording, without pictures.

        Raises:
            UserError: there is no such recording.
        """
        for tick in open_recording(recording).every_tick():
            yield Moment(tick.state.time, tick.state, None, truth_of(tick.state))

    def close(self) -> None:
        """End the cameras."""
        for eyes in self._eyes.values():
            eyes.close()
        self._eyes.clear()

    def _stand(self, scene: str, seed: int) -> tuple[Scene, State]:
        """Return a scene, and the state of the robot that stands at its start."""
        key = scene, seed
        if key not in self._standing:
            around = Scene(load_scene(self.workspace.find_scene(scene)), seed)
            state, _ = Lockstep(self._robot, self._start, around, ScriptedPerception()).sense()
            self._standing[key] = around, state
        return self._standing[key]


def _numbers(values: Any, name: str) -> NDArray[Any]:
    """Return an array of numbers; raises UserError if they are none, or the rows have several lengths."""
    try:
        found = np.asarray(values)
    except ValueError:
        found = np.array(None)
    if found.dtype.kind not in "biuf":
        raise UserError(f"{name!r} is no array of numbers", hint="rows of one length")
    return found


class SourceTrial:
    """A source under test.

    Attributes:
        source: it.
        name: its name.
    """

    def __init__(self, source: PerceptSource, name: str) -> None:
        self.source, self.name = source, name
        self._never = set(source.names)

    def look(self, now: Moment) -> dict[str, Percept]:
        """Return what the source sees, by name; what it raises, it raises here.

        Raises:
            UserError: the moment lacks what the source needs.
            PerceptError: what it gives is no percept, or none of its own: a run would switch it off.
        """
        there = {"state": now.state, "camera": now.picture, "scene": now.truth}
        for need in self.source.needs:
            if there[need] is None:
                raise UserError(f"the source {self.name!r} needs the {need}, and this moment has none")
        found = {percept.name: percept for percept in looked(self.source, now, self._never).percepts}
        self._never -= set(found)
        return found

    def watch(self, moments: Iterable[Moment]) -> list[Percept]:
        """Return everything that the source sees in moments, of which it looks at those that are due."""
        period, due, found = whole_ticks(self.source.rate) * DECISION_PERIOD, -np.inf, list[Percept]()
        for now in moments:
            if now.time >= due - 1e-9:
                due = now.time + period
                found += self.look(now).values()
        return found
