"""A table of the built-in robot, measured for once."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.trials
def test_the_built_in_robot_is_measured_and_pictured(tmp_path: Path) -> None:
    options = ["--trials", "1", "--only", "push-standing-60", "--out", str(tmp_path / "found")]
    command = [sys.executable, "-m", "humanoid_bt", "robots", "table", "humanoid", *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    line = (tmp_path / "found" / "robots.md").read_text().splitlines()[4]
    assert "**humanoid**, 40.7 kg, 1.33 m, 31 joints | dcm | 1 of 1 | - | " in line
    assert line.endswith(" us |")
    assert (tmp_path / "found" / "humanoid.png").is_file() or "no picture" in done.stdout
