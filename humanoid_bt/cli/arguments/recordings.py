"""The arguments of the commands for the folder of recordings: ``recordings``, ``keep``."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands

_LIMITS = """\
When a run begins, the oldest recordings in runs/ are removed until
the others have room. How much that is, runs/limits.yaml says:

  recordings: 500
  size: 20 GB
"""

_KEEP_EXAMPLES = """\
examples:
  humanoid-bt keep runs/fetch-20260101-120000.rrd
  humanoid-bt keep --undo fetch-20260101-120000
"""


def add_recordings(commands: Commands) -> None:
    """Declare ``recordings``."""
    recordings = commands.add(
        "recordings",
        "list recordings",
        "List the recordings in runs/, the newest first: when, tree,\noutcome, length, size.",
        _LIMITS,
    )
    recordings.add_argument("--all", action="store_true", help="all of them; default: the newest 20")
    recordings.add_argument("--json", action="store_true", help="for programs: a list of all of them")


def add_keep(commands: Commands) -> None:
    """Declare ``keep``."""
    keep = commands.add(
        "keep",
        "keep a recording for good",
        "Keep recordings in runs/: they are not removed to make room\nfor others, and do not count. "
        "A file beside a recording says\nso, NAME.keep.",
        _KEEP_EXAMPLES,
    )
    keep.add_argument("recordings", nargs="+", metavar="RECORDING", help="its name, or one of its files")
    keep.add_argument("--undo", action="store_true", help="keep it no longer")
