"""The tree ``go`` while a cart crosses the robot's way, from anywhere and at any speed of people; many times.

python -m tests.trees.crossing_trials --carts 80
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from pathlib import Path

import numpy as np

from humanoid_bt import Rig, TreeRun

SCENE = """\
format: 1
name: crossing
objects:
  cart: {{shape: box, size: [0.4, 0.4, 0.8], color: red, solid: true, position: [{x:.2f}, {y:.2f}, 0.4]}}
events:
  - {{at: {begins:.2f} s, move: cart, to: [{to_x:.2f}, {to_y:.2f}, 0.4], over: {lasts:.2f} s}}
"""
GOAL = 3.0  # m ahead
PATIENCE = 40.0  # s
_RUNS = 5.0  # m that the cart goes


def trial(rig: Rig, folder: Path, seed: int) -> TreeRun:
    """Let the robot walk ahead while a cart crosses its way; the folder keeps the scene."""
    random = np.random.default_rng(seed)
    x, y = random.uniform(0.8, 3.5), random.choice([-1, 1]) * random.uniform(1.0, 2.2)
    direction = math.atan2(-y, random.uniform(0.8, 2.4) - x)  # through the way
    speed, begins = random.uniform(0.2, 0.8), random.uniform(0.0, 3.0)
    to_x, to_y = x + _RUNS * math.cos(direction), y + _RUNS * math.sin(direction)
    path = folder / f"crossing_{seed}.yaml"
    path.write_text(SCENE.format(x=x, y=y, begins=begins, to_x=to_x, to_y=to_y, lasts=_RUNS / speed), encoding="utf-8")
    return rig.run_tree("go", scene=path, duration=PATIENCE, x=GOAL, y=0.0)


def main(arguments: list[str] | None = None) -> int:
    """Run the seeds; return 0 if no cart touched the robot, and it went where it should every time."""
    parser = argparse.ArgumentParser(prog="python -m tests.trees.crossing_trials", description="Carts cross the way.")
    parser.add_argument("--carts", type=int, default=80, help="how many (default: %(default)s)")
    parser.add_argument("--first", type=int, default=0, help="seed of the first (default: %(default)s)")
    options = parser.parse_args(arguments)
    touched = fell = arrived = 0
    for seed in range(options.first, options.first + options.carts):
        with tempfile.TemporaryDirectory() as folder:
            run = trial(Rig(), Path(folder), seed)
        touches = bool(run.samples[-1].touched)
        touched, fell, arrived = touched + touches, fell + run.report.fell, arrived + run.succeeded
        if touches or not run.succeeded:
            sys.stdout.write(f"  seed {seed}: {'touched, ' if touches else ''}{run.report.outcome}: {run.reason}\n")
            sys.stdout.flush()
    sys.stdout.write(f"of {options.carts} carts {touched} touched the robot; it fell {fell} times, arrived {arrived}\n")
    return 0 if arrived == options.carts and not touched else 1


if __name__ == "__main__":
    raise SystemExit(main())
