"""The arguments of the commands for a robot that runs: ``estop``, ``reset``, ``status``."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands, add_run_id

_ESTOP_EXAMPLES = """\
examples:
  humanoid-bt estop                       every robot that runs
  humanoid-bt estop --reason "it is in the way"

exit codes:
  0  stopped
  2  no robot is running
  4  not of every robot it is known that it stopped
"""

_RESET_EXAMPLES = """\
exit codes:
  0  done
  2  no robot is running, or several: give --run
  3  refused, with the reason
  4  no answer
"""


def add_estop(commands: Commands) -> None:
    """Declare ``estop``."""
    estop = commands.add(
        "estop",
        "stop every running robot",
        "Raise the emergency stop of every robot of yours that runs,\nin either mode, and see that it stops. "
        "It stays stopped until\na reset.",
        _ESTOP_EXAMPLES,
    )
    add_run_id(estop)
    estop.add_argument("--reason", default="raised by hand", metavar="TEXT", help="why; goes into the recording")


def add_reset(commands: Commands) -> None:
    """Declare ``reset``."""
    add_run_id(
        commands.add(
            "reset",
            "let a stopped robot go on",
            "Clear an emergency stop, or a stop after a fall. It is\nrefused while a cause persists.",
            _RESET_EXAMPLES,
        )
    )


def add_status(commands: Commands) -> None:
    """Declare ``status``."""
    status = commands.add("status", "show running robots", "Show every robot of yours that runs, in either mode.")
    add_run_id(status)
    status.add_argument("--json", action="store_true", help="for programs: a list of runs")
