"""Plugins that tests of the project use, and when its own scenarios are run."""

from __future__ import annotations

import argparse
import gc
import signal
import zlib
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]
_SCENARIOS = Path(__file__).parent / "scenarios"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let somebody who tries often try a part of the trials at a time."""
    parser.addoption("--part", metavar="K/N", type=_of, help="of the tests marked trials, only those of part K of N")


def pytest_configure() -> None:
    """Let Ctrl-C count in tests of it, also where a shell has begun this in the background, which ignores it."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the scenarios with physics for `make test-trials`, and only those trials that are asked for."""
    for item in items:
        if item.path.is_relative_to(_SCENARIOS) and not item.scenario.dry:
            item.add_marker(pytest.mark.trials)
    if part := config.getoption("--part"):
        number, parts = part
        mine = [item for item in items if not item.get_closest_marker("trials") or _part(item, parts) == number % parts]
        config.hook.pytest_deselected(items=list(set(items) - set(mine)))
        items[:] = mine


def pytest_collection_finish() -> None:
    """Let the garbage collector leave aside what lives as long as all tests do, and what they import."""
    gc.collect()
    gc.freeze()


def _of(text: str) -> tuple[int, int]:
    number, slash, parts = text.partition("/")
    if not (slash and number.isdecimal() and parts.isdecimal() and int(parts)):
        raise argparse.ArgumentTypeError(f"it must be K/N, as 2/5, not {text!r}")
    return int(number), int(parts)


def _part(item: pytest.Item, parts: int) -> int:
    return zlib.crc32(item.nodeid.encode()) % parts
