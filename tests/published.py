"""Published robots and policies, which are no part of this package: found where a variable says, or beside it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_BESIDE = Path(__file__).resolve().parents[2] / "shared"  # beside the checkout


def published_robot(file: str) -> Path:
    """Return a model in the folder of robots, or skip the test with a reason."""
    return _find("HUMANOID_BT_ROBOTS", "robots", file)


def published_policy(file: str) -> Path:
    """Return a policy in the folder of policies, or skip the test with a reason."""
    return _find("HUMANOID_BT_POLICIES", "policies", file)


def _find(variable: str, beside: str, file: str) -> Path:
    for folder in filter(None, (os.environ.get(variable), str(_BESIDE / beside))):
        if (path := Path(folder) / file).is_file():
            return path
    pytest.skip(f"{variable} names no folder with {file}")
