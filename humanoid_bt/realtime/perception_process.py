"""The perception process: the percept sources of a run, each at its rate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from humanoid_bt.core.messages import Level, State
from humanoid_bt.core.odometry import truth_of
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import (
    Event,
    SeenPicture,
    Sight,
    decode_state,
    decode_truth,
    encode_event,
    encode_percepts,
    encode_picture,
)
from humanoid_bt.perception.choice import Chosen, choose, simulated, written
from humanoid_bt.perception.interface import Perception
from humanoid_bt.perception.picture import Picture
from humanoid_bt.perception.senses import Show, new_perception
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.side_process import take_part, turns
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel

_BLIND = "sees only what is simulated: a real robot needs other percept sources"
_STATES = 64  # that are kept, to know what control believed at the time of a truth: 0.3 s


def run(folder: RunFolder) -> None:
    """Publish percepts until decision ends the run or dies.

    Raises:
        UserError: a source cannot begin.
    """
    spec = RunSpec.read(folder)
    real = channels.is_real(folder)
    scene = Scene(load_scene(Path(spec.scene)), spec.seed)
    chosen = choose(written(spec.perception), Workspace(spec.workspace), scene.config)
    blind = dict.fromkeys(simulated(chosen), _BLIND) if real else {}
    perception = _perception(spec, folder, scene, chosen, blind)
    perception.start()
    truths, percepts = channels.reader(folder, "truth"), channels.writer(folder, "percept")
    states, news = channels.reader(folder, "state"), channels.writer(folder, "source")
    past: deque[State] = deque(maxlen=_STATES)
    read = 0
    told: list[tuple[Level, str]] = [("warning", f"the percept source {label!r} {why}") for label, why in blind.items()]
    try:
        for _ in turns(folder, spec, perception.period):
            latest = (states if real else truths).latest()
            if latest is None:
                continue
            truth = truth_of(decode_state(latest[1])) if real else decode_truth(latest[1])
            if spec.perception is not None:
                entries, _ = states.since(read)
                past.extend(decode_state(payload) for _, payload in entries)
                read = entries[-1][0] if entries else read
            then = min(past, key=lambda state: abs(state.time - truth.time), default=None)
            seen = perception.observe(truth, then)
            percepts.write(encode_percepts(Sight(seen, perception.unseen)))
            for level, text in (*told, *perception.take_news()):
                news.write(encode_event(Event(truth.time, level, text)))
            told.clear()
    finally:
        perception.close()


def _shown(folder: RunFolder) -> Show:
    """Return what passes pictures on to the gateway."""
    ring = channels.writer(folder, "picture")

    def show(time: float, seen: Picture) -> None:
        picture = SeenPicture(time, seen.color, seen.depth, seen.focal, seen.position, seen.rotation)
        ring.write(encode_picture(picture))

    return show


def _perception(
    spec: RunSpec, folder: RunFolder, scene: Scene, chosen: Sequence[Chosen], blind: Mapping[str, str]
) -> Perception:
    if spec.perception is None and not blind:
        return SimulatedPerception(scene, spec.seed)  # it needs no robot, which takes a while to load
    robot = RobotModel(load_robot_config(Path(spec.robot)))
    show = _shown(folder) if channels.has_pictures(folder) else None
    marks, off = _marks(folder, len(chosen)), {**channels.off_sources(folder), **blind}
    return new_perception(chosen, robot, scene, waits=False, show=show, marks=marks, off=off)


def _marks(folder: RunFolder, count: int) -> list[Callable[[], None]]:
    """Return what tells decision that a source begins to work, and again that it has done it."""
    signs = channels.source_signs(folder, count)
    for sign in signs:
        sign.beat(sign.count % 2)  # one that was at work when this process was ended is not any more
    return [sign.beat for sign in signs]


if __name__ == "__main__":
    raise SystemExit(take_part(run))
