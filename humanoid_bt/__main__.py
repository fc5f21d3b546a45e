"""The command line as a program, ``humanoid-bt`` and ``python -m humanoid_bt``, from its first moment to its last."""

import os
import sys
import threading
import time

from humanoid_bt.core.early import end_at_once

_GRACE = 2.0  # s that threads get to end after the command


def main() -> int:
    """Run the command line; the program ends with its exit code, whatever a skill has left running."""
    end_at_once()
    from humanoid_bt.cli import main as command_line  # noqa: PLC0415 (it takes a while)

    code = command_line()
    threading.Thread(target=_insist, args=(code,), name="end", daemon=True).start()
    return code


def _insist(code: int) -> None:
    """End the program if Python still waits for threads that do not end."""
    time.sleep(_GRACE)
    left = [thread for thread in threading.enumerate() if not thread.daemon and thread.is_alive()]
    threads = ", ".join(repr(thread.name) for thread in left if thread is not threading.main_thread())
    if threads:
        sys.stderr.write(f"warning: the thread {threads} still runs, and the program ends without it\n")
        sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    sys.exit(main())
