"""One folder in memory per run: where the processes of a run meet, and no other run's."""

from __future__ import annotations

import contextlib
import fcntl
import json
import logging
import os
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from humanoid_bt.link.processes import ProcessIdentity, current
from humanoid_bt.link.segment import LinkError, check_private

_META = "run.json"
_LOCK = ".lock"
_SHARED_MEMORY = Path("/dev/shm")
_CLOSED = ".closed-"
_OWNER = "owner"

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RunInfo:
    """What a run says about itself.

    Attributes:
        tree, robot: what runs on what.
        run_id: the folder's name; given by :meth:`RunFolder.create`.
        started: wall-clock time, seconds since the epoch; given by :meth:`RunFolder.create`.
        processes: role -> process; ``owner`` made the folder.
    """

    tree: str
    robot: str
    run_id: str = ""
    started: float = 0.0
    processes: Mapping[str, ProcessIdentity] = field(default_factory=dict)

    @property
    def alive(self) -> bool:
        """Whether any of its processes lives: control goes on balancing, and can be stopped, without the owner."""
        return any(process.alive for process in self.processes.values())

    @property
    def owner_alive(self) -> bool:
        """Whether the process that made the folder lives."""
        return _OWNER in self.processes and self.processes[_OWNER].alive


class RunFolder:
    """The folder of one run. Made by :meth:`create` in the owner and by :meth:`open` in every other process.

    Attributes:
        folder: where it is.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def create(cls, info: RunInfo, root: Path | None = None) -> Self:
        """Make the folder of a new run, owned by this process.

        Args:
            info: tree and robot.
            root: where runs live; :func:`default_root` if not given.

        Raises:
            LinkError: it cannot be made, or the root is not safe.
        """
        root = root or default_root()
        _make_private(root)
        started = time.time()
        stamp = time.strftime("%Y%m%d-%H%M%S", time.gmtime(started))
        run_id = f"{stamp}-{secrets.token_hex(4)}"
        with _locked(root):
            folder = root / run_id
            try:
                folder.mkdir(mode=0o700)
                _write_meta(folder, replace(info, run_id=run_id, started=started, processes={_OWNER: current()}))
            except OSError as error:
                raise LinkError(f"{folder} cannot be made: {error.strerror}") from error
        return cls(folder)

    @classmethod
    def open(cls, folder: Path) -> Self:
        """Join a run.

        Raises:
            LinkError: there is no such run of this user.
        """
        _check_folder(folder.parent)
        _check_folder(folder)
        _read_meta(folder)
        return cls(folder)

    @property
    def info(self) -> RunInfo:
        """What the run says about itself now.

        Raises:
            LinkError: it is closed.
        """
        return _read_meta(self.folder)

    def register(self, role: str, pid: int | None = None) -> None:
        """Note a process of this run, this one if no other is given; the run is alive while one of them is.

        Raises:
            LinkError: the run is closed.
        """
        identity = current() if pid is None else ProcessIdentity.of(pid)
        with _locked(self.folder.parent):
            info = self.info
            _write_meta(self.folder, replace(info, processes={**info.processes, role: identity}))

    def path(self, name: str) -> Path:
        """Return where a file of this run is.

        Raises:
            ValueError: this is not a plain file name.
        """
        if not name or name.startswith(".") or "/" in name or "\0" in name or name == _META:
            raise ValueError(f"{name!r} is no file name in the folder of a run")
        return self.folder / name

    def close(self) -> None:
        """Remove the folder and everything in it; what is mapped stays usable. For the owner."""
        _remove(self.folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def default_root() -> Path:
    """Return where the runs of this user live: in memory where the system has a folder for that."""
    in_memory = _SHARED_MEMORY.is_dir() and os.access(_SHARED_MEMORY, os.W_OK)
    parent = _SHARED_MEMORY if in_memory else Path(tempfile.gettempdir())
    return parent / f"humanoid-bt-{os.geteuid()}"


def lockstep_root() -> Path:
    """Return where runs in lockstep live: apart from those whose control competes for a processor."""
    root = default_root()
    return root.with_name(f"{root.name}-lockstep")


def in_lockstep(folder: RunFolder) -> bool:
    """Return whether a run is one in lockstep."""
    return folder.folder.parent == lockstep_root()


def all_runs() -> list[tuple[RunFolder, RunInfo]]:
    """Return the runs of this user in either mode, as :func:`live_runs`: first those in realtime mode."""
    return [*live_runs(), *live_runs(lockstep_root())]


def all_folders(problems: list[str]) -> list[RunFolder]:
    """Return every folder of a run of this user in either mode, whatever is missing or wrong in it.

    For the e-stop, which is not refused because something else is damaged.

    Args:
        problems: takes why there may be more.
    """
    folders: list[RunFolder] = []
    for root in (default_root(), lockstep_root()):
        try:
            found = sorted(path for path in root.iterdir() if path.is_dir() and not path.is_symlink())
        except FileNotFoundError:
            continue
        except OSError as error:
            problems.append(f"{root} cannot be read: {error.strerror}")
            continue
        folders += [RunFolder(path) for path in found if not path.name.startswith(".")]
    return folders


def live_runs(root: Path | None = None) -> list[tuple[RunFolder, RunInfo]]:
    """Return the runs of this user of which a process lives, the oldest first.

    Raises:
        LinkError: the root is not safe.
    """
    runs = []
    for folder in _folders(root or default_root()):
        with contextlib.suppress(LinkError):  # closed in this moment, or not one of ours
            _check_folder(folder)
            info = _read_meta(folder)
            if info.alive:
                runs.append((RunFolder(folder), info))
    return sorted(runs, key=lambda run: (run[1].started, run[1].run_id))


def clean_stale(root: Path | None = None) -> list[str]:
    """Remove the folders of runs that died without closing; return their run ids.

    A folder without a readable meta file is left alone unless its meta file was never written.

    Raises:
        LinkError: the root is not safe.
    """
    root = root or default_root()
    removed: list[str] = []
    _folders(root)  # refuses a root that is not safe before anything is written there
    if not root.exists():
        return removed
    with _locked(root):  # so that a folder without a meta file is not one that is just being made
        for folder in _folders(root):
            try:
                _check_folder(folder)
                dead = not _begun(folder) or not _read_meta(folder).alive
            except (LinkError, OSError) as error:
                _log.warning("left alone: %s", error)
                continue
            if dead and _remove(folder):
                removed.append(folder.name)
        for folder in root.glob(f"{_CLOSED}*"):  # whoever removed it died on the way
            shutil.rmtree(folder, ignore_errors=True)
    return removed


# ---- files and folders ----------------------------------------------------------------------------------------------


def _folders(root: Path) -> list[Path]:
    if not root.exists() and not root.is_symlink():
        return []
    _check_folder(root)
    return sorted(path for path in root.iterdir() if not path.name.startswith("."))


def _begun(folder: Path) -> bool:
    """Return whether there was ever a meta file: without it nothing else is put into the folder."""
    return any(path.name != f".{_META}" for path in folder.iterdir())


def _remove(folder: Path) -> bool:
    """Remove a folder that is whole for everybody else until it is gone for everybody else.

    Returns:
        Whether it was there; its owner may have closed it a moment before.
    """
    closed = folder.with_name(f"{_CLOSED}{folder.name}")
    try:
        folder.rename(closed)
    except FileNotFoundError:
        return False
    shutil.rmtree(closed, ignore_errors=True)
    return True


def _make_private(folder: Path) -> None:
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        pass
    except OSError as error:
        raise LinkError(f"{folder} cannot be made: {error.strerror}") from error
    _check_folder(folder)


def _check_folder(folder: Path) -> None:
    """Refuse a folder that is not private, or a link to one."""
    try:
        status = folder.lstat()
    except OSError as error:
        raise LinkError(f"{folder} cannot be read: {error.strerror}") from error
    check_private(folder, status, stat.S_ISDIR(status.st_mode))


@contextlib.contextmanager
def _locked(root: Path) -> Iterator[None]:
    """Let one process at a time make, change or clean folders; the kernel lets go for one that dies."""
    try:
        descriptor = os.open(root / _LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
    except OSError as error:
        raise LinkError(f"{root / _LOCK} cannot be opened: {error.strerror}") from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _write_meta(folder: Path, info: RunInfo) -> None:
    draft = folder / f".{_META}"
    draft.write_text(json.dumps({"format": 1, **asdict(info)}, indent=2) + "\n")
    draft.chmod(0o600)
    draft.rename(folder / _META)


def _read_meta(folder: Path) -> RunInfo:
    path = folder / _META
    try:
        meta: dict[str, Any] = json.loads(path.read_text())
        processes = {
            str(role): ProcessIdentity(int(process["pid"]), str(process["started"]), str(process["namespace"]))
            for role, process in meta["processes"].items()
        }
        return RunInfo(str(meta["tree"]), str(meta["robot"]), str(meta["run_id"]), float(meta["started"]), processes)
    except OSError as error:
        raise LinkError(f"there is no run in {folder}: {error.strerror}") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise LinkError(f"{path} is malformed: {error!r}") from error
