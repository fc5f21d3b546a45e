"""How a run ends."""

from __future__ import annotations

import traceback
from typing import NamedTuple

from humanoid_bt.core.errors import HumanoidBtError, Place
from humanoid_bt.decision.skill_files import class_file, place_in_file
from humanoid_bt.tree.engine.executor import NodeError
from humanoid_bt.tree.tree import Tree


class End(NamedTuple):
    """How a run ended.

    Attributes:
        outcome: of :data:`~humanoid_bt.session.report.OUTCOMES`.
        reason: why, in words.
        failure: what went wrong in a few words, "" if nothing did.
        traceback: of the exception that ended the run.
    """

    outcome: str
    reason: str
    failure: str = ""
    traceback: str = ""


def failed(error: HumanoidBtError) -> End:
    """Return the end of a run whose tree raised an error."""
    if not isinstance(error, NodeError):
        return End("error", str(error), str(error).splitlines()[0])
    name, cause = error.path.rsplit("/", 1)[-1], error.error
    failure = f"{name!r} raised {type(cause).__name__}: {cause}".splitlines()[0]
    return End("error", str(error), failure, "".join(traceback.format_exception(cause)))


def where(error: BaseException, tree: Tree) -> str:
    """Return in which line of a tree's skill an exception came, as " in FILE:LINE:COLUMN"; "" if in none."""
    for node in tree.nodes:
        file = class_file(node.type.cls) if node.kind == "skill" else None
        place: Place | None = place_in_file(error, file) if file else None
        if place is not None:
            return f" in {place}, in the node {node.path!r}"
    return ""
