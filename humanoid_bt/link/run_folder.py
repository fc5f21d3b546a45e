"""One folder in memory per run: where the processes of a run meet, and no other run's."""

from __future__ import annotations

import contextlib
import fcntl
import glob
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

from humanoid_bt.link import life
from humanoid_bt.link.segment import LinkError, check_private

_META = "run.json"
_LOCK = ".lock"
_SHARED_MEMORY = Path("/dev/shm")
_CLOSED = ".closed-"
_OWNER = "owner"
_LIFE = ".life-"
_FORMAT = 3  # of the meta file; runs of another version of this program are left alone

_BESIDE = "."  # between a root's name and what is random of the name of a folder that takes its place

_log = logging.getLogger(__name__)


class OtherVersionError(LinkError):
    """A run is one of another version of this program."""


@dataclass(frozen=True, slots=True)
class RunInfo:
    """What a run says about itself.

    Attributes:
        tree, robot, scene: the names of what runs on what, and where.
        file: of the tree, "" for none.
        recording: where it is recorded to, "" for nowhere.
        run_id: the folder's name; given by :meth:`RunFolder.create`.
        started: wall-clock time, seconds since the epoch; given by :meth:`RunFolder.create`.
        processes: role -> process id, where the process is; ``owner`` made the folder.
        living: the roles whose processes lived when this was read.
    """

    tree: str
    robot: str
    scene: str = ""
    file: str = ""
    recording: str = ""
    run_id: str = ""
    started: float = 0.0
    processes: Mapping[str, int] = field(default_factory=dict)
    living: frozenset[str] = frozenset()

    @property
    def alive(self) -> bool:
        """Whether any of its processes lives: control goes on balancing, and can be stopped, without the owner."""
        return bool(self.living)

    @property
    def owner_alive(self) -> bool:
        """Whether the process that made the folder lives."""
        return _OWNER in self.living


class RunFolder:
    """The folder of one run. Made by :meth:`create` in the owner and by :meth:`open` in every other process.

    Attributes:
        folder: where it is.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._life: int | None = None  # the owner's

    @classmethod
    def create(cls, info: RunInfo, root: Path | None = None) -> Self:
        """Make the folder of a new run, owned by this process.

        Args:
            info: what runs.
            root: where runs live; :func:`default_root` if not given.

        Raises:
            LinkError: it cannot be made, or the root is not safe.
        """
        home = _home(root or default_root())
        started = time.time()
        stamp = time.strftime("%Y%m%d-%H%M%S", time.gmtime(started))
        run_id = f"{stamp}-{secrets.token_hex(4)}"
        with _locked(home):
            run = cls(home / run_id)
            try:
                run.folder.mkdir(mode=0o700)
                run._life = life.begin(run.folder / f"{_LIFE}{_OWNER}")
                _write_meta(run.folder, replace(info, run_id=run_id, started=started, processes={_OWNER: os.getpid()}))
            except OSError as error:
                run.close()
                raise LinkError(f"{run.folder} cannot be made: {error.strerror}") from error
        return run

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

    @contextlib.contextmanager
    def life(self, role: str) -> Iterator[int]:
        """Yield a descriptor to be passed to a process of this run: the run is alive while one of them has its own.

        Raises:
            LinkError: the run is closed, or there is no room.
        """
        try:
            descriptor = life.begin(self.folder / f"{_LIFE}{role}")
        except OSError as error:
            raise LinkError(f"{self.folder} cannot be written: {error.strerror}") from error
        try:
            yield descriptor
        finally:
            life.end(descriptor)

    def register(self, role: str, pid: int) -> None:
        """Note a process of this run, for people.

        Raises:
            LinkError: the run is closed, or there is no room.
        """
        with _locked(self.folder.parent):
            info = self.info
            try:
                _write_meta(self.folder, replace(info, processes={**info.processes, role: pid}))
            except OSError as error:
                raise LinkError(f"{self.folder} cannot be written: {error.strerror}") from error

    def path(self, name: str) -> Path:
        """Return where a file of this run is.

        Raises:
            ValueError: this is not a plain file name.
        """
        if not name or name.startswith(".") or "/" in name or "\0" in name or name == _META:
            raise ValueError(f"{name!r} is no file name in the folder of a run")
        return self.folder / name

    def leave(self) -> None:
        """Count as dead from now on, and leave the folder to the run's other processes. For the owner."""
        descriptor, self._life = self._life, None
        if descriptor is not None:
            life.end(descriptor)

    def close(self) -> None:
        """Remove the folder and everything in it; what is mapped stays usable. For who ends last."""
        _remove(self.folder)
        self.leave()

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
    return folder.folder.parent.name.partition(_BESIDE)[0] == lockstep_root().name


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
        for home in (root, *_beside(root)):
            try:
                found = [] if _of_another(home) else sorted(path for path in home.iterdir() if not path.is_symlink())
            except FileNotFoundError:
                continue
            except OSError as error:
                problems.append(f"{home} cannot be read: {error.strerror}")
                continue
            folders += [RunFolder(path) for path in found if path.is_dir() and not path.name.startswith(".")]
    return folders


