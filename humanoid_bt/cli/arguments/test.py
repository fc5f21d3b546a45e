"""The arguments of ``humanoid-bt test``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import COUNT, number
from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_EXAMPLES = """\
examples:
  humanoid-bt test                              all scenarios of this folder
  humanoid-bt test scenarios/lost.yaml -j 2
  humanoid-bt test lost --seeds 7               one run again
  humanoid-bt test --junit results.xml          for a CI server

exit codes:
  0    all of them passed
  1    some failed
  2    usage, or a mistake in a file
  4    internal error, or a process that tried scenarios has died
  130  interrupted
"""


def add_test(commands: Commands) -> None:
    """Declare ``test``."""
    test = commands.add(
        "test",
        "run scenarios and judge them",
        "Run every seed of scenarios, in simulated time, and judge each run by what is expected of it. "
        "A run that fails is run again and recorded.",
        _EXAMPLES,
    )
    test.add_argument(
        "names",
        nargs="*",
        metavar="FILE",
        help="names, files or folders of scenarios; default: those of this workspace",
    )
    test.add_argument(
        "-j", "--jobs", type=number(COUNT), default=1, metavar="N", help="number of processes; default: 1"
    )
    test.add_argument("--seeds", metavar="S", help="instead of the scenarios' own: 3, 0-9, '0-9, 20'")
    test.add_argument("--no-record", action="store_true", help="record nothing")
    test.add_argument("--junit", type=Path, metavar="FILE", help="write the results as JUnit's XML too")
    test.add_argument("--json", action="store_true", help="for programs: a list of all runs")
    add_workspace(test)
