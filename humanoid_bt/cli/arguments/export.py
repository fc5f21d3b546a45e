"""The arguments of ``humanoid-bt export``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import number
from humanoid_bt.cli.arguments.parsing import Commands
from humanoid_bt.session.limits import POSITIVE, Limit

_TIME = Limit(float, "an engine time in s, 0 or more", lambda value: 0 <= value < float("inf"), "s")

_DESCRIPTION = """\
Write what a recording holds for other programs: Parquet or CSV, a file for
each table in a folder; or MCAP, one file for Foxglove and PlotJuggler.
"""

_EXAMPLES = """\
examples:
  humanoid-bt export --to parquet
  humanoid-bt export runs/fetch-20260101-120000.rrd --to csv --tables joints,nodes --between 3 8
  humanoid-bt export --to mcap --output fetch.mcap --rate 1000

exit codes:
  0  written
  2  no recording, or a file that is there already: --force overwrites
"""


def add_export(commands: Commands) -> None:
    """Declare ``export``."""
    export = commands.add("export", "write a recording's data for other programs", _DESCRIPTION, _EXAMPLES)
    export.add_argument("recording", nargs="?", type=Path, metavar="RECORDING", help="default: the newest in runs/")
    export.add_argument(
        "--to", required=True, choices=["parquet", "csv", "mcap"], metavar="F", help="parquet, csv or mcap"
    )
    export.add_argument(
        "-o", "--output", type=Path, metavar="PATH", help="folder, of mcap the file; default: beside the recording"
    )
    export.add_argument(
        "--tables", default="", metavar="A,B", help="only these, of parquet and csv; see docs/data.md; default: all"
    )
    export.add_argument(
        "--between", nargs=2, type=number(_TIME), metavar=("S", "S"), help="only from one engine time to another [s]"
    )
    export.add_argument(
        "--rate",
        type=number(POSITIVE),
        default=200.0,
        metavar="HZ",
        help="samples a second of joints and body, at most 1000; default 200",
    )
    export.add_argument("--force", action="store_true", help="overwrite files that are there")
