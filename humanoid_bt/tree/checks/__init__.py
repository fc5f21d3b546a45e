"""What is wrong or doubtful in a tree as a whole, found before it runs.

Each module is one family of checks; all of them look at drafts, so that they still find what they can where a file
has other mistakes.
"""

from __future__ import annotations

from collections.abc import Iterator

from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.tree.checks.facts import Facts
from humanoid_bt.tree.checks.reachability import check_reachability
from humanoid_bt.tree.checks.restarts import check_restarts
from humanoid_bt.tree.checks.robustness import check_hysteresis, check_time_limits
from humanoid_bt.tree.checks.safety import check_guards, check_overlaps
from humanoid_bt.tree.checks.world import World, check_world
from humanoid_bt.tree.draft import Draft

__all__ = ["World", "check"]


def check(root: Draft, world: World, alone: bool = False) -> list[Problem]:
    """Return what the checks find in a tree, each mistake of a file once however often the file is used.

    A percept that is told as a watchdog's misspelt one is not told as unknown to the scene, too.

    Args:
        root: the tree's root.
        world: the robot and the scene that it is made for.
        alone: whether it is a sub-tree that is looked at alone: what stands above it is then not known.
    """
    found: dict[tuple[str, Place | None, str], Problem] = {}
    for problem in _all(root, world, alone):
        found.setdefault((problem.code, problem.place, problem.message), problem)
    wrong = {problem.place for problem in found.values() if problem.severity == "error"}
    return [problem for problem in found.values() if problem.code != "unknown-percept" or problem.place not in wrong]


def _all(root: Draft, world: World, alone: bool) -> Iterator[Problem]:
    facts = Facts(root)
    yield from facts.problems
    if not alone:
        yield from check_guards(root, facts)
        yield from check_time_limits(root, facts)
    yield from check_overlaps(root, facts)
    yield from check_reachability(root, facts)
    yield from check_restarts(root, facts)
    yield from check_hysteresis(root, facts)
    yield from check_world(root, facts, world)
