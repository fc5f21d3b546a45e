"""The channels of a run, by name, in its folder; who writes which."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.link.estop import EStop
from humanoid_bt.link.heartbeat import Heartbeat
from humanoid_bt.link.ring import RingReader, RingWriter
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.realtime.timing import STOP_ROOM

if TYPE_CHECKING:
    from humanoid_bt.robot.config import Walk

_ESTOP, _LEFT, _MISTAKES, _LOST, _REAL, _OFF = "estop", "left", "mistakes.json", "lost", "real", "off.json"
_PICTURE, _PICTURES = "picture", 4  # ring -> its slots
_SIZES: dict[str, tuple[int, int]] = {  # ring -> (bytes in a slot, slots)
    "command": (16384, 8),  # decision -> control
    "request": (4096, 8),  # decision -> control: a stop, with source and reason
    "state": (16384, 16),  # control -> all; 80 ms at 200 Hz
    "truth": (4096, 8),  # plant -> perception, decision: where the simulated robot really is
    "percept": (16384, 8),  # perception -> decision
    "source": (4096, 256),  # perception -> decision: what happened to its sources
    "notice": (4096, 256),  # control -> decision: what happened
    "refusal": (1024, 256),  # control -> decision: commands that were refused
    "timing": (4096, 8),  # control -> all: how punctual it is
    "wake": (32, 4096),  # control -> all: every servo cycle, 4 s of them
    "stop": (STOP_ROOM, 64),  # control -> all: every stop, and when it began on the monotonic clock
    "status": (16384, 8),  # decision -> all: what the tree does
}

_GATEWAY_SIZES: dict[str, tuple[int, int]] = {
    "gateway_percept": (16384, 32),  # gateway -> decision, 50 Hz: what came from outside, and its sign of life
    "gateway_news": (4096, 64),  # gateway -> decision: what happened to it
    "gateway_estop_news": (4096, 64),  # the gateway's e-stop process -> decision, likewise
    "gateway_order": (4096, 64),  # gateway -> decision: goals, and that they are canceled
    "gateway_told": (4096, 256),  # decision -> gateway: what happened in the run
    "gateway_call": (16384, 64),  # decision -> gateway: what the tree asks of other programs
    "gateway_parameters": (65536, 4),  # decision -> gateway: the parameters of the tree, as they are now
    "gateway_setting": (4096, 64),  # gateway -> decision: parameters that are to be set
    "gateway_answer": (16384, 64),  # gateway -> decision: what is known of that
}

ABANDONED = 2
"""What the quit flag stands at, at least, when decision does not wait for control: who ends last cleans up."""


@dataclass(frozen=True)
class RunSpec:
    """What control and perception need to know of a run.

    Attributes:
        robot, scene: paths of ``robot.yaml`` and of the scene file.
        seed: of everything random.
        core: processor that control is pinned to, None for any.
        log: file in which control notes what happens, which stays when the folder is gone; "" for none.
        hold: how long control goes on balancing after decision died [s].
        parent: decision's process id. Each process compares its parent's with it: decision may die before they look.
        body: what walks and balances.
        perception: the percept sources as they are written; None for the simulated tracker.
        workspace: folder in which they are found.
        plant: where the plant is, if it is in another process: ``udp://HOST:PORT``; "" for the simulated one.
        key: file with the key for frames to it; "" for none.
        gateway: path of the gateway file, "" for none.
        joints: names of the robot's joints, for a gateway, which does not load the robot.
    """

    robot: str
    scene: str
    seed: int
    core: int | None
    log: str
    hold: float
    parent: int
    body: Walk = "dcm"
    perception: Any = None
    workspace: str = ""
    plant: str = ""
    key: str = ""
    gateway: str = ""
    joints: tuple[str, ...] = ()

    def write(self, folder: RunFolder) -> None:
        """Leave it in the run's folder."""
        folder.path("spec.json").write_text(json.dumps(asdict(self)), encoding="utf-8")

    @classmethod
    def read(cls, folder: RunFolder) -> Self:
        """Return what the owner of a run's folder left there."""
        return cls(**json.loads(folder.path("spec.json").read_text(encoding="utf-8")))


def create_channels(folder: RunFolder, **rooms: int) -> None:
    """Make every channel of a run, before its processes start.

    Args:
        folder: of the run.
        rooms: channel -> the most bytes that a message in it takes, where robot and scene decide that.
    """
    _create(folder, _SIZES, rooms)
    Heartbeat.create(folder.path("quit")).close()


def create_gateway_channels(folder: RunFolder, room: int) -> None:
    """Make the channels of a gateway, before it starts for the first time.

    Args:
        folder: of the run.
        room: the most bytes that its percepts take.
    """
    for name, (size, slots) in _GATEWAY_SIZES.items():
        RingWriter.create(folder.path(name), room if name == "gateway_percept" else size, slots).close()
    Heartbeat.create(folder.path("gateway_beat")).close()


