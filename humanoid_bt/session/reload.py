"""Swapping edited trees in while the robot is held."""

from __future__ import annotations

from humanoid_bt.core.errors import HumanoidBtError, Problem
from humanoid_bt.session.edits import Edit, EditSource
from humanoid_bt.session.report import Reload
from humanoid_bt.session.teller import Teller
from humanoid_bt.session.tree_runner import TreeRunner
from humanoid_bt.tree.ticking.executor import Executor

_REPLACED = "replaced by an edited tree"


class Reloader:
    """Puts edited trees in the place of the one that runs.

    Args:
        edits: where they come from.
        runner: what runs the tree.
        teller: is told what came of every edit.
    """

    def __init__(self, edits: EditSource, runner: TreeRunner, teller: Teller) -> None:
        self._edits, self._runner, self._teller = edits, runner, teller

    def look(self) -> None:
        """Take the next edit, if there is one. To be called between two ticks."""
        edit = self._edits.poll()
        if edit is None:
            return
        changed = f"{', '.join(edit.files)} changed: "
        if edit.problems:
            self._tell(edit, "refused", changed + self._mistakes(edit))
        elif edit.executor is None:
            self._tell(edit, "unchanged", changed + "the mistakes are gone, and nothing else is new")
        else:
            self._tell(edit, "reloaded", changed + f"reloaded ({len(edit.executor.tree.nodes)} nodes)")
            self._swap(edit.executor)

    def _swap(self, executor: Executor) -> None:
        try:
            self._runner.halt(_REPLACED)
        except HumanoidBtError as error:  # all of the old tree has been halted all the same, and is gone
            self._teller.event("error", str(error))
        before = {(problem.message, problem.code) for problem in self._runner.tree.warnings}
        self._runner.replace(executor)
        self._teller.show(executor.tree)
        new = [problem for problem in executor.tree.warnings if (problem.message, problem.code) not in before]
        if new:
            self._teller.event("warning", "\n".join(["the edited tree has:", *map(_line, new)]))

    def _mistakes(self, edit: Edit) -> str:
        count = "1 mistake" if len(edit.problems) == 1 else f"{len(edit.problems)} mistakes"
        goes_on = "the robot waits for another edit" if self._runner.ended else "the old tree goes on"
        return "\n".join([f"{count}, {goes_on}", *map(_line, edit.problems)])

    def _tell(self, edit: Edit, outcome: str, text: str) -> None:
        source = edit.executor.tree.source if edit.executor else ""
        problems = [str(problem) for problem in edit.problems]
        self._teller.trace.reloaded(Reload(self._teller.now, list(edit.files), outcome, problems), source)
        self._teller.event("error" if edit.problems else "info", text)


def _line(problem: Problem) -> str:
    """Return a finding as ``humanoid-bt check`` prints it."""
    place = f"{problem.place}: " if problem.place else ""
    code = f" [{problem.code}]" if problem.code else ""
    text = f"{place}{problem.severity}: {problem.message}{code}\n{problem.hint}".rstrip("\n")
    return text.replace("\n", "\n    ")
