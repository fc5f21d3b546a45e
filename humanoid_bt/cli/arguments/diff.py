"""The arguments of ``humanoid-bt diff``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import number
from humanoid_bt.cli.arguments.parsing import Commands
from humanoid_bt.session.limits import Limit

_TOLERANCE = Limit(float, "a number, 0 or more", lambda value: 0 <= value < float("inf"))
_TIME = Limit(float, "a time in s, 0 or more", lambda value: 0 <= value < float("inf"), "s")

_DESCRIPTION = """\
Tell how two recorded runs differ: what was run, the first moment in which they
part and by what, when each node did something else, results and outcome.
"""

_EXAMPLES = """\
examples:
  humanoid-bt diff runs/one.rrd runs/other.rrd
  humanoid-bt diff runs/one.rrd runs/other.rrd --tolerance 1e-6    runs of two machines
  humanoid-bt diff runs/one.rrd runs/other.rrd --view

exit codes:
  0  the runs are the same
  1  they differ
  2  no recording that can be read
"""


def add_diff(commands: Commands) -> None:
    """Declare ``diff``."""
    diff = commands.add("diff", "compare two recorded runs", _DESCRIPTION, _EXAMPLES)
    diff.add_argument("one", type=Path, metavar="A", help="a recording")
    diff.add_argument("other", type=Path, metavar="B", help="another one")
    diff.add_argument(
        "--tolerance",
        type=number(_TOLERANCE),
        default=0.0,
        metavar="X",
        help="numbers of states, percepts, commands and results that differ by no more are the same; default 0",
    )
    diff.add_argument(
        "--within",
        type=number(_TIME),
        metavar="S",
        help="times of nodes that differ by no more [s] are the same; default 0.02, a tick, in realtime mode, else 0",
    )
    how = diff.add_mutually_exclusive_group()
    how.add_argument("--json", action="store_true", help="for programs: everything, as one object")
    how.add_argument(
        "--view",
        action="store_true",
        help="show both in one view too, or say where it is if there is no display",
    )