def live_runs(root: Path | None = None) -> list[tuple[RunFolder, RunInfo]]:
    """Return the runs of this user of which a process lives, the oldest first.

    Raises:
        LinkError: the root is not safe.
    """
    runs = []
    for folder in (folder for home in _homes(root or default_root()) for folder in _folders(home)):
        with contextlib.suppress(LinkError):  # closed in this moment, or not one of ours
            _check_folder(folder)
            info = _read_meta(folder)
            if info.alive:
                runs.append((RunFolder(folder), info))
    return sorted(runs, key=lambda run: (run[1].started, run[1].run_id))


def clean_stale(root: Path | None = None) -> list[str]:
    """Remove the folders of runs that died without closing; return their run ids.

    A folder without a readable meta file is left alone unless its meta file was never written.

    Args:
        root: where runs live; if not given, where those of either mode do.

    Raises:
        LinkError: the root is not safe.
    """
    roots = [default_root(), lockstep_root()] if root is None else [root]
    return [name for root in roots for home in _homes(root) for name in _clean(home)]


def _clean(home: Path) -> list[str]:
    removed: list[str] = []
    with _locked(home):  # so that a folder without a meta file is not one that is just being made
        for folder in _folders(home):
            try:
                _check_folder(folder)
                finished = (folder / _META).exists()
                dead = not (_read_meta(folder).living if finished else _living(folder))
            except OtherVersionError:
                continue
            except LinkError as error:
                _log.warning("left alone: %s", error)
                continue
            if dead and _remove(folder):
                removed.append(folder.name)
        for folder in home.glob(f"{_CLOSED}*"):  # whoever removed it died on the way
            shutil.rmtree(folder, ignore_errors=True)
    return removed


# ---- files and folders ----------------------------------------------------------------------------------------------


def _homes(root: Path) -> list[Path]:
    """Return where runs of a root are: there, and in folders that took its place.

    Raises:
        LinkError: the root is this user's, but others can reach it, or it is a link.
    """
    homes = []
    if (root.exists() or root.is_symlink()) and not _of_another(root):
        _check_folder(root)
        homes.append(root)
    for path in _beside(root):
        with contextlib.suppress(LinkError):  # another user's, who wants to be found
            _check_folder(path)
            homes.append(path)
    return homes


def _beside(root: Path) -> list[Path]:
    return sorted(root.parent.glob(f"{glob.escape(root.name)}{_BESIDE}*"))


def _home(root: Path) -> Path:
    """Return where a run is made: in the root, or beside it if another user has made that one.

    Nobody but its owner can remove a folder from where everybody may write, so a name that can be told in advance is
    one that another user can take.
    """
    try:
        with contextlib.suppress(FileExistsError):
            root.mkdir(mode=0o700)
        if _of_another(root):
            homes = _homes(root)
            return homes[0] if homes else Path(tempfile.mkdtemp(prefix=f"{root.name}{_BESIDE}", dir=root.parent))
    except OSError as error:
        raise LinkError(f"{root} cannot be made: {error.strerror}") from error
    _check_folder(root)
    return root


def _of_another(root: Path) -> bool:
    return root.lstat().st_uid != os.geteuid()


def _folders(home: Path) -> list[Path]:
    return sorted(path for path in home.iterdir() if not path.name.startswith("."))


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
    try:
        shutil.rmtree(closed, ignore_errors=True)
    finally:  # who is interrupted there, by a second Ctrl-C, leaves nothing behind either
        shutil.rmtree(closed, ignore_errors=True)
    return True


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
    told = {name: value for name, value in asdict(info).items() if name != "living"}
    draft.write_text(json.dumps({"format": _FORMAT, **told}, indent=2) + "\n")
    draft.chmod(0o600)
    draft.rename(folder / _META)


def _read_meta(folder: Path) -> RunInfo:
    path = folder / _META
    try:
        meta: dict[str, Any] = json.loads(path.read_text())
        if meta["format"] != _FORMAT:
            raise OtherVersionError(f"the run in {folder} is one of another version of this program")
        return RunInfo(
            tree=str(meta["tree"]),
            robot=str(meta["robot"]),
            scene=str(meta["scene"]),
            file=str(meta["file"]),
            recording=str(meta["recording"]),
            run_id=str(meta["run_id"]),
            started=float(meta["started"]),
            processes={str(role): int(pid) for role, pid in meta["processes"].items()},
            living=_living(folder),
        )
    except OSError as error:
        raise LinkError(f"there is no run in {folder}: {error.strerror}") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise LinkError(f"{path} is malformed: {error!r}") from error


def _living(folder: Path) -> frozenset[str]:
    """Return the roles whose processes live."""
    return frozenset(path.name.removeprefix(_LIFE) for path in folder.glob(f"{_LIFE}*") if life.lives(path))
