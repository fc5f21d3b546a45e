"""The arguments of ``humanoid-bt run``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import number, size
from humanoid_bt.cli.arguments.parsing import EXIT_CODES, Commands, add_perception, add_workspace
from humanoid_bt.record.parts import PART_SIZE
from humanoid_bt.session.limits import DURATION, HOLD, PACE, PORT, SEED

_EXAMPLES = """\
examples:
  humanoid-bt run fetch                     the built-in demo
  humanoid-bt run fetch --set stop_distance=0.35
  humanoid-bt run fetch --params runs/fetch-20260101-120000.rrd    as then
  humanoid-bt run fetch --scene random_target --seed 7
  humanoid-bt run fetch --perception color_blob      see with the head camera
  humanoid-bt run fetch --plant udp://127.0.0.1:4747    on a robot in another process
  humanoid-bt run trees/mine.yaml --serve   watch it in a browser
  humanoid-bt run trees/mine.yaml --watch   edit it while it runs
  humanoid-bt run fetch --mode realtime --gateway gateways/mine.yaml      on ROS 2
  humanoid-bt run fetch --break reach       pause when it reaches; c continues, n is one tick

keys in its terminal:
  space, e  emergency stop    p  pause the run, or continue it
  r         reset             n  one tick, then pause again
  q         end the run       c  continue
                              :  a command to a paused run; help lists them
"""


def add_run(commands: Commands) -> None:
    """Declare ``run``."""
    run = commands.add("run", "run a tree", "Run a tree on a simulated robot.", _EXAMPLES + "\n" + EXIT_CODES)
    run.add_argument("tree", metavar="TREE", help="name or file of a tree")
    run.add_argument("--robot", metavar="R", help="name or folder of a robot; default: what the tree says")
    run.add_argument("--scene", metavar="S", help="name or file of a scene; default: what the tree says")
    run.add_argument(
        "--body",
        choices=["dcm", "policy", "own"],
        metavar="B",
        help="what walks and balances: dcm (footsteps from the model), or policy or own (the learned walker, or the "
        "Python file, that robot.yaml names); default: what robot.yaml says",
    )
    add_perception(run)
    run.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="overrides",
        help="set a parameter of the tree; may be given several times",
    )
    run.add_argument(
        "--params",
        type=Path,
        metavar="FILE",
        help="take the tree's parameters from this file of 'name: value' lines, or from a recording; --set wins",
    )
    run.add_argument(
        "--break",
        action="append",
        default=[],
        metavar="WHERE",
        dest="breakpoints",
        help="pause where a node starts (reach), gets a status (reach=FAILURE; or RUNNING, SUCCESS, HALTED), or an "
        "expression becomes true ('distance(target) < 0.5 m'); may be given several times; needs a terminal",
    )
    run.add_argument("--seed", type=number(SEED), default=0, metavar="N", help="of everything random; default 0")
    run.add_argument(
        "--duration",
        type=number(DURATION),
        metavar="S",
        help="longest simulated time, in s or as 2min; default: no end in realtime mode, with a live view or --watch; "
        "else 600 s, or what the tree's time-outs allow if that is more",
    )
    run.add_argument(
        "--on-estop",
        choices=["wait", "end"],
        metavar="W",
        help="what an emergency stop does to the run: wait (for a reset; default in realtime mode, with a live view "
        "or --watch) or end (exit code 3; default else); a fall always ends it",
    )
    run.add_argument(
        "--mode",
        choices=["lockstep", "realtime"],
        metavar="M",
        help="lockstep (default): all loops in step on simulated time, deterministic; "
        "realtime (default with --plant): control, decision and perception as processes on the wall clock",
    )
    run.add_argument(
        "--plant",
        metavar="ADDRESS",
        help="drive the robot that is served at udp://HOST:PORT, as by 'humanoid-bt plant', instead of simulating one",
    )
    run.add_argument(
        "--key",
        type=Path,
        metavar="FILE",
        help="key that the plant has too; needed where its address is not this machine's own",
    )
    run.add_argument(
        "--pace",
        type=number(PACE),
        metavar="X",
        help="simulated seconds per second; default: 1 with a live view or --watch, else as fast as it can",
    )
    run.add_argument(
        "--watch",
        action="store_true",
        help="when the tree or a skill of it is edited, let the robot stand and swap the new tree in; "
        "an edit with mistakes is told, and the old tree goes on; after the tree's end wait for an edit",
    )
    run.add_argument(
        "--hold",
        type=number(HOLD),
        default=10.0,
        metavar="S",
        help="realtime: how long control balances the robot when decision has died [s]; default 10",
    )
    run.add_argument(
        "--gateway",
        metavar="FILE",
        help="realtime: join the run with ROS 2 as this gateway file says, by its name or path",
    )
    view = run.add_mutually_exclusive_group()
    view.add_argument("--view", action="store_true", default=None, help="open the live view (default with a display)")
    view.add_argument("--no-view", action="store_false", dest="view", help="do not open the live view")
    run.add_argument(
        "--serve",
        nargs="?",
        type=number(PORT),
        const=9090,
        metavar="PORT",
        help="serve the live view to a browser on 127.0.0.1; default port 9090",
    )
    record = run.add_mutually_exclusive_group()
    record.add_argument("--record", type=Path, metavar="FILE", help="recording; default: runs/TREE-DATE-TIME.rrd")
    record.add_argument("--no-record", action="store_true", help="write no recording")
    run.add_argument(
        "--record-part-size",
        type=size,
        default=PART_SIZE,
        metavar="SIZE",
        help="size from which on the recording goes on in another file; default 500MB",
    )
    run.add_argument(
        "--camera",
        choices=["on", "off", "auto"],
        default="auto",
        metavar="C",
        help="record what the head camera sees: on, off, or auto (default), where that does not hold up the run",
    )
    run.add_argument("--report", type=Path, metavar="FILE", help="write a report of the run as JSON")
    run.add_argument("--quiet", action="store_true", help="print only errors and the summary")
    add_workspace(run)
