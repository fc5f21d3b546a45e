"""The command line: ``humanoid-bt``."""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from humanoid_bt import __version__
from humanoid_bt.errors import HumanoidBtError, UserError
from humanoid_bt.session.report import ExitCode

_EXIT_CODES = """\
exit codes:
  0  the tree succeeded
  1  the tree failed, or was still running at the end of --duration
  2  usage, or a mistake in a tree, skill, robot or scene file
  3  stopped for safety
  4  internal error, or an exception in a skill
"""

_RUN_EXAMPLES = """\
examples:
  humanoid-bt run fetch                           the built-in demo
  humanoid-bt run fetch --set reach_distance=0.45 with another parameter
  humanoid-bt run fetch --scene random_target --seed 7
  humanoid-bt run trees/mine.yaml --serve         watch it in a browser on this machine
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    arguments = _parser().parse_args(argv)
    try:
        return int(_dispatch(arguments))
    except UserError as error:
        print(_problems(error), file=sys.stderr)
        return ExitCode.USAGE
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return ExitCode.SUCCESS
    except HumanoidBtError as error:
        print(f"error: {error}", file=sys.stderr)
        return ExitCode.ERROR
    except Exception:
        traceback.print_exc()
        print("internal error: please report it with the lines above", file=sys.stderr)
        return ExitCode.ERROR


def _problems(error: UserError) -> str:
    lines = [f"error: {problem}" for problem in error.problems]
    if len(lines) > 1:
        lines.append(f"{len(lines)} problems")
    return "\n".join(lines)


def _dispatch(arguments: argparse.Namespace) -> int:
    if arguments.command == "run":
        from humanoid_bt.cli.run import run

        return run(arguments)
    if arguments.command == "bench":
        from humanoid_bt.cli.bench import bench

        return bench(arguments)
    from humanoid_bt.cli import inspect

    commands = {"check": inspect.check, "show": inspect.show, "skills": inspect.skills, "robots": inspect.robots}
    return commands[arguments.command](arguments)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="humanoid-bt",
        description="Run behavior trees on a humanoid robot.",
        epilog=_EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"humanoid-bt {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_run(commands)

    check = commands.add_parser(
        "check",
        help="find mistakes in tree, scene and robot files without running them",
        description="Find mistakes in tree, scene and robot files without running them.",
    )
    check.add_argument("paths", nargs="*", metavar="PATH", help="names, files or folders; default: this workspace")
    _add_workspace(check)

    show = commands.add_parser("show", help="draw a tree", description="Draw a tree.")
    show.add_argument("tree", metavar="TREE", help="name or file of a tree")
    show.add_argument("--format", choices=["unicode", "dot"], default="unicode", help="default: unicode")
    _add_workspace(show)

    skills = commands.add_parser(
        "skills", help="list skills and their parameters", description="List skills, or explain some."
    )
    skills.add_argument("names", nargs="*", metavar="NAME", help="explain only these, with their parameters")
    _add_workspace(skills)

    robots = commands.add_parser("robots", help="list robots", description="List the robots of this workspace.")
    _add_workspace(robots)

    bench = commands.add_parser(
        "bench",
        help="measure the engine beside baselines",
        description="Measure the engine; every figure is a ratio to a baseline measured in the same run.",
    )
    bench.add_argument("--repetitions", type=_positive_int, default=5, metavar="N", help="of each pair; default 5")
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures to this file too")
    return parser


def _add_run(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    run = commands.add_parser(
        "run",
        help="run a tree",
        description="Run a tree on a simulated robot, show what happens, record it.",
        epilog=_RUN_EXAMPLES + "\n" + _EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    run.add_argument("tree", metavar="TREE", help="name or file of a tree")
    run.add_argument("--robot", metavar="R", help="name or folder of a robot; default: what the tree says")
    run.add_argument("--scene", metavar="S", help="name or file of a scene; default: what the tree says")
    run.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", dest="overrides", help="set a parameter of the tree"
    )
    run.add_argument("--seed", type=_seed, default=0, metavar="N", help="of everything random; default 0")
    run.add_argument(
        "--duration", type=_positive, default=120.0, metavar="S", help="longest simulated time [s]; default 120"
    )
    run.add_argument(
        "--mode",
        choices=["lockstep"],
        default="lockstep",
        help="lockstep: all loops in step on simulated time, deterministic (default)",
    )
    run.add_argument(
        "--pace",
        type=_positive,
        metavar="X",
        help="simulated seconds per second; default: 1 with a live view, else as fast as it can",
    )
    view = run.add_mutually_exclusive_group()
    view.add_argument("--view", action="store_true", default=None, help="open the live view (default with a display)")
    view.add_argument("--no-view", action="store_false", dest="view", help="do not open the live view")
    run.add_argument(
        "--serve",
        nargs="?",
        type=_port,
        const=9090,
        metavar="PORT",
        help="serve the live view to a browser on 127.0.0.1; default port 9090",
    )
    record = run.add_mutually_exclusive_group()
    record.add_argument("--record", type=Path, metavar="FILE", help="recording; default: runs/TREE-DATE-TIME.rrd")
    record.add_argument("--no-record", action="store_true", help="write no recording")
    run.add_argument("--report", type=Path, metavar="FILE", help="write a report of the run as JSON")
    run.add_argument("--quiet", action="store_true", help="print only the summary")
    _add_workspace(run)


def _add_workspace(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--workspace",
        type=Path,
        metavar="DIR",
        help="folder with trees/, skills/, sim/; default: the tree file's own, else the working directory",
    )


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a positive number, not {text}")
    return value


def _positive_int(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be a positive whole number, not {text}")
    return value


def _seed(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"must not be negative, not {text}")
    return value


def _port(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 65534:
        raise argparse.ArgumentTypeError(f"must be a port from 1 to 65534, not {text}")
    return value


for _kind, _name in ((_positive, "number"), (_positive_int, "whole number"), (_seed, "seed"), (_port, "port")):
    _kind.__name__ = _name  # argparse names the type in its message
