"""The engines of a stage: loaded once, set back to the start for each run."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.sources import Sources
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, refuse_blind, sources_of
from humanoid_bt.perception.senses import new_perception
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene, SceneConfig, load_scene
from humanoid_bt.robot.config import Walk
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.loader import DEFAULT_ROBOT, DEFAULT_SCENE
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.dry import Dry
from humanoid_bt.tree.tree import Tree


class Ready(NamedTuple):
    """An engine at the start of a run.

    Attributes:
        engine: it.
        plant: what is simulated; None if no body is.
        bodies: those that can be pushed.
        robot, scene: the files.
    """

    engine: Engine
    plant: MujocoPlant | None
    bodies: list[str]
    robot: Path
    scene: Path


class Engines:
    """Makes engines ready, and keeps the one that was used last.

    Args:
        workspace: where names are looked up.
        robot, scene: names or paths; what each tree says if None.
        dry: whether they simulate no body.
        perception: the percept sources; what each tree or its scene says if None.
        body: what walks and balances; what ``robot.yaml`` says if None.
    """

    def __init__(
        self,
        workspace: Workspace,
        robot: str | None,
        scene: str | None,
        dry: bool,
        *,
        perception: Sources | None = None,
        body: Walk | None = None,
    ) -> None:
        self._workspace, self._robot, self._scene, self._dry = workspace, robot, scene, dry
        self._perception, self._body = perception, body
        self._files: dict[tuple[str, str], tuple[Path, SceneConfig]] = {}
        self._kept: tuple[object, Ready] | None = None

    def ready(self, tree: Tree, seed: int, conditions: Conditions) -> Ready:
        """Return an engine at the start of a tree's run.

        Raises:
            UserError: the robot or the scene has mistakes, or the run cannot have the conditions.
        """
        robot, config = self._load(
            self._robot or tree.robot or DEFAULT_ROBOT, self._scene or tree.scene or DEFAULT_SCENE
        )
        scene = Scene(conditions.seen(config), seed, conditions.floor)
        sources = sources_of(self._perception, tree.perception, config)
        chosen = choose(sources, self._workspace, config)
        if self._dry and sources is not None:
            refuse_blind(chosen, sources)
        by_chance = scene.floor.plates or any(thing.random is not None for thing in config.objects.values())
        # only another place of what stands in the scene, and another floor, need another model
        key = robot, config.path, None if self._dry else (scene.floor, seed if by_chance else None)
        if self._kept is None or self._kept[0] != key:
            self._close()
            self._kept = key, self._made(robot, scene)
        ready = self._kept[1]
        engine = ready.engine
        if refused := [problem for _, problem in conditions.refused(engine.robot, chosen, self._dry)]:
            raise UserError(refused)
        assert isinstance(engine, (Lockstep, Dry))
        if ready.plant is not None:
            ready.plant.alter(**conditions.of_body, encoders=conditions.encoders(engine.robot, seed))
        self._close()
        engine.reset(new_perception(chosen, engine.robot, scene, waits=True), scene)
        return ready

    def _close(self) -> None:
        """End what the last run looked with."""
        if self._kept is not None:
            engine = self._kept[1].engine
            assert isinstance(engine, (Lockstep, Dry))
            engine.perception.close()

    @property
    def plant(self) -> MujocoPlant | None:
        """The simulated plant as it is now, None if there is none."""
        return self._kept[1].plant if self._kept else None

    def _load(self, robot: str, scene: str) -> tuple[Path, SceneConfig]:
        """Return a robot's file and what a scene's file says, read once."""
        if (robot, scene) not in self._files:
            config = load_scene(self._workspace.find_scene(scene))
            self._files[robot, scene] = self._workspace.find_robot(robot), config
        return self._files[robot, scene]

    def _made(self, robot_file: Path, scene: Scene) -> Ready:
        robot, start = load_robot(robot_file, self._body)
        perception = SimulatedPerception(scene, scene.seed)  # until a run says what it sees with
        if self._dry:
            return Ready(Dry(robot, start, scene, perception), None, [], robot_file, scene.config.path)
        standing = scene.floor.under(start, scene.start_pose[2])
        engine = Lockstep(robot, standing, scene, perception)
        model = engine.plant.model
        bodies = [model.body(number).name for number in range(1, model.nbody)]
        return Ready(engine, engine.plant, bodies, robot_file, scene.config.path)
