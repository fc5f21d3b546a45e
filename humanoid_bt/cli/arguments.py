"""The arguments of the command line, and how a mistake in them is answered."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from humanoid_bt import __version__
from humanoid_bt.errors import nearest
from humanoid_bt.session import limits
from humanoid_bt.session.limits import Limit
from humanoid_bt.session.report import ExitCode

_EXIT_CODES = """\
exit codes:
  0    the tree succeeded
  1    the tree failed, or still ran at the end of --duration
  2    usage, or a mistake in a file
  3    stopped for safety
  4    internal error, or an exception in a skill
  130  interrupted
"""

_RUN_EXAMPLES = """\
examples:
  humanoid-bt run fetch                   the built-in demo
  humanoid-bt run fetch --set stop_distance=0.35
  humanoid-bt run fetch --scene random_target --seed 7
  humanoid-bt run trees/mine.yaml --serve in a browser
  humanoid-bt run trees/mine.yaml --watch and edit it meanwhile
"""

_BENCH_EXAMPLES = """\
examples:
  humanoid-bt bench
  humanoid-bt bench --tree                what a tick costs, of fetch and others
  humanoid-bt bench --tree trees/mine.yaml
  humanoid-bt bench --realtime            can this board do it?
  humanoid-bt bench --realtime --duration 60 --json board.json
"""

_CHECK_EXAMPLES = """\
examples:
  humanoid-bt check                       all of this folder
  humanoid-bt check fetch trees/mine.yaml skills/
  humanoid-bt check --strict --format sarif > check.sarif
  humanoid-bt check --explain outside-watchdog

exit codes:
  0  no errors
  2  errors, each with its file, line and column;
     with --strict, warnings too
"""

_SCHEMA_EXAMPLES = """\
examples:
  humanoid-bt schema -o .vscode/tree.schema.json
"""

_FMT = """\
Bring trees, scenes and robots into one form. Only indentation, blanks and
empty lines change: values, their order and every comment stay."""

_FMT_EXAMPLES = """\
examples:
  humanoid-bt fmt                         all trees of this folder
  humanoid-bt fmt trees/mine.yaml sim     a file, and all scenes and robots
  humanoid-bt fmt --check                 before a commit, or in CI

exit codes:
  0  all files have this form now
  1  with --check or --diff: some would change
  2  mistakes in files, which are left as they are
"""

_SHOW_EXAMPLES = """\
examples:
  humanoid-bt show fetch
  humanoid-bt show fetch -o fetch.svg     a picture
  humanoid-bt show fetch -o fetch.mmd     for a Markdown page
  humanoid-bt show --live                 the tree that runs

marks of a tree that runs:
  ▶ running   ✓ succeeded   ✗ failed   ○ neither
"""


_ESTOP_EXAMPLES = """\
examples:
  humanoid-bt estop                       every robot that runs
  humanoid-bt estop --reason "it is in the way"

exit codes:
  0  stopped
  2  no robot is running
  4  the e-stop is raised, but a robot did not show that it stopped
"""

_RESET_EXAMPLES = """\
exit codes:
  0  done
  2  no robot is running, or several: give --run
  3  refused, with the reason
  4  no answer
"""


class Parser(argparse.ArgumentParser):
    """An argument parser that says in two lines what is wrong and what would be valid."""

    def error(self, message: str) -> NoReturn:
        """Print a mistake and exit."""
        print(f"error: {message}\n    see: {self.prog} --help", file=sys.stderr)
        sys.exit(ExitCode.USAGE)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse the arguments; what no command knows is answered with what it does know."""
        values, unknown = self.parse_known_args(args, namespace)
        if unknown:
            command = self._command(values.command)
            known = [option for action in command._actions for option in action.option_strings]
            close = nearest(unknown[0].split("=")[0], known).partition("valid:")[0].strip()
            command.error(f"unknown argument {unknown[0]!r}" + (f"; {close}" if close else ""))
        return values

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            what = "command" if action.dest == "command" else action.option_strings[0]
            self.error(f"unknown {what} {value!r}: {nearest(value, map(str, action.choices))}")

    def _command(self, name: str) -> Parser:
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                chosen: Parser = action.choices[name]
                return chosen
        return self


