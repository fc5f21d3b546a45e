"""The parser of the command line: how a mistake in the arguments is answered, and what commands share."""

from __future__ import annotations

import argparse
import sys
import textwrap
from pathlib import Path
from typing import Any, NoReturn

from humanoid_bt.core.errors import nearest
from humanoid_bt.session.report import ExitCode

EXIT_CODES = """\
exit codes:
  0    the tree succeeded
  1    the tree failed
  2    usage, or a mistake in a file
  3    stopped for safety
  4    internal error, or an exception in a skill
  5    the tree still ran when its time was up
  130  interrupted
"""


class _Help(argparse.RawDescriptionHelpFormatter):
    """Wraps paragraphs, and keeps the lines of tables and examples, which are indented."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.split("\n\n")
        return "\n\n".join(
            textwrap.indent(part, indent) if "\n " in part else textwrap.fill(part, width, initial_indent=indent)
            for part in paragraphs
        )


class Parser(argparse.ArgumentParser):
    """An argument parser that says in two lines what is wrong and what would be valid."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._words: dict[str, Parser] = {}

    def add_word(self, word: str, what: str, description: str, epilog: str) -> Parser:
        """Return the parser of what a command does whose first argument is a word, with arguments of its own.

        Args:
            word: it.
            what: the arguments that follow it, which come into ``what`` behind it.
            description, epilog: for its help.
        """
        prog = f"{self.prog} {word}"
        added = Parser(
            prog=prog, usage=f"{prog} {what} [options]", description=description, epilog=epilog, formatter_class=_Help
        )
        added.add_argument("what", nargs="*", help=argparse.SUPPRESS)
        self._words[word] = added
        return added

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse the arguments; those behind a word with the parser of that."""
        if not self._words:
            return super().parse_known_args(args, namespace)
        given = list(args)
        word = given[0] if {"-h", "--help"} & set(given) else ""
        if word not in self._words:
            parsed = super().parse_known_args(given, namespace)
            word, *rest = parsed[0].what
            if word not in self._words or not rest:  # a tree may be called so too
                return parsed
        given.remove(word)
        values, unknown = self._words[word].parse_known_args(given, namespace)
        if unknown:
            self._words[word].error(f"{self._words[word].prog.partition(' ')[2]} takes no {unknown[0]!r}")
        values.what = [word, *values.what]
        return values, []

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


class Commands:
    """The commands of a parser.

    Args:
        parser: whose commands they are.
    """

    def __init__(self, parser: Parser) -> None:
        self._commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def add(self, name: str, text: str, description: str, epilog: str = "") -> Parser:
        """Return the parser of one more command.

        Args:
            name: the command.
            text: what it does, for the list of commands.
            description: the same in more words, for its own help.
            epilog: examples and exit codes.
        """
        added: Parser = self._commands.add_parser(
            name,
            help=text,
            description=description,
            epilog=epilog,
            formatter_class=_Help,
        )
        return added


def add_run_id(command: Parser) -> None:
    """Let a command say which running robot it is for."""
    command.add_argument("--run", metavar="ID", help="its id or how that begins, if several run")


def add_perception(command: argparse._ActionsContainer) -> None:
    """Let a command say what the robot sees with."""
    command.add_argument(
        "--perception",
        action="append",
        default=[],
        metavar="SOURCE",
        help="see with this percept source: its name, or with parameters 'NAME: {PARAMETER: VALUE}'; may be given "
        "several times; default: what the tree says, or the scene",
    )


def add_workspace(command: Parser) -> None:
    """Let a command say where names are looked up."""
    command.add_argument(
        "--workspace",
        type=Path,
        metavar="DIR",
        help="folder with trees/, skills/, sim/, scenarios/; default: the tree file's own, else the working directory",
    )
