"""What the keys in the terminal of a run do."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from rich.console import Console

from humanoid_bt.cli import keys
from humanoid_bt.cli.commands import answer
from humanoid_bt.cli.findings import print_findings
from humanoid_bt.cli.printer import Printer
from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.core.texts import printable
from humanoid_bt.session.session import Session

_SOURCE = "keyboard"
_REASON = "a key was pressed"
_HELP = "keys: space or e emergency stop, r reset, p pause, q quit"


@contextmanager
def connected(session: Session, console: Console, printer: Printer, quiet: bool) -> Iterator[bool]:
    """Let keys stop, reset, pause and end a run, if somebody sits at a terminal; give whether somebody does."""
    if not keys.available():
        yield False
        return

    def stop() -> None:
        with suppress(HumanoidBtError):  # the robot stands, and the run is over
            session.raise_estop(_REASON, source=_SOURCE)

    def reset() -> None:
        try:
            session.request_reset(source=_SOURCE)
        except HumanoidBtError as error:
            print(f"error: no reset: {error}", file=sys.stderr)

    def pause() -> None:
        if session.paused is not None:
            go_on()
            return
        with suppress(HumanoidBtError):
            session.pause(_REASON, source=_SOURCE)

    def step() -> None:
        session.request_step(source=_SOURCE)

    def go_on() -> None:
        session.resume(source=_SOURCE)

    def begin() -> None:
        if session.paused is None:
            pause()
        printer.suspend()
        console.print(":", end="")

    def take(line: str) -> None:
        printer.resume()
        if line.strip():
            session.between_ticks(lambda: say(line))

    def say(line: str) -> None:
        try:
            if text := answer(session, line, _SOURCE):
                console.print(printable(text), soft_wrap=True, markup=False, highlight=False)
        except UserError as error:
            print_findings(error.problems, stderr=True)

    def end() -> None:
        session.interrupt("the key q")

    actions = {" ": stop, "e": stop, "r": reset, "p": pause, "n": step, ".": step, "c": go_on, "q": end}
    with keys.listening(actions, {":": keys.Prompt(begin, take)}):
        if not quiet:
            console.print(_HELP, style="dim")
        yield True
