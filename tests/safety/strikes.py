"""What chaos does to a run: faults that pass, after which it goes on, and ends. Each says what must follow."""

from __future__ import annotations

import os
import resource
import signal
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.safety.background import load
from tests.safety.victim import Victim

Strike = Callable[[Victim, np.random.Generator], None]
"""Does it, and sees that what is promised follows; random numbers are drawn from its own seed."""


@dataclass(frozen=True)
class Fault:
    """A fault that passes: the run goes on.

    Attributes:
        name: what happens.
        strike: does it.
        roles: the parts that it needs alive.
        ends: those that are gone afterwards.
    """

    name: str
    strike: Strike
    roles: tuple[str, ...] = ()
    ends: tuple[str, ...] = ()


@dataclass(frozen=True)
class Ending:
    """What ends a run.

    Attributes:
        name: what happens.
        strike: does it.
        codes: exit codes of the run's program, one of which must follow; negative for a signal.
        kinds: causes, one of which ``explain`` must name; none: that of the stop it was in, or that it was ended.
        robot: whether control brings the robot to a stand.
    """

    name: str
    strike: Strike
    codes: tuple[int, ...]
    kinds: tuple[str, ...] = ()
    robot: bool = True


# ---- faults that pass -----------------------------------------------------------------------------------------------


def estop_and_reset(victim: Victim, rng: np.random.Generator) -> None:
    _estop(victim)
    victim.passes(rng.uniform(0, 1))
    _reset(victim)


def decision_stopped(victim: Victim, rng: np.random.Generator) -> None:
    with victim.held("decision"):
        victim.shows("protective_stop")
        victim.passes(rng.uniform(0, 1.5))
    victim.shows("run")


def estop_while_decision_is_stopped(victim: Victim, rng: np.random.Generator) -> None:
    with victim.held("decision"):
        victim.passes(rng.uniform(0, 0.5))
        _estop(victim)
    _reset(victim)


def decision_stutters(victim: Victim, rng: np.random.Generator) -> None:
    for _ in range(15):
        with victim.held("decision"):
            victim.passes(rng.uniform(0.01, 0.2))
        victim.passes(rng.uniform(0.01, 0.1))
    victim.shows("run")


def stopped(role: str, least: float, most: float) -> Strike:
    """Stop a process that the robot does not need for so long [s]."""

    def strike(victim: Victim, rng: np.random.Generator) -> None:
        with victim.held(role):
            victim.passes(rng.uniform(least, most))
        victim.shows("run")

    return strike


def killed(role: str, told: str) -> Strike:
    """Kill a process that the robot does not need; the run tells it."""

    def strike(victim: Victim, _: np.random.Generator) -> None:
        victim.kill(role)
        victim.gone.add(role)
        if told:
            victim.tells(told)
        victim.shows("run")

    return strike


def recorder_killed(victim: Victim, rng: np.random.Generator) -> None:
    victim.lossy = victim.cut = True
    killed("recorder", "the recorder process ended (killed by signal 9): nothing is recorded from")(victim, rng)