def parser() -> Parser:
    """Return the parser of the command line."""
    top = Parser(
        prog="humanoid-bt",
        description="Run behavior trees on a humanoid robot.",
        epilog="humanoid-bt COMMAND --help says more about a command.\n\n" + _EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"humanoid-bt {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def command(name: str, text: str, description: str, epilog: str = "") -> Parser:
        added: Parser = commands.add_parser(
            name,
            help=text,
            description=description,
            epilog=epilog,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        return added

    _add_run(
        command("run", "run a tree", "Run a tree on a simulated robot.", _RUN_EXAMPLES + "\n" + _EXIT_CODES),
    )
    _add_check(command("check", "find mistakes in files", "Find mistakes without running anything.", _CHECK_EXAMPLES))

    _add_fmt(command("fmt", "format files", _FMT, _FMT_EXAMPLES))

    show = command("show", "draw a tree, also while it runs", "Draw a tree, or one that runs.", _SHOW_EXAMPLES)
    _add_show(show)

    skills = command("skills", "list skills and their parameters", "List skills, or explain some.")
    skills.add_argument("names", nargs="*", metavar="NAME", help="explain only these")
    _add_workspace(skills)

    schema = command(
        "schema",
        "write a JSON Schema for editors",
        "Write a JSON Schema of this workspace's tree files, its skills and\n"
        "sub-trees included. Editors complete, explain and check with it.",
        _SCHEMA_EXAMPLES,
    )
    schema.add_argument("-o", "--output", type=Path, metavar="FILE", help="write it to this file; default: print it")
    _add_workspace(schema)

    robots = command("robots", "list robots", "List the robots of this workspace.")
    _add_workspace(robots)

    estop = command(
        "estop",
        "stop every running robot",
        "Raise the emergency stop of every running robot, and see\nthat it stops. It stays stopped until a reset.",
        _ESTOP_EXAMPLES,
    )
    _add_run_id(estop)
    estop.add_argument("--reason", default="raised by hand", metavar="TEXT", help="why; goes into the recording")
    _add_run_id(
        command(
            "reset",
            "let a stopped robot go on",
            "Clear an emergency stop, or a stop after a fall. It is\nrefused while a cause persists.",
            _RESET_EXAMPLES,
        )
    )
    status = command("status", "show a running robot", "Show a running robot.")
    _add_run_id(status)
    status.add_argument("--json", action="store_true", help="for programs")

    bench = command(
        "bench",
        "measure the engine beside baselines",
        "Measure the engine. Every cost is a ratio to a baseline measured\nin the same run.",
        _BENCH_EXAMPLES,
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
        type=_number(_PHASE),
        default=10.0,
        metavar="S",
        help="with --realtime: how long each loop is watched [s]; default 10",
    )
    bench.add_argument(
        "--repetitions", type=_number(_COUNT), default=5, metavar="N", help="of each pair, or each cause; default 5"
    )
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures to this file too")
    return top


def _add_run(run: Parser) -> None:
    run.add_argument("tree", metavar="TREE", help="name or file of a tree")
    run.add_argument("--robot", metavar="R", help="name or folder of a robot; default: what the tree says")
    run.add_argument("--scene", metavar="S", help="name or file of a scene; default: what the tree says")
    run.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="overrides",
        help="set a parameter of the tree; may be given several times",
    )
    run.add_argument(
        "--seed", type=_number(limits.SEED), default=0, metavar="N", help="of everything random; default 0"
    )
    run.add_argument(
        "--duration",
        type=_number(limits.DURATION),
        metavar="S",
        help="longest simulated time [s]; default 120, with --watch no end",
    )
    run.add_argument(
        "--mode",
        choices=["lockstep", "realtime"],
        default="lockstep",
        metavar="M",
        help="lockstep (default): all loops in step on simulated time, deterministic; "
        "realtime: control, decision and perception as processes on the wall clock",
    )
    run.add_argument(
        "--pace",
        type=_number(limits.POSITIVE),
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
        type=_number(limits.POSITIVE),
        default=10.0,
        metavar="S",
        help="realtime: how long control balances the robot when decision has died [s]; default 10",
    )
    view = run.add_mutually_exclusive_group()
    view.add_argument("--view", action="store_true", default=None, help="open the live view (default with a display)")
    view.add_argument("--no-view", action="store_false", dest="view", help="do not open the live view")
    run.add_argument(
        "--serve",
        nargs="?",
        type=_number(limits.PORT),
        const=9090,
        metavar="PORT",
        help="serve the live view to a browser on 127.0.0.1; default port 9090",
    )
    record = run.add_mutually_exclusive_group()
    record.add_argument("--record", type=Path, metavar="FILE", help="recording; default: runs/TREE-DATE-TIME.rrd")
    record.add_argument("--no-record", action="store_true", help="write no recording")
    run.add_argument("--report", type=Path, metavar="FILE", help="write a report of the run as JSON")
    run.add_argument("--quiet", action="store_true", help="print only errors and the summary")
    _add_workspace(run)


def _add_fmt(fmt: Parser) -> None:
    fmt.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="names, files or folders of trees, scenes, robots; default: the trees of this workspace",
    )
    fmt.add_argument("--check", action="store_true", help="change nothing, name the files that would change")
    fmt.add_argument("--diff", action="store_true", help="change nothing, show what would change")
    _add_workspace(fmt)


