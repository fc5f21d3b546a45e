"""The arguments of the command line, a file for each command that has many."""

from __future__ import annotations

import argparse

from humanoid_bt import __version__
from humanoid_bt.cli.arguments.bench import add_bench
from humanoid_bt.cli.arguments.campaign import add_campaign
from humanoid_bt.cli.arguments.check import add_check
from humanoid_bt.cli.arguments.coverage import add_coverage
from humanoid_bt.cli.arguments.diff import add_diff
from humanoid_bt.cli.arguments.explain import add_explain
from humanoid_bt.cli.arguments.export import add_export
from humanoid_bt.cli.arguments.fmt import add_fmt
from humanoid_bt.cli.arguments.init import add_init
from humanoid_bt.cli.arguments.interfaces import add_interfaces
from humanoid_bt.cli.arguments.lists import add_lists, add_robots
from humanoid_bt.cli.arguments.params import add_params
from humanoid_bt.cli.arguments.parsing import EXIT_CODES, Commands, Parser
from humanoid_bt.cli.arguments.plant import add_plant
from humanoid_bt.cli.arguments.recordings import add_keep, add_recordings
from humanoid_bt.cli.arguments.remote import add_estop, add_reset, add_status
from humanoid_bt.cli.arguments.replay import add_replay
from humanoid_bt.cli.arguments.run import add_run
from humanoid_bt.cli.arguments.schema import add_schema
from humanoid_bt.cli.arguments.show import add_show
from humanoid_bt.cli.arguments.test import add_test

_COMMANDS = (
    *(add_init, add_run, add_check, add_fmt, add_show, add_test),
    *(add_lists, add_robots, add_schema),
    *(add_coverage, add_campaign),
    *(add_explain, add_replay, add_diff, add_params, add_export),
    *(add_recordings, add_keep),
    *(add_plant, add_estop, add_reset, add_status),
    add_interfaces,
    add_bench,
)
"""What declares each command, in the order of the help."""


def parser() -> Parser:
    """Return the parser of the command line."""
    top = Parser(
        prog="humanoid-bt",
        description="Run behavior trees on a humanoid robot.",
        epilog="humanoid-bt COMMAND --help says more about a command.\n\n" + EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"humanoid-bt {__version__}")
    commands = Commands(top)
    for declare in _COMMANDS:
        declare(commands)
    return top
