"""Trees to draw: of any shape, and with names that mean something to whoever reads the drawing."""

from __future__ import annotations

import random

from py_trees.common import Status

from humanoid_bt.tree.show import Outline, OutlineNode

NASTY = (
    '"quoted" <b>&amp; #35;',
    "a|b{c}[d](e);:::x",
    "back\\slash \\n \\N",
    "`code` *bold* $$x$$",
    "%% comment --> end",
    "Übergabe → 手渡す",
    "carefully_approach_the_target_from_the_left_side_of_the_table",
    "]]> --",
)
_KINDS = ("composite", "decorator", "condition", "action", "skill", "subtree", "something new")
_WORDS = ("reach", "get near", "sequence", "percept: target", *NASTY)


def random_outline(seed: int, size: int = 40) -> Outline:
    """Return a tree of any shape, in the order of a file: each node, then what is below it."""
    choose = random.Random(seed)
    nodes: list[OutlineNode] = []
    line: list[int] = []  # of ancestors
    for index in range(size):
        line = line[: choose.randint(1, len(line))] if line else []
        name = choose.choice(_WORDS).replace("/", " ")
        nodes.append(
            OutlineNode(
                path=f"tree/{index} {name}",
                name=name,
                type_name=choose.choice(("act", "sequence", "parallel", name)),
                kind=choose.choice(_KINDS),
                parent=line[-1] if line else -1,
                branch=choose.choice(("", "", "on_stale", "case <left>")) if line else "",
                parameters=tuple(f"p{k}: {choose.choice(_WORDS)}" for k in range(choose.randint(0, 3))),
                doc=choose.choice(NASTY),
            )
        )
        line.append(index)
    return Outline('a "tree" & <more>', choose.choice(NASTY), tuple(nodes))


def random_statuses(outline: Outline, seed: int = 0) -> dict[str, Status]:
    """Return any status for each node."""
    choose = random.Random(seed)
    return {node.path: choose.choice(list(Status)) for node in outline.nodes}