def _add_show(show: Parser) -> None:
    show.add_argument("tree", nargs="?", metavar="TREE", help="name or file of a tree")
    show.add_argument(
        "--format",
        choices=["unicode", "svg", "dot", "mermaid"],
        metavar="F",
        help="unicode (default), svg, dot or mermaid; default: what FILE's suffix says",
    )
    show.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="write it to this .txt, .svg, .dot or .mmd file"
    )
    show.add_argument(
        "--live",
        action="store_true",
        help="instead of TREE: the tree that runs in another terminal, with the status of every node; "
        "at a terminal until Ctrl-C, else once",
    )
    show.add_argument("--run", metavar="ID", help="with --live: which run, if there are several")
    _add_workspace(show)


def _add_check(check: Parser) -> None:
    check.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="names, files or folders of trees, skills, scenes, robots; default: this workspace",
    )
    check.add_argument("--strict", action="store_true", help="let warnings fail as errors do")
    check.add_argument(
        "--format",
        choices=["text", "json", "sarif"],
        default="text",
        metavar="F",
        help="text (default), json, or sarif for code scanning",
    )
    check.add_argument(
        "--explain", nargs="?", const="", metavar="CODE", help="say what a code means, or list all of them"
    )
    _add_workspace(check)


def _add_run_id(command: Parser) -> None:
    command.add_argument("--run", metavar="ID", help="which run, if there are several")


def _add_workspace(command: Parser) -> None:
    command.add_argument(
        "--workspace",
        type=Path,
        metavar="DIR",
        help="folder with trees/, skills/, sim/; default: the tree file's own, else the working directory",
    )


def _number(limit: Limit) -> Callable[[str], Any]:
    """Return what reads a number and says what would be valid if it is not."""

    def read(text: str) -> Any:
        try:
            return limit.read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"must be {limit.valid}, not {text!r}") from error

    return read


_PHASE = Limit(float, "a number from 0.1 to 3600", lambda value: 0.1 <= value <= 3600)
_COUNT = Limit(int, "a whole number above 0", lambda value: value > 0)
