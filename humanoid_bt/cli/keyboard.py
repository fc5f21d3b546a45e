"""What the keys in the terminal of a run do."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Event

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
_HELP = "keys: space or e emergency stop, p pause, q quit"  # a stop that waits for a reset tells its key itself
_PROMPT_HELP = "commands, until an empty line: help lists them; c and Enter continues"
_ANSWERS = 1.0  # s until the next line may be typed, though the last one has no answer yet


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
        if not quiet:
            console.print(_PROMPT_HELP, style="dim")
        console.print(":", end="")

    def take(line: str) -> bool:
        """Do what a line says; return whether the next one is a command as well, as most keys do too much for that."""
        printer.resume()
        line = line.strip().removeprefix(":").strip()
        if not line or line in goes_on:
            goes_on.get(line, lambda: None)()
            return False
        _answer(session, line, console)
        printer.suspend()
        console.print(":", end="")
        return True

    def end() -> None:
        session.interrupt("the key q")

    goes_on = {"c": go_on, "n": step, ".": step, "q": end}
    actions = {" ": stop, "e": stop, "r": reset, "p": pause, "n": step, ".": step, "c": go_on, "q": end}
    with keys.listening(actions, {":": keys.Prompt(begin, take)}):
        if not quiet:
            console.print(_HELP, style="dim")
        yield True


def _answer(session: Session, line: str, console: Console) -> None:
    """Do what a line says between two ticks, and show the answer; wait for it, as the next line comes below."""
    answered = Event()

    def say() -> None:
        try:
            if text := answer(session, line, _SOURCE):
                console.print(printable(text), soft_wrap=True, markup=False, highlight=False)
        except UserError as error:
            print_findings(error.problems, stderr=True)
        finally:
            answered.set()

    session.between_ticks(say)
    answered.wait(_ANSWERS)
