"""The command line with a folder of its own for the links of runs: what is started so meets no other run.

python -m tests.safety.apart FOLDER run fetch --mode realtime
"""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from humanoid_bt import __main__ as program
from humanoid_bt.link import run_folder


def keep_apart(folder: Path) -> None:
    """Let this process have its runs, and look for those of others, in a folder."""
    run_folder.default_root = lambda: folder


if __name__ == "__main__":
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # whoever starts chaos with nohup ignores it
    keep_apart(Path(sys.argv.pop(1)))
    sys.exit(program.main())
