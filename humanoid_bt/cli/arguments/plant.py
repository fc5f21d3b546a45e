"""The arguments of ``humanoid-bt plant``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cable.address import PORT
from humanoid_bt.cable.safe_state import SAFE_STATES, WATCHDOG
from humanoid_bt.cli.arguments.numbers import PERCENT, TIME, number
from humanoid_bt.cli.arguments.parsing import Commands, add_workspace
from humanoid_bt.session.limits import SEED, Limit

_EXAMPLES = f"""\
examples:
  humanoid-bt plant humanoid --scene ball_on_stand
  humanoid-bt run fetch --plant udp://127.0.0.1:{PORT}      in another terminal
  humanoid-bt plant humanoid --latency 1ms --jitter 1ms --loss 1
  humanoid-bt plant humanoid --listen 0.0.0.0 --key plant.key
"""

_WATCHDOG = Limit(float, "a time from 0.002 to 1 s", lambda value: 0.002 <= value <= 1, "s")


def add_plant(commands: Commands) -> None:
    """Declare ``plant``."""
    plant = commands.add(
        "plant",
        "serve a simulated robot to control in another process",
        "Simulate a robot, and let control that runs in another process, or on another machine, drive it: joint "
        "commands in, sensors out, as of a real robot behind a cable. It begins anew for every driver.",
        _EXAMPLES,
    )
    plant.add_argument("robot", metavar="ROBOT", help="name or folder of a robot")
    plant.add_argument("--scene", default="empty", metavar="S", help="name or file of a scene; default: empty")
    plant.add_argument(
        "--listen",
        default=f"127.0.0.1:{PORT}",
        metavar="ADDRESS",
        help=f"where drivers find it, HOST or HOST:PORT; default: 127.0.0.1:{PORT}; any other than this machine's own "
        "needs a key",
    )
    plant.add_argument("--key", type=Path, metavar="FILE", help="key with which every frame is sealed, on both sides")
    plant.add_argument(
        "--watchdog",
        type=number(_WATCHDOG),
        default=WATCHDOG,
        metavar="T",
        help="silence of the driver after which the robot goes to its safe state; default: 20ms",
    )
    plant.add_argument(
        "--safe",
        choices=SAFE_STATES,
        default="hold",
        metavar="STATE",
        help="the safe state: hold the last position (default), or damp: let go, and only brake",
    )
    plant.add_argument(
        "--latency", type=number(TIME), default=0.0, metavar="T", help="time that every frame takes; default: 0"
    )
    plant.add_argument(
        "--jitter", type=number(TIME), default=0.0, metavar="T", help="time that it takes longer at most; default: 0"
    )
    plant.add_argument(
        "--loss", type=number(PERCENT), default=0.0, metavar="P", help="percentage of frames that get lost; default: 0"
    )
    plant.add_argument("--seed", type=number(SEED), default=0, metavar="N", help="of jitter and loss; default: 0")
    add_workspace(plant)
