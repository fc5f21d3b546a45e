"""The arguments of ``humanoid-bt bench``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import COUNT, PHASE, number
from humanoid_bt.cli.arguments.parsing import Commands
from humanoid_bt.session.limits import SEED

_EXAMPLES = """\
examples:
  humanoid-bt bench
  humanoid-bt bench --tree                what a tick costs, of fetch and others
  humanoid-bt bench --tree trees/mine.yaml
  humanoid-bt bench --realtime            can this board do it?
  humanoid-bt bench --realtime --duration 60 --json board.json
  humanoid-bt bench --speed --robot sim/mine   how fast is it simulated?
  humanoid-bt bench --body -j 2           what does the robot withstand?
  humanoid-bt bench --body --robot sim/mine --only goals 'push-*' --trials 50

exit codes:
  0    measured; --body: every row keeps its promise
  1    --body: some row does not
  2    usage, or a mistake in a file
  4    internal error
  130  interrupted; --body has told what it knew
"""


def add_bench(commands: Commands) -> None:
    """Declare ``bench``."""
    bench = commands.add(
        "bench",
        "measure the engine beside baselines",
        "Measure the engine, where every cost is a ratio to a baseline measured in the same run; or, with --body, "
        "what a robot's balance and walking withstand.",
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
    what.add_argument(
        "--body",
        action="store_true",
        help="measure instead how often a robot reaches random goals and stays on its feet: pushed, on ice, on plates "
        "and slopes, with loads, weak and late drives, a wrong encoder; takes about half an hour",
    )
    what.add_argument(
        "--speed",
        action="store_true",
        help="measure instead how many times faster than real time a robot is simulated with each of its bodies, as it "
        "stands and as it walks, and what a solve of inverse kinematics takes",
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
    robot = bench.add_argument_group("with --body or --speed")
    robot.add_argument("--robot", metavar="R", help="name, folder or robot.yaml; default: humanoid")
    robot.add_argument("--walk", choices=("policy", "own", "dcm"), help="of a robot with several bodies, only this one")
    robot.add_argument("--workspace", type=Path, metavar="DIR", help="where robots are looked up; default: here")
    body = bench.add_argument_group("with --body")
    body.add_argument("--only", nargs="+", metavar="ROW", help="rows, by name or pattern ('push-*'); default: all")
    body.add_argument("--trials", type=number(COUNT), metavar="N", help="of each row; default 20")
    body.add_argument("--seed", type=number(SEED), metavar="FIRST", help="of the first trial; default 0")
    body.add_argument("-j", "--workers", type=number(COUNT), metavar="N", help="trials at a time; default 1")
    body.add_argument("--record", action="store_true", help="record every trial to runs/")
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures to this file too")
