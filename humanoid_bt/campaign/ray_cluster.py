"""Trials on the machines of a Ray cluster. Ray schedules them, and runs again what was on a machine that is lost.

On each machine trials run in the same processes as here, so that what hangs or dies there is told as it is here.
"""

from __future__ import annotations

import contextlib
import pickle
import socket
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

from humanoid_bt.campaign.journal import Unwritable
from humanoid_bt.campaign.plan import Plan
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.work import Refused, Run
from humanoid_bt.campaign.workers import Done, Workers
from humanoid_bt.core.errors import HumanoidBtError, UserError, relative
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.report import versions

NOT_SHIPPED = ("runs", ".git", ".venv*", "*.rrd", "__pycache__", "build", "dist")
"""What of a workspace trials do not need on other machines, as patterns of gitignore."""

_AHEAD = 3  # tasks per processor that wait for it: it is never idle, and a million of them fill no memory

_KNOCK_TIMEOUT = 10.0  # s

_Answer = tuple[Done | Refused, bytes]  # and the recording


@dataclass(frozen=True)
class Ways:
    """How trials are run on each machine.

    Attributes:
        make: returns what runs tasks, in a process there; a function of a module.
        arguments: what it is given.
        time_limit: longest time of a trial on the wall clock [s].
        memory: most bytes that a process may have; None for any number.
    """

    make: Callable[..., Run]
    arguments: tuple[Any, ...]
    time_limit: float
    memory: int | None = None


class RayCluster:
    """A Ray cluster that runs trials.

    Args:
        address: of the cluster: ``auto``, ``HOST:6379`` or ``ray://HOST:10001``.
        workspace: the folder that is shipped; trials find it as their working directory.
        ways: how trials are run.

    Raises:
        UserError: Ray is not installed, no cluster answers, or the workspace cannot be shipped.
    """

    def __init__(self, address: str, workspace: Path, ways: Ways) -> None:
        self._ways = ways
        try:
            import ray  # noqa: PLC0415 (an extra, which few have)
        except ImportError as error:
            raise UserError("--cluster needs Ray", hint="pip install 'humanoid-bt[cluster]'") from error
        self._ray: Any = ray
        shipped = {"working_dir": str(workspace), "excludes": list(NOT_SHIPPED)}
        try:
            _knock(address)
            ray.init(address=address, runtime_env=shipped, log_to_driver=False, logging_level="error")
        except (ConnectionError, RuntimeError, ValueError, OSError) as error:
            why = str(error).strip().split("\n", maxsplit=1)[0]
            message = f"no trials can be run on the Ray cluster {address!r}: {why}"
            raise UserError(message, hint="ray status, on a machine of the cluster, says whether it is up") from error

    def run(self, tasks: Iterable[Task]) -> Iterator[Done]:
        """Yield tasks as they are done, each once, whichever machines are lost meanwhile.

        Raises:
            UserError: a trial cannot be run, for a mistake in a file or a value.
            HumanoidBtError: the cluster is gone, or cannot run this version.
        """
        ray, left = self._ray, iter(tasks)
        trial = ray.remote(num_cpus=1, max_retries=-1)(_run_there)
        given = ray.put(self._ways)
        pending: dict[Any, Task] = {}
        try:
            while True:
                room = _AHEAD * max(1, int(ray.cluster_resources().get("CPU", 1))) - len(pending)
                pending |= {trial.remote(given, task, _version()): task for task in islice(left, max(room, 0))}
                if not pending:
                    return
                ready, _ = ray.wait(list(pending), num_returns=1)
                yield self._answer(ray.get(ready[0]), pending.pop(ready[0]))
        except ray.exceptions.RayError as error:
            raise HumanoidBtError(f"the Ray cluster does not go on: {str(error).strip().splitlines()[0]}") from error
        finally:
            with contextlib.suppress(ray.exceptions.RayError, ConnectionError):  # it is gone, with all that it ran
                for one in pending:
                    ray.cancel(one, force=True)

    def close(self) -> None:
        """Leave the cluster."""
        self._ray.shutdown()

    def _answer(self, answer: _Answer, task: Task) -> Done:
        """Take what came of a task; its recording goes where it was wanted."""
        done, recording = answer
        if isinstance(done, Refused):
            raise done.error
        if recording:
            try:
                Path(task.recording).write_bytes(recording)
            except OSError as error:
                raise Unwritable(f"{relative(Path(task.recording))!r} cannot be written: {error.strerror}") from error
        return replace(done, task=task)


def _knock(address: str) -> None:
    """See that somebody listens at an address, for which Ray waits for minutes; raises OSError."""
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if colon and port.isdigit():
        socket.create_connection((host.strip("[]"), int(port)), _KNOCK_TIMEOUT).close()


def see_that_it_is_shipped(plan: Plan, workspace: Workspace) -> None:
    """See that other machines find what a campaign names.

    Raises:
        UserError: it names a file outside of the workspace, or not as it is called seen from there.
    """
    known = {"tree": workspace.trees(), "robot": workspace.robots(), "scene": workspace.scenes()}
    for setting in plan.settings:
        for kind, name in setting._asdict().items():
            if name not in known[kind] and (Path(name).is_absolute() or not (workspace.root / name).exists()):
                hint = (
                    f"give it as it is called in {relative(workspace.root)!r}, the workspace, which is what is shipped"
                )
                raise UserError(f"other machines of the cluster do not find the {kind} {name!r}", hint=hint)


_here: dict[bytes, Workers] = {}
"""The workers of this process on a machine of the cluster, which are kept from trial to trial."""


def _run_there(ways: Ways, task: Task, version: str) -> _Answer:
    """Run a task on the machine on which this is called, by a process that is kept for the next one."""
    if version != _version():
        text = f"{socket.gethostname()} has version {_version()} of humanoid-bt, and this is {version}"
        return Refused(f"{text}: install the same one on every machine of the cluster"), b""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / Path(task.recording).name if task.recording else None
        try:
            done = _workers(ways).run_one(replace(task, recording=str(file or "")))
        except HumanoidBtError as error:
            return Refused.of(error), b""
        cost = replace(done.cost, worker=f"{socket.gethostname()}/{done.cost.worker}")
        return replace(done, cost=cost), file.read_bytes() if file and file.exists() else b""


def _version() -> str:
    return versions()["humanoid-bt"]


def _workers(ways: Ways) -> Workers:
    key = pickle.dumps(ways)
    if key not in _here:
        logs = Path(tempfile.mkdtemp(prefix="humanoid-bt-"))
        _here[key] = Workers(
            ways.make, ways.arguments, count=1, time_limit=ways.time_limit, memory=ways.memory, logs=logs
        )
    return _here[key]
