"""Running a tree with one call."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import ParamSpec

from humanoid_bt.core.errors import UserError
from humanoid_bt.session.report import Report
from humanoid_bt.session.session import Session

_P = ParamSpec("_P")


def _runs(session: Callable[_P, Session]) -> Callable[_P, Report]:
    """Return what makes a session and runs it to its end, with the same arguments."""

    def run(*arguments: _P.args, **named: _P.kwargs) -> Report:
        """Run a tree to its end and return the report: ``Session(...).run()``.

        Args:
            arguments, named: those of :class:`~humanoid_bt.session.session.Session`.

        Raises:
            UserError: an argument, the tree, robot, scene or a skill has mistakes, or a sink cannot be opened.
            NodeError: a skill raised an exception in ``setup``.
            KeyboardInterrupt: somebody ended it with Ctrl-C; the robot was brought to a stand first.
        """
        if not arguments and "tree" not in named:
            raise UserError("which tree? It is the first argument", hint='hbt.run("fetch")')
        return session(*arguments, **named).run()

    signature = inspect.signature(session).replace(return_annotation="Report")
    vars(run).update(__signature__=signature)
    run.__qualname__ = "run"
    return run


run = _runs(Session)
