"""Tree files but for their nodes: keys, the long form of parameters, what expressions can ask."""

from __future__ import annotations

from humanoid_bt.core.params import params_of
from humanoid_bt.tree.expressions.quantities import TRUTH
from humanoid_bt.tree.expressions.vocabulary import PERCEPT, SEEN, STATE
from humanoid_bt.tree.source.file import PARTS, Header
from humanoid_bt.tree.source.parameters import TYPES, LongForm
from parts.markdown import code, table
from parts.parameters import parameter_row, parameter_table


def tree_keys() -> str:
    """Return the table of a tree file's keys."""
    rows = [parameter_row(spec) for spec in params_of(Header).values()]
    rows += [(f"`{name}`", "node" if name == "root" else "mapping", "", doc) for name, doc in PARTS.items()]
    return parameter_table("key", rows)


def parameter_keys() -> str:
    """Return the table of the keys of a tree's parameter written in full."""
    rows = [parameter_row(spec) for spec in params_of(LongForm).values()]
    return f"{parameter_table('key', rows)}\n\nTypes: {code(TYPES)}."


def percept_words() -> str:
    """Return what expressions can ask of percepts."""
    rows = [(f"`target.{name}`", str(word.type), word.doc) for name, word in PERCEPT.items()]
    rows.append((f"`{SEEN}(target)`", str(TRUTH), "Whether it was ever seen."))
    return table(("expression", "is", "meaning"), rows)


def state_words() -> str:
    """Return what expressions can ask of the robot's state."""
    rows = [(f"`state.{name}`", str(word.type), word.doc) for name, word in STATE.items()]
    return table(("expression", "is", "meaning"), rows)
