"""A process that runs trials: it is told what to load, then one task after the other, until nobody asks for more."""

from __future__ import annotations

import contextlib
import ctypes
import pickle
import resource
import signal
import sys
from multiprocessing.connection import Connection

from humanoid_bt.campaign.work import Refused
from humanoid_bt.core.errors import HumanoidBtError

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG


def main(number: int) -> None:
    """Run the tasks that come in at a file's number, and answer each."""
    if sys.platform == "linux":  # a trial that is begun would otherwise go on when the command is killed
        ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
    line = Connection(number)
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        sys.path[:], memory = pickle.loads(line.recv_bytes())
        if memory is not None:
            resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        try:
            make, arguments = pickle.loads(line.recv_bytes())
            run = make(*arguments)
        except HumanoidBtError as error:
            _ = line.recv()
            line.send(Refused.of(error))
            return
        while True:
            task = line.recv()
            try:
                line.send(run(task))
            except HumanoidBtError as error:
                line.send(Refused.of(error))


if __name__ == "__main__":
    main(int(sys.argv[1]))
