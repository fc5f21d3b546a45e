"""The arguments of ``humanoid-bt bench``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import COUNT, PHASE, number
from humanoid_bt.cli.arguments.parsing import Commands

_EXAMPLES = """\
examples:
  humanoid-bt bench
  humanoid-bt bench --tree                what a tick costs, of fetch and others
  humanoid-bt bench --tree trees/mine.yaml
  humanoid-bt bench --realtime            can this board do it?
  humanoid-bt bench --realtime --duration 60 --json board.json
"""


def add_bench(commands: Commands) -> None:
    """Declare ``bench``."""
    bench = commands.add(
        "bench",
        "measure the engine beside baselines",
        "Measure the engine. Every cost is a ratio to a baseline measured\nin the same run.",
        _EXAMPLES,
    )
    what = bench.add_mutually_exclusive_group()
    what.add_argument(
        "--tree",
        nargs="?",
        const="fetch",
        metavar="TREE",
        help="measure trees only: a tick of this one (default: fetch) and of one of 40 nodes beside plain py_trees, "
        "and loading one of 500 nodes beside plain YAML",
    )
    what.add_argument(
        "--realtime",
        action="store_true",
        help="measure realtime mode instead: how punctual the servo is beside the same loop in C, "
        "and how quickly the robot stops, idle and with every core busy; takes 2 to 3 minutes",
    )
    bench.add_argument(
        "--duration",
        type=number(PHASE),
        default=10.0,
        metavar="S",
        help="with --realtime: how long each loop is watched [s]; default 10",
    )
    bench.add_argument(
        "--repetitions", type=number(COUNT), default=5, metavar="N", help="of each pair, or each cause; default 5"
    )
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures to this file too")