def no_room(victim: Victim, rng: np.random.Generator) -> None:
    """Let no file of the recorder grow beyond a size that it reaches soon."""
    victim.lossy = victim.cut = True
    size = victim.recording.stat().st_size + int(rng.integers(1, 200_000))
    resource.prlimit(victim.pid("recorder"), resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    victim.tells("is cut short: files may have")
    victim.shows("run")


def starved(role: str) -> Strike:
    """Give a process what the others leave, while the machine is busy; it keeps the low priority."""

    def strike(victim: Victim, rng: np.random.Generator) -> None:
        os.setpriority(os.PRIO_PROCESS, victim.pid(role), 19)
        with load("cpu"):
            victim.passes(rng.uniform(0.5, 3))
        victim.shows("run")

    return strike


def busy(name: str) -> Strike:
    """Have the machine busy for a while."""

    def strike(victim: Victim, rng: np.random.Generator) -> None:
        with load(name):
            victim.passes(rng.uniform(0.5, 3))
        victim.shows("run")

    return strike


FAULTS = [
    Fault("e-stop from another terminal, reset", estop_and_reset),
    Fault("decision stopped for up to 1.5 s", decision_stopped),
    Fault("decision stopped, e-stop meanwhile, reset", estop_while_decision_is_stopped),
    Fault("decision stopped 15 times for up to 0.2 s", decision_stutters),
    Fault("decision starved", starved("decision")),
    Fault("control stopped for up to 0.6 s", stopped("control", 0.005, 0.6)),
    Fault("perception stopped for up to 2 s", stopped("perception", 0.1, 2.0), ("perception",)),
    Fault("perception starved", starved("perception"), ("perception",)),
    Fault(
        "perception killed",
        killed("perception", "the perception process ended (killed by signal 9)"),
        ("perception",),
        ("perception",),
    ),
    Fault("recorder stopped for up to 3 s", stopped("recorder", 0.1, 3.0), ("recorder",)),
    Fault("recorder starved", starved("recorder"), ("recorder",)),
    Fault("recorder killed", recorder_killed, ("recorder",), ("recorder", "camera")),
    Fault("recorder may write no more (ulimit -f)", no_room, ("recorder",), ("recorder", "camera")),
    Fault("camera stopped for up to 2 s", stopped("camera", 0.1, 2.0), ("camera",)),
    Fault("camera killed", killed("camera", ""), ("camera",), ("camera",)),
    Fault("every core busy for up to 3 s", busy("cpu")),
    Fault("every core busy, memory too, for up to 3 s", busy("cpu and memory")),
]


# ---- ends -----------------------------------------------------------------------------------------------------------


def signalled(number: signal.Signals, times: int = 1) -> Strike:
    def strike(victim: Victim, rng: np.random.Generator) -> None:
        victim.lossy |= times > 1  # nobody waits for the recorder then, which writes on
        victim.process.send_signal(number)
        for _ in range(times - 1):
            victim.passes(rng.uniform(0, 0.3))
            victim.process.send_signal(number)

    return strike


def estop_and_ctrl_c(victim: Victim, rng: np.random.Generator) -> None:
    _estop(victim)
    victim.passes(rng.uniform(0, 1))
    victim.process.send_signal(signal.SIGINT)


def ended(*roles: str, number: signal.Signals = signal.SIGKILL) -> Strike:
    """Send a signal to one process after the other, at once."""

    def strike(victim: Victim, rng: np.random.Generator) -> None:
        victim.gone.update(roles)
        victim.lossy |= "recorder" in roles
        pids = [process.pid for process in victim.processes() if process.role in roles]
        for pid in rng.permutation(pids):
            os.kill(int(pid), number)

    return strike


def killed_while_stopped(victim: Victim, rng: np.random.Generator) -> None:
    victim.kill("decision", signal.SIGSTOP)
    victim.passes(rng.uniform(0, 0.5))
    ended("decision")(victim, rng)


def recorder_stopped_for_good(victim: Victim, rng: np.random.Generator) -> None:
    victim.lossy = True
    if "recorder" not in victim.gone:
        victim.kill("recorder", signal.SIGSTOP)
    victim.passes(rng.uniform(0, 2))
    victim.process.send_signal(signal.SIGINT)


_ALL = ("decision", "control", "perception", "recorder", "camera")

ENDINGS = [
    Ending("Ctrl-C", signalled(signal.SIGINT), (130,)),
    Ending("Ctrl-C twice", signalled(signal.SIGINT, 2), (130,)),
    Ending("SIGTERM", signalled(signal.SIGTERM), (130,)),
    Ending("terminal closed (SIGHUP)", signalled(signal.SIGHUP), (130,)),
    Ending("e-stop from another terminal, Ctrl-C", estop_and_ctrl_c, (3,), ("estop",)),
    Ending("decision killed", ended("decision"), (-9,), ("killed",)),
    Ending("decision stopped, then killed", killed_while_stopped, (-9,), ("killed",)),
    Ending("decision and perception killed", ended("decision", "perception"), (-9,), ("killed",)),
    Ending("decision and recorder killed", ended("decision", "recorder"), (-9,), ("cut",)),
    Ending("control killed", ended("control"), (4,), ("control",), robot=False),
    Ending("control stopped for good", ended("control", number=signal.SIGSTOP), (4,), ("control",), robot=False),
    Ending("control told to end (SIGTERM)", ended("control", number=signal.SIGTERM), (4,), ("control", "stop")),
    Ending("all processes killed", ended(*_ALL), (-9,), ("cut",), robot=False),
    Ending("recorder stopped for good, Ctrl-C", recorder_stopped_for_good, (130,), ("cut",)),
]


def _estop(victim: Victim) -> None:
    done = victim.terminal("estop", "--run", victim.run_id, "--reason", "chaos")
    assert done.returncode == 0 and "emergency stop" in done.stdout, f"estop said {done.stdout}{done.stderr}"
    victim.shows("emergency_stop")


def _reset(victim: Victim) -> None:
    done = victim.terminal("reset", "--run", victim.run_id)
    assert done.returncode == 0 and done.stdout.startswith("reset"), f"reset said {done.stdout}{done.stderr}"
    victim.shows("run")
