"""One run that is struck as planned, and one beside it that is not."""

from __future__ import annotations

import contextlib
import traceback
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from humanoid_bt.core.texts import shortened
from tests.safety import promises
from tests.safety.background import load
from tests.safety.plans import TREES, Plan
from tests.safety.processes import Life, Watch
from tests.safety.strikes import ENDINGS
from tests.safety.victim import OverError, Victim

_LONGEST = 600  # characters of a problem; the whole of it is in the trial's folder


@dataclass
class Trial:
    """What became of a plan.

    Attributes:
        plan: what was planned.
        folder: with the recording, what it printed and what control noted.
        struck: which faults were made, in order, with the engine time of each [s].
        problem: what was not as promised, "" if all was.
        lives: the memory of its processes, by their ids.
        stops: protective stops that came because decision was silent, each in its servo cycle.
    """

    plan: Plan
    folder: Path
    struck: list[tuple[str, float]] = field(default_factory=list)
    problem: str = ""
    lives: dict[int, Life] = field(default_factory=dict)
    stops: int = 0


def tried(plan: Plan, folder: Path, links: Path) -> Trial:
    """Do what is planned to a run, and look at everything that is promised.

    Args:
        plan: what is done.
        folder: where the trial gets a folder.
        links: where runs have their links; this process keeps itself apart with it.
    """
    trial = Trial(plan, folder / f"{plan.number:04d}")
    with load(plan.load), _guarded(trial, links) as victim:
        _end(trial, victim)
    return trial


@contextlib.contextmanager
def bystander(seed: int, folder: Path, links: Path) -> Iterator[Trial]:
    """Have a run beside all others that nobody strikes: nothing may happen to it, and its memory shows every leak."""
    trial = Trial(Plan(seed, -1, "stand", "no", False, (), (0.0, ENDINGS[0])), folder / "bystander")
    with _guarded(trial, links, "--record-part-size", "50MB") as victim:
        yield trial
        _end(trial, victim)


@contextlib.contextmanager
def _guarded(trial: Trial, links: Path, *options: str) -> Iterator[Victim]:
    """Have a run whose memory is watched, and nothing of which is left; what goes wrong stands in the trial."""
    plan = trial.plan
    camera = "on" if plan.camera else "off"
    seed = str(max(plan.number, 0))
    victim = Victim(trial.folder, links, plan.tree, *TREES[plan.tree], "--seed", seed, "--camera", camera, *options)
    try:
        with Watch(victim.mark) as watch:
            trial.lives = watch.lives
            yield victim
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        told = shortened(str(error) or type(error).__name__, _LONGEST)
        trial.problem = f"{told} ({Path(where.filename).name}:{where.lineno})"
    finally:
        victim.destroy()


def _end(trial: Trial, victim: Victim) -> None:
    """Strike, wait for the end, and look at everything."""
    victim.ready()
    try:
        _strike(trial, victim)
    except (OverError, ProcessLookupError, AssertionError):
        if not victim.succeeded:
            raise
    code, ending = victim.over(), trial.plan.ending[1]
    promises.nothing_left(victim)
    promises.ended_as_told(victim, code, (0, *ending.codes) if victim.succeeded else ending.codes)
    if ending.robot:
        promises.stands(victim)
    if code < 0 and "control" not in victim.gone and not victim.succeeded:
        promises.held_without_decision(victim)
    log = promises.recorded(victim)
    trial.stops = promises.silence_in_time(victim, log)
    promises.explained(victim, ending)
    promises.memory_bounded(trial.lives)


def _strike(trial: Trial, victim: Victim) -> None:
    """Make the planned faults."""
    plan = trial.plan
    for index, (after, fault) in enumerate([*plan.faults, plan.ending]):
        victim.passes(after)
        trial.struck.append((fault.name, victim.state.time))
        fault.strike(victim, plan.strength(index))
