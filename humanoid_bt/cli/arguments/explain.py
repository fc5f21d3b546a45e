"""The arguments of ``humanoid-bt explain``."""

from __future__ import annotations

from humanoid_bt.cli.arguments.numbers import TIME, number
from humanoid_bt.cli.arguments.parsing import Commands

_EXAMPLES = """\
examples:
  humanoid-bt explain                           the newest recording in runs/
  humanoid-bt explain runs/fetch-20260101-120000.rrd
  humanoid-bt explain --at 12.3                 what was going on then
  humanoid-bt explain --node reach              the life of a node
  humanoid-bt explain --joint right_elbow       how much it bore, when it was limited
  humanoid-bt explain --json | jq -r .headline

exit codes:
  0  explained
  2  no recording, or nothing of that name or time in it
"""


def add_explain(commands: Commands) -> None:
    """Declare ``explain``."""
    explain = commands.add(
        "explain",
        "say what stopped a robot",
        "Say why a run stopped, fell or failed: which command, of which node, which joint, at which moment.",
        _EXAMPLES,
    )
    explain.add_argument("recording", nargs="?", metavar="RECORDING", help="its file; default: the newest in runs/")
    one = explain.add_mutually_exclusive_group()
    one.add_argument("--at", type=number(TIME), metavar="SECONDS", help="what was going on at that time")
    one.add_argument("--node", metavar="NAME", help="when a node ran, why it ended, what it commanded")
    one.add_argument("--joint", metavar="NAME", help="how far a joint went, what it bore, when it was limited")
    explain.add_argument("--json", action="store_true", help="for programs")
