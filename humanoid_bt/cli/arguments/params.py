"""The arguments of ``humanoid-bt params``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.parsing import Commands

_DESCRIPTION = """\
Print the parameters that a recorded run had, as a file for run --params, with
where each value is from; or compare those of two: recordings or such files.
"""

_EXAMPLES = """\
examples:
  humanoid-bt params > yesterday.yaml
  humanoid-bt run fetch --params yesterday.yaml
  humanoid-bt run fetch --params runs/fetch-20260101-120000.rrd
  humanoid-bt params diff yesterday.yaml runs/fetch-20260101-120000.rrd

exit codes:
  0  done; with diff: they have the same parameters
  1  with diff: they differ
  2  no recording, or a mistake in a file
"""


def add_params(commands: Commands) -> None:
    """Declare ``params``."""
    params = commands.add("params", "print or compare the parameters of runs", _DESCRIPTION, _EXAMPLES)
    params.usage = "humanoid-bt params [-h] [RECORDING]\n       humanoid-bt params [-h] diff A B"
    params.add_argument("paths", nargs="*", type=Path, metavar="RECORDING", help="default: the newest in runs/")
