"""The process that hears e-stops of ROS 2, and nothing else: no other message is in their way.

It asks for realtime priority, below that of control, before there is any thread that could be without.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import ExitStack, suppress
from pathlib import Path

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Level
from humanoid_bt.gateway.estop import EStopEars
from humanoid_bt.gateway.file import load_gateway
from humanoid_bt.gateway.node import Ears, confine
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import Event, encode_event
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.schedule import Schedule

_PRIORITY = 60  # of SCHED_FIFO; control has 80


def run(folder: RunFolder) -> None:
    """Listen until decision ends the run or dies.

    Raises:
        UserError: ROS 2 or a type is not installed, or the file has mistakes.
    """
    spec = RunSpec.read(folder)
    config = load_gateway(Path(spec.gateway))
    if config.estop is None:
        return
    EStopEars.check(config.estop)
    confine(config.network)
    import rclpy  # noqa: PLC0415 (part of the extra)
    from rclpy.context import Context  # noqa: PLC0415

    news = channels.writer(folder, "gateway_estop_news")

    def note(level: Level, text: str) -> None:
        news.write(encode_event(Event(0.0, level, f"gateway: {text}")))

    beat, quit_flag = channels.gateway_beat(folder), channels.quit_flag(folder)
    schedule = Schedule(DECISION_PERIOD, spin=False)
    with ExitStack() as stack:
        context = Context()
        rclpy.init(args=[], context=context)
        stack.callback(context.try_shutdown)
        ears = Ears(context, f"{config.node}_estop", note)
        estop = channels.estop(folder)
        stack.callback(estop.close)
        EStopEars(ears, config.estop, estop, note)
        ears.begin()
        stack.callback(ears.end)
        while not quit_flag.count and os.getppid() == spec.parent:
            schedule.wait()
            ears.check()
            beat.beat()


def main() -> int:
    """Hear the e-stops of the run whose folder is the first argument."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's Ctrl-C is for decision
    if sys.platform == "linux":
        with suppress(OSError):  # without the privilege it works the same, and later under load
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    folder = channels.open_folder(sys.argv[1])
    try:
        run(folder)
    except UserError as error:
        channels.leave_mistakes(folder, error)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
