"""What other processes do in these tests: ``python workers.py NAME ARGUMENT...``. Each says "ready" when it begins."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path


def consistent(sequence: int, size: int) -> bytes:
    """Return a payload of up to ``size`` bytes that tells its sequence everywhere, of another length each time."""
    words = 1 + sequence * 31 % (size // 8)
    return sequence.to_bytes(8, "little") * words


def is_consistent(sequence: int, payload: bytes, size: int) -> bool:
    return payload == consistent(sequence, size)


def write_forever(path: str) -> None:
    from humanoid_bt.link.ring import RingWriter

    writer = RingWriter.open(Path(path))
    ready()
    while True:
        writer.write(consistent(writer.sequence + 1, writer.slot_size))


def beat_forever(path: str) -> None:
    from humanoid_bt.link.heartbeat import Heartbeat

    heartbeat = Heartbeat.open(Path(path))
    ready()
    while True:
        heartbeat.beat()


def raise_estop(path: str, gate: str, name: str, count: str) -> None:
    from humanoid_bt.link.estop import EStop
    from humanoid_bt.link.heartbeat import Heartbeat

    estop, start = EStop.open(Path(path)), Heartbeat.open(Path(gate))
    ready()
    while not start.count:
        pass
    for index in range(int(count)):
        estop.raise_(name, f"cause {index}")


def own_run(root: str, helps: str = "") -> None:
    from humanoid_bt.link.run_folder import RunFolder, RunInfo

    folder = RunFolder.create(RunInfo("fetch", "humanoid"), Path(root))
    if helps:
        with folder.life("control") as life:
            helper = [sys.executable, "-c", "import sys; print(flush=True); sys.stdin.readline()"]
            process = subprocess.Popen(helper, pass_fds=(life,), stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
    ready(folder.folder.name)
    sys.stdin.read()


def fork_in_run(root: str) -> None:
    from humanoid_bt.link.run_folder import RunFolder, RunInfo

    folder = RunFolder.create(RunInfo("fetch", "humanoid"), Path(root))
    forked, child = os.pipe()
    if not os.fork():
        os.write(child, b"!")
        sys.stdin.read()
        os._exit(0)
    os.read(forked, 1)
    ready(folder.folder.name)
    os.kill(os.getpid(), signal.SIGKILL)


def churn_runs(root: str, count: str) -> None:
    from humanoid_bt.link.run_folder import RunFolder, RunInfo, clean_stale, live_runs

    ready()
    for _ in range(int(count)):
        with RunFolder.create(RunInfo("fetch", "humanoid"), Path(root)) as folder:
            removed = clean_stale(Path(root))
            names = [info.run_id for _, info in live_runs(Path(root))]
            if removed or folder.info.run_id not in names:
                sys.exit(f"removed {removed}, live {names}")


def ready(word: str = "ready") -> None:
    sys.stdout.write(f"{word}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    globals()[sys.argv[1]](*sys.argv[2:])
