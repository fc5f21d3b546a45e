"""The process that hears e-stops of ROS 2, and nothing else: no other message is in their way.

It asks for realtime priority, below that of control, before there is any thread that could be without.
"""

from __future__ import annotations

import os
import sys
from contextlib import ExitStack, suppress
from pathlib import Path

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import Level
from humanoid_bt.gateway.estop import EStopEars
from humanoid_bt.gateway.file import load_gateway
from humanoid_bt.gateway.node import Ears, confine
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import Event, encode_event
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.side_process import take_part, turns

_PRIORITY = 60  # of SCHED_FIFO; control has 80


def run(folder: RunFolder) -> None:
    """Listen until decision ends the run or dies.

    Raises:
        UserError: ROS 2 or a type is not installed, or the file has mistakes.
    """
    if sys.platform == "linux":
        with suppress(OSError):  # without the privilege it works the same, and later under load
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    spec = RunSpec.read(folder)
    config = load_gateway(Path(spec.gateway))
    if config.estop is None:
        return
    EStopEars.check(config.estop)
    confine(config.network)
    import rclpy  # noqa: PLC0415 (part of the extra)
    from rclpy.context import Context  # noqa: PLC0415 (likewise)

    news = channels.writer(folder, "gateway_estop_news")

    def note(level: Level, text: str) -> None:
        news.write(encode_event(Event(0.0, level, f"gateway: {text}")))

    beat = channels.gateway_beat(folder)
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
        for _ in turns(folder, spec, DECISION_PERIOD):
            ears.check()
            beat.beat()


if __name__ == "__main__":
    raise SystemExit(take_part(run))
