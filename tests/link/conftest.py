from __future__ import annotations

import os
import secrets
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import humanoid_bt

SHARED_MEMORY = Path("/dev/shm")
PREFIX = f"humanoid-bt-test-{os.getpid()}-"

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A private folder in shared memory, where there is such a thing; it is gone after the test."""
    parent = SHARED_MEMORY if SHARED_MEMORY.is_dir() else tmp_path
    path = parent / f"{PREFIX}{secrets.token_hex(4)}"
    path.mkdir(mode=0o700)
    yield path
    shutil.rmtree(path)
    assert not list(parent.glob(f"{PREFIX}*"))


@pytest.fixture
def start() -> Iterator[Start]:
    """Starts a worker and waits until it is ready; its first line is ``process.word``."""
    started: list[subprocess.Popen[str]] = []

    def run(name: str, *arguments: object) -> subprocess.Popen[str]:
        command = [sys.executable, str(Path(__file__).with_name("workers.py")), name, *map(str, arguments)]
        environment = {**os.environ, "PYTHONPATH": str(Path(humanoid_bt.__file__).parents[1])}
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        started.append(process)
        return process

    yield run
    for process in started:
        process.kill()
        process.communicate()


def first_line(process: subprocess.Popen[str]) -> str:
    """Return what a worker says when it is ready."""
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    assert line, "the worker ended before it was ready"
    return line
