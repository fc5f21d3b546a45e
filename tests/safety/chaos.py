"""Runs on the wall clock whose processes are killed, stopped and starved at random moments, for as long as you like.

python -m tests.safety.chaos --minutes 30
"""

from __future__ import annotations

import argparse
import collections
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import FrameType

from tests.realtime import helpers
from tests.safety.apart import keep_apart
from tests.safety.plans import planned
from tests.safety.processes import Life
from tests.safety.strikes import ENDINGS, FAULTS
from tests.safety.trial import Trial, bystander, tried

_PATIENCE = 180.0  # s that anything may take on a machine that is kept busy

_EPILOG = """\
Each run is one of a built-in tree in realtime mode, in a folder of its own for links: other runs on this machine are
not touched. Afterwards everything is looked at that docs/safety.md promises; a further run stands by all the time.

exit codes:
  0  all was as promised
  1  something was not; its recording and how to repeat it are printed
"""


def soak(seed: int, numbers: Iterable[int], folder: Path, links: Path, until: float) -> Iterator[Trial]:
    """Yield one trial after the other, until a time on the monotonic clock [s]; the bystander's is the last one.

    None is begun that would last longer than until then, if it took as long as the longest one so far.
    """
    camera, longest = _renders(folder), 0.0
    with bystander(seed, folder, links) as beside:
        for number in numbers:
            began = time.monotonic()
            if began + longest >= until:
                break
            yield tried(planned(seed, number, camera), folder, links)
            longest = max(longest, time.monotonic() - began)
    yield beside


def _renders(folder: Path) -> bool:
    """Whether pictures of the head camera can be taken here."""
    line = [*helpers.PROGRAM, "run", "stand", "--duration", "0.1", "--camera", "on", "--no-view"]
    done = subprocess.run(line, capture_output=True, text=True, check=False, cwd=folder)
    return "no OpenGL" not in done.stderr


def table(trials: Iterable[Trial]) -> str:
    """Return how often each fault was made, and how often all was as promised then."""
    made: collections.Counter[str] = collections.Counter()
    bad: collections.Counter[str] = collections.Counter()
    for trial in trials:
        names = [name for name, _ in trial.struck]
        made.update(names)
        bad.update(names[-1:] if trial.problem else [])
    lines = ["| fault | as promised |", "| --- | --- |"]
    lines += [
        f"| {fault.name} | {made[fault.name] - bad[fault.name]} of {made[fault.name]} |"
        for fault in (*FAULTS, *ENDINGS)
        if made[fault.name]
    ]
    return "\n".join(lines)


def memory(lives: Iterable[Life]) -> str:
    """Return what each kind of process took."""
    by_role: dict[str, list[Life]] = {}
    for life in lives:
        by_role.setdefault(life.role, []).append(life)
    lines = ["| process | longest [s] | when started [MB] | at most [MB] | grown at most [MB] |"]
    lines.append("| --- " * 5 + "|")
    for role, of in sorted(by_role.items()):
        longest, started = max(life.seen for life in of), max(life.started for life in of) >> 20
        most, grown = max(life.most for life in of) >> 20, max(life.most - life.started for life in of) / (1 << 20)
        lines.append(f"| {role} | {longest:.0f} | {started} | {most} | {grown:.1f} |")
    return "\n".join(lines)


def failure(trial: Trial) -> str:
    """Return everything that is needed to see a failure again."""
    plan = trial.plan
    struck = "".join(f"  at {moment:.2f} s: {name}\n" for name, moment in trial.struck)
    again = f"--seed {plan.seed}" + (f" --trial {plan.number}" if plan.number >= 0 else ", all of it")
    return (
        f"{plan}\n  {trial.problem}\n{struck}  in {trial.folder}: run.rrd, run.control.log, output.txt\n"
        f"  again: python -m tests.safety.chaos {again}\n"
    )


def summary(seed: int, trials: list[Trial]) -> str:
    """Return what came of all of it."""
    broken = [trial for trial in trials if trial.problem]
    faults, stops = sum(len(trial.struck) for trial in trials), sum(trial.stops for trial in trials)
    lives = [life for trial in trials for life in trial.lives.values()]
    counts = f"seed {seed}: {len(trials)} runs, {faults} faults, {len(broken)} failures"
    text = f"\n{counts}; {stops} protective stops, each in its servo cycle\n\n{table(trials)}\n\n{memory(lives)}\n"
    return text + "".join(f"\n{failure(trial)}" for trial in broken)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.safety.chaos",
        description="Kill, stop and starve the processes of runs at random moments, and see that all is as promised.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--minutes", type=float, default=30.0, help="how long, but for the first run and the end (default: %(default)g)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of everything that is random (default: %(default)s)")
    parser.add_argument("--trial", type=int, metavar="N", help="only this one")
    parser.add_argument("--list", type=int, metavar="N", help="print what the first N would be, and do nothing")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="where files of failures stay (default: a temporary one)"
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Strike runs until the time is up and print the tables; return 0 if everything was as promised."""
    options = _parser().parse_args(arguments)
    write = sys.stdout.write
    if options.list is not None:
        write("".join(f"{planned(options.seed, number)}\n" for number in range(options.list)))
        return 0
    if not Path("/dev/shm").is_dir():
        write("error: it needs Linux: /proc, /dev/shm, and file limits of other processes\n")
        return 2
    signal.signal(signal.SIGTERM, _as_ctrl_c)
    helpers.PATIENCE = _PATIENCE
    folder = (options.out or Path(tempfile.gettempdir())) / f"chaos-{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    folder.mkdir(parents=True)
    links = Path(tempfile.mkdtemp(prefix="humanoid-bt-chaos-", dir="/dev/shm")) / "runs"
    keep_apart(links)
    numbers = range(10**9) if options.trial is None else [options.trial]
    trials: list[Trial] = []
    began = time.monotonic()
    try:
        for trial in soak(options.seed, numbers, folder, links, began + 60 * options.minutes):
            trials.append(trial)
            write(f"{time.monotonic() - began:6.0f} s  {trial.plan}: {trial.problem or 'ok'}\n")
            sys.stdout.flush()
            if not trial.problem:
                shutil.rmtree(trial.folder)
    except KeyboardInterrupt:
        write("interrupted\n")
    finally:
        shutil.rmtree(links.parent, ignore_errors=True)
        if not any(trial.problem for trial in trials):
            shutil.rmtree(folder)
    write(summary(options.seed, trials))
    return 1 if any(trial.problem for trial in trials) else 0


def _as_ctrl_c(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    raise SystemExit(main())