def create_picture_channel(folder: RunFolder, room: int) -> None:
    """Make the channel of the head camera's pictures, perception -> gateway, before perception starts.

    Args:
        folder: of the run.
        room: the bytes that a picture takes.
    """
    RingWriter.create(folder.path(_PICTURE), room, _PICTURES).close()


def has_pictures(folder: RunFolder) -> bool:
    """Return whether anybody wants the head camera's pictures."""
    return folder.path(_PICTURE).exists()


def create_lockstep_channels(folder: RunFolder, **rooms: int) -> None:
    """Make the channels of a run in lockstep, whose loops need none: those for other terminals."""
    _create(folder, ("state", "status"), rooms)


def _create(folder: RunFolder, rings: Iterable[str], rooms: Mapping[str, int]) -> None:
    for name in rings:
        size, slots = _SIZES[name]
        RingWriter.create(folder.path(name), rooms.get(name, size), slots).close()
    EStop.create(folder.path(_ESTOP)).close()


def writer(folder: RunFolder, name: str) -> RingWriter:
    """Return the writing end of a ring."""
    return RingWriter.open(folder.path(name))


def reader(folder: RunFolder, name: str) -> RingReader:
    """Return a reading end of a ring."""
    return RingReader.open(folder.path(name))


def estop(folder: RunFolder, shared: bool = False) -> EStop:
    """Return an end of the e-stop; ``shared`` as in :meth:`EStop.open`."""
    return EStop.open(folder.path(_ESTOP), shared)


def cycle_tables(folder: RunFolder) -> tuple[Path, Path]:
    """Return where the tables of plans and of servo cycles are, if somebody wants them."""
    return folder.path("plans"), folder.path("cycles")


def gateway_beat(folder: RunFolder) -> Heartbeat:
    """Return the sign of life of the process that hears e-stops from outside."""
    return Heartbeat.open(folder.path("gateway_beat"))


def create_source_signs(folder: RunFolder, count: int) -> None:
    """Make the signs with which percept sources say that they are at work."""
    for number in range(count):
        Heartbeat.create(folder.path(f"source_{number}")).close()


def source_signs(folder: RunFolder, count: int) -> list[Heartbeat]:
    """Return the signs of percept sources, in their order: an odd one is at work."""
    return [Heartbeat.open(folder.path(f"source_{number}")) for number in range(count)]


def note_off(folder: RunFolder, off: Mapping[str, str]) -> None:
    """Note which percept sources are not to work any more, by label, and why."""
    folder.path(_OFF).write_text(json.dumps(off), encoding="utf-8")


def off_sources(folder: RunFolder) -> dict[str, str]:
    """Return which percept sources are not to work any more, by label, and why."""
    path = folder.path(_OFF)
    off: dict[str, str] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return off


def quit_flag(folder: RunFolder) -> Heartbeat:
    """Return the flag with which decision ends the run: it has beaten once, or :data:`ABANDONED` times."""
    return Heartbeat.open(folder.path("quit"))


def leave(folder: RunFolder) -> None:
    """Note that control ends, before it looks for the last time whether it is to clean up."""
    with suppress(OSError):  # the folder is gone, or there is no room
        folder.path(_LEFT).touch(mode=0o600)


def leave_mistakes(folder: RunFolder, error: UserError) -> None:
    """Note what keeps a process from beginning, for decision, which reads it when that has ended."""
    lines = [[one.message, one.place and asdict(one.place), one.hint, one.code] for one in error.problems]
    with suppress(OSError):
        folder.path(_MISTAKES).write_text(json.dumps(lines), encoding="utf-8")


def left_mistakes(folder: RunFolder) -> list[Problem]:
    """Return what kept a process from beginning."""
    try:
        lines = json.loads(folder.path(_MISTAKES).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return []
    return [Problem(message, place and Place(**place), hint, code) for message, place, hint, code in lines]


def note_lost(folder: RunFolder, why: str) -> None:
    """Note why control cannot go on, for decision, which reads it when control has ended."""
    with suppress(OSError):
        folder.path(_LOST).write_text(why, encoding="utf-8")


def why_lost(folder: RunFolder) -> str:
    """Return why control could not go on, "" if it did not say so."""
    try:
        return folder.path(_LOST).read_text(encoding="utf-8")
    except OSError:
        return ""


def note_real(folder: RunFolder) -> None:
    """Note that nobody knows where the robot really is: it is no simulation. Before its first state is told."""
    folder.path(_REAL).touch(mode=0o600)


def is_real(folder: RunFolder) -> bool:
    """Return whether the robot is no simulation."""
    return folder.path(_REAL).exists()


def has_left(folder: RunFolder) -> bool:
    """Return whether control may have looked for the last time: who abandons it after that cleans up."""
    return folder.path(_LEFT).exists()


def open_folder(path: str) -> RunFolder:
    """Return the folder of a run that another process made."""
    return RunFolder.open(Path(path))
