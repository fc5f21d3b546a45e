"""The demo tree with a ball at many places, around the robot and straight behind it.

python -m tests.trees.fetch_trials --seeds 100
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from humanoid_bt.session.report import Report
from humanoid_bt.session.run import run

BEHIND = """\
format: 1
name: behind
description: A ball straight behind the robot; the seed says where.
objects:
  ball:
    shape: ball
    size: [8 cm]
    stand: true
    random: {distance: [1, 3], bearing: [178 deg, 182 deg], height: [0.6, 1.0]}
percepts: {target: {object: ball}}
"""
SCENES = ("random_target", "behind")

TOUCHES = 0.015  # m between palm and ball: the tolerance of reach, which sees the ball with noise
PATIENCE = 90.0  # s


def trial(folder: Path, scene: str, seed: int) -> Report:
    """Run the demo in a scene of :data:`SCENES`; the folder is its workspace, and keeps the scene."""
    path = folder / "sim" / "scenes" / "behind.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(BEHIND, encoding="utf-8")
    return run("fetch", workspace=folder, scene=scene, seed=seed, duration=PATIENCE, record=False)


def fault(report: Report) -> str:
    """Return why the robot has not touched the ball as it should, "" if it has."""
    error = report.result("hand_error", None)
    if report.fell or report.outcome != "success":
        return f"{report.outcome}: {report.reason}"
    return "" if error is not None and error <= TOUCHES else f"the palm is {error} m off"


def main(arguments: list[str] | None = None) -> int:
    """Run the seeds in every scene; return 0 if the ball was touched every time."""
    parser = argparse.ArgumentParser(prog="python -m tests.trees.fetch_trials", description="The demo, many times.")
    parser.add_argument("--seeds", type=int, default=100, help="how many in each scene (default: %(default)s)")
    parser.add_argument("--first", type=int, default=0, help="the first (default: %(default)s)")
    options = parser.parse_args(arguments)
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            faults: dict[int, str] = {}
            errors, times = [0.0], [0.0]
            for seed in range(options.first, options.first + options.seeds):
                report = trial(Path(folder), scene, seed)
                faults |= {seed: why} if (why := fault(report)) else {}
                errors.append(report.result("hand_error", 0.0))
                times.append(report.sim_time)
            touched = options.seeds - len(faults)
            sys.stdout.write(f"{scene}: touched {touched} of {options.seeds}, ")
            sys.stdout.write(f"palm at most {max(errors) * 100:.1f} cm off, at most {max(times):.0f} s\n")
            sys.stdout.writelines(f"  seed {seed}: {why}\n" for seed, why in faults.items())
            sys.stdout.flush()
            failed += len(faults)
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
