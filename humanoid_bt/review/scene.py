"""What was going on at a moment of a run: nodes, command, percepts, joints, as rows of an explanation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from humanoid_bt.core.units import readable
from humanoid_bt.record.reading import AT
from humanoid_bt.record.tick import Tick
from humanoid_bt.review.body import Motion
from humanoid_bt.review.cause import Row
from humanoid_bt.review.history import History
from humanoid_bt.review.words import command, cut, mentions, reported, sight

_MOST = 3  # percepts, joints that are told
_RECENT = 0.2  # s before a moment in which joints are looked at
_COMMANDS = 1.0  # s before a moment in which the command in force was given
_NEAR = 0.02  # share of a joint's range from which on it is not near its limit


def command_in_force(history: History, time: float) -> str:
    """Return the command that control followed at a time [s], "" if there was none."""
    number = _number(history, time)
    if number < 0:
        return ""
    before: Tick | None = None
    for tick in history.log.ticks(time - _COMMANDS, time + AT):
        if tick.command is not None and tick.command.sequence == number:
            return command(number, tick.command.targets, tick.command.sources)
        before = tick
    if before is None or before.state.command_sequence != number:
        before = history.tick(time)
    return command(number, before.state.targets, before.state.command_sources) if before else f"#{number}"


def _number(history: History, time: float) -> int:
    servo = history.log.cycles("cycles", time - 0.05, time + AT, ["servo"]).columns["servo"]
    return int(servo[-1, 2]) if len(servo) else -1


def sight_rows(history: History, time: float, about: str) -> Iterator[Row]:
    """Yield what was known of the percepts that a text names, then of the freshest of the others, and how many more."""
    sights = sorted(history.sights(time), key=lambda seen: not mentions(about, seen.name))
    most = max(_MOST, sum(mentions(about, seen.name) for seen in sights))
    told = [sight(seen) for seen in sights[:most]]
    if len(sights) > most:
        told.append(f"and {len(sights) - most} more")
    for number, text in enumerate(told):
        yield "percepts" if number == 0 else "", text


def body_row(history: History, time: float) -> Row:
    """Return what the body did: gait, speed, tilt, height, load of the feet."""
    motion = Motion(history.log, time - 0.05, time + AT)
    tick = history.tick(time)
    gait = tick.state.gait.value if tick else ""
    if not len(motion.time):
        return "body", gait or "nothing is recorded of it"
    left, right = motion.foot_force[-1]
    tilt = readable(float(motion.tilt[-1]), "rad")
    base = f"{motion.speed[-1]:.2f} m/s, tilt {tilt}, base {motion.height[-1]:.2f} m high"
    return "body", f"{gait}, {base}, feet {left:z.0f} and {right:z.0f} N"


def hand_row(history: History, time: float) -> Row | None:
    """Return how far hands were from their targets, None if none was commanded."""
    tick = history.tick(time)
    if tick is None:
        return None
    turns = {side: f" and {readable(turn, 'rad')}" for side, turn in tick.state.hand_turn_errors.items()}
    errors = tick.state.hand_errors.items()
    told = [f"{side} {readable(error, 'm')}{turns.get(side, '')} from its target" for side, error in errors]
    return ("hands", ", ".join(told)) if told else None


def joint_loads(history: History, time: float) -> list[dict[str, Any]]:
    """Return what each joint bore in the moments before a time [s], the one nearest to a limit first.

    Returns:
        joint, torque and torque_limit [Nm], position, lower and upper [rad], load: largest share of a limit.
    """
    robot = history.setup["robot"]
    limits = robot["limits"]
    cycles = history.log.cycles("cycles", time - _RECENT, time + AT, ["position", "torque"])
    if not len(cycles.time):
        return []
    torque, position = cycles.columns["torque"], cycles.columns["position"][-1]
    peak = torque[np.abs(torque).argmax(axis=0), np.arange(torque.shape[1])]
    found = []
    for number, joint in enumerate(robot["joints"]):
        lower, upper = limits["lower"][number], limits["upper"][number]
        most = limits["torque"][number]
        load = abs(float(peak[number])) / most if most else 0.0
        if lower is not None and upper is not None and upper > lower:
            inside = min(position[number] - lower, upper - position[number]) / (upper - lower)
            load = max(load, 1.0 - max(float(inside), 0.0) / _NEAR if inside < _NEAR else 0.0)
        found.append(
            {
                "joint": joint,
                "load": round(load, 4),
                "torque": round(float(peak[number]), 3),
                "torque_limit": most,
                "position": round(float(position[number]), 5),
                "lower": lower,
                "upper": upper,
            }
        )
    return sorted(found, key=lambda joint: -joint["load"])


def joint_text(joint: dict[str, Any]) -> str:
    """Return what a joint bore, as a line."""
    limit = "" if joint["torque_limit"] is None else f" of {joint['torque_limit']:g}"
    text = f"{joint['joint']} {joint['torque']:z.1f}{limit} Nm"
    if joint["lower"] is not None and joint["upper"] is not None:
        bounds = f"{readable(joint['lower'], 'rad')} to {readable(joint['upper'], 'rad')}"
        text += f", at {readable(joint['position'], 'rad')} in {bounds}"
    return text


def node_rows(history: History, time: float) -> Iterator[Row]:
    """Yield the nodes that acted at a time [s], with what they said as they began and what they reported by then."""
    for number, change in enumerate(history.acting(time)[:_MOST]):
        told = [f"{change.path}  {history.place(change.path, time)}, since {change.time:.2f} s"]
        if change.said:
            told.append(f"at first: {change.said}")
        later = history.results(change.path, change.time + 2 * AT, time)
        if found := [results for _, results in later if results]:
            told.append(f"by then: {reported(found[-1])}")
        yield "nodes" if number == 0 else "", cut("; ".join(told), 240)
