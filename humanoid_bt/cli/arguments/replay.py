"""The arguments of ``humanoid-bt replay``."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_DESCRIPTION = """\
Run a recorded run again from its inputs, and say whether it does the same.
A lockstep run runs again as a whole, bit for bit. Of a realtime run, or with
--tree or --set, decision runs again on what it had seen."""

_EXAMPLES = """\
examples:
  humanoid-bt replay                          the newest recording of runs/
  humanoid-bt replay run.rrd --tree new.yaml  what would this tree have decided?
  humanoid-bt replay run.rrd --set look=4s    and the same tree with this value?
  humanoid-bt replay run.rrd --current        with the files as they are now
  humanoid-bt replay run.rrd --to-test tests/test_lost_ball.py

The skills of the recording are run: replay recordings of people you trust.

exit codes:
  0  identical
  1  it differs; the first difference is told
  2  the recording cannot be read, or what it was made of is not there
"""


def add_replay(commands: Commands) -> None:
    """Declare ``replay``."""
    replay = commands.add("replay", "run a recorded run again, and compare", _DESCRIPTION, _EXAMPLES)
    replay.add_argument("recording", nargs="?", metavar="RECORDING", help="default: the newest in runs/")
    replay.add_argument("--tree", metavar="TREE", help="another tree, on the same inputs; with the skills of now")
    replay.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="overrides",
        help="another value for a parameter of the tree; may be given several times",
    )
    replay.add_argument("--current", action="store_true", help="the trees, skills, robots and scenes of now")
    replay.add_argument("--to-test", metavar="FILE", help="write a pytest that fails until it is mended")
    replay.add_argument("--json", action="store_true", help="print the result as JSON")
    add_workspace(replay)
