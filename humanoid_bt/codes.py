"""The codes of all findings: what each means, whether it keeps a file from being used, an example.

A code is a stable name for one kind of mistake: people allow warnings by it, programs tell findings apart by it.
"""

from __future__ import annotations

from dataclasses import dataclass

from humanoid_bt.errors import Severity, UserError, nearest


@dataclass(frozen=True)
class Code:
    """One kind of finding.

    Attributes:
        name: the code.
        meaning: one sentence.
        severity: an error keeps a file from being used; a warning does not, and can be allowed in the file.
        wrong: a part of a file that has the mistake, "" where no short one shows it.
        right: the same without it.
    """

    name: str
    meaning: str
    severity: Severity = "error"
    wrong: str = ""
    right: str = ""


def _error(name: str, meaning: str, wrong: str = "", right: str = "") -> Code:
    return Code(name, meaning, "error", wrong, right)


def _warning(name: str, meaning: str, wrong: str = "", right: str = "") -> Code:
    return Code(name, meaning, "warning", wrong, right)


_FILES = (
    _error("no-file", "There is no file, folder or thing of this name."),
    _error("unreadable", "The file cannot be read, or is not UTF-8 text."),
    _error(
        "syntax",
        "The file is not YAML, or has a tag, an alias or a key that is not supported.",
        "reach: {target: target",
        "reach: {target: target}",
    ),
    _error("too-large", "The file holds too many values or is nested too deeply; aliases are expanded."),
    _error(
        "format",
        "The file has a form that this version does not read.",
        "format: 2\nroot: {emergency_stop: idle}",
        "format: 1\nroot: {emergency_stop: idle}",
    ),
    _error(
        "duplicate-key",
        "A key stands twice in one mapping.",
        "reach: {target: target, hand: left, hand: right}",
        "reach: {target: target, hand: left}",
    ),
    _error(
        "unknown-key",
        "A file does not have this key.",
        "format: 1\nscen: ball_on_stand\nroot: {emergency_stop: idle}",
        "format: 1\nscene: ball_on_stand\nroot: {emergency_stop: idle}",
    ),
    _error(
        "missing-key",
        "A key that is required is not there.",
        "format: 1\nname: nothing to do",
        "format: 1\nroot: {emergency_stop: idle}",
    ),
    _error("misplaced-key", "A key has no meaning beside the others that are there."),
    _error("exclusive-keys", "Of several keys, exactly one must be given."),
)

_VALUES = (
    _error(
        "unknown-parameter",
        "A node, or what was set by name, does not have this parameter.",
        "reach: {target: target, hnad: left}",
        "reach: {target: target, hand: left}",
    ),
    _error("missing-parameter", "A parameter that is required has no value.", "reach:", "reach: {target: target}"),
    _error("wrong-type", "A value is of the wrong type.", "idle: {look_around: often}", "idle: {look_around: true}"),
    _error("wrong-length", "A list has too few or too many values."),
    _error(
        "wrong-unit",
        "A value has a unit that its parameter is not given in.",
        "within: {percept: target, distance: 30 s}",
        "within: {percept: target, distance: 30 cm}",
    ),
    _error(
        "wrong-choice",
        "A value is none of those that are possible.",
        "reach: {target: target, hand: both}",
        "reach: {target: target, hand: nearest}",
    ),
    _error(
        "out-of-range",
        "A number is not within its bounds.",
        "confident: {percept: target, above: 1.5}",
        "confident: {percept: target, above: 0.6}",
    ),
    _error(
        "bad-name",
        "This cannot be the name of a node, a tree or a parameter.",
        "idle: {name: a/b}",
        "idle: {name: a or b}",
    ),
    _error(
        "unknown-reference",
        "A $name is neither a parameter of the tree nor a key that it writes.",
        "approach: {target: target, distance: $distanse}",
        "approach: {target: target, distance: 0.5 m}",
    ),
    _error(
        "expression",
        "An expression cannot be read, or its types or units do not go together.",
        "condition: distance(target) < 3 s",
        "condition: distance(target) < 3 m hysteresis 20 cm",
    ),
    _error(
        "unused-parameter",
        "No node uses this parameter of the tree.",
        "format: 1\nparameters: {distance: 0.5 m}\nroot: {emergency_stop: idle}",
        "format: 1\nroot: {emergency_stop: idle}",
    ),
    _error(
        "unwritten-key",
        "A key of the blackboard, or an output, that nothing writes.",
        "format: 1\nblackboard: {tries: {type: number}}\nroot: {condition: tries < 3}",
        "format: 1\nblackboard: {tries: 0}\nroot: {condition: tries < 3}",
    ),
    _error(
        "not-dynamic",
        "A value must be known before the run, and a key of the blackboard is not.",
        "for_each:\n  item: n\n  items: [1, 2]\n  retry: {attempts: $n, reach: {target: target}}",
        "for_each:\n  item: side\n  items: [left, right]\n  reach: {target: target, hand: $side}",
    ),
    _warning(
        "unused-key",
        "Nothing reads this key of the blackboard.",
        "format: 1\nblackboard: {tries: 0}\nroot: {emergency_stop: idle}",
        "format: 1\nroot: {emergency_stop: idle}",
    ),
)

_TREES = (
    _error(
        "unknown-node", "No node type and no skill has this name.", "reech: {target: target}", "reach: {target: target}"
    ),
    _error("not-a-node", "Something else stands where a node must stand.", "sequence:\n  - 3", "sequence:\n  - idle"),
    _error("missing-child", "A node that needs a child has none.", "sequence: []", "sequence: [idle]"),
    _error(
        "extra-child",
        "A node has a child where it can have none, or more than it can have.",
        "inverter: {idle: , reach: {target: target}}",
        "inverter: {sequence: [idle, reach: {target: target}]}",
    ),
    _error(
        "invalid-node",
        "A node cannot be made with these parameters.",
        "confident: {percept: target, above: 0.2, hysteresis: 0.5}",
        "confident: {percept: target, above: 0.6, hysteresis: 0.1}",
    ),
    _error("subtree-cycle", "A tree holds itself, through the files of its sub-trees."),
    _warning(
        "unreachable",
        "A node is never ticked: what stands before or above it never lets it have its turn.",
        "selector: [idle, reach: {target: target}]",
        "selector: [reach: {target: target}, idle]",
    ),
    _warning(
        "no-effect",
        "A retry, repeat or timeout has nothing to do: its child never fails, succeeds or runs.",
        "timeout: {duration: 5 s, within: {percept: target, distance: 0.5 m}}",
        "timeout: {duration: 5 s, wait_until: distance(target) < 0.5 m}",
    ),
    _warning(
        "never-succeeds",
        "A parallel needs more successes than its children can bring.",
        "parallel: [idle, wait: 5 s]",
        "parallel: {success: one, children: [idle, wait: 5 s]}",
    ),
    _warning(
        "no-hysteresis",
        "A condition on a jittery percept may flap: it is checked again and again without hysteresis.",
        "sequence:\n  - condition: distance(target) < 0.5 m\n  - reach: {target: target}",
        "sequence:\n  - condition: distance(target) < 0.5 m hysteresis 5 cm\n  - reach: {target: target}",
    ),
    _warning(
        "no-time-limit",
        "A node that may run for ever, although the tree waits for its end, stands below no time limit.",
        "approach: {target: target}",
        "timeout: {duration: 60 s, approach: {target: target}}",
    ),
)

_SAFETY = (
    _error(
        "outside-emergency-stop",
        "A node commands the robot outside an emergency_stop.",
        "format: 1\nroot: idle",
        "format: 1\nroot: {emergency_stop: idle}",
    ),
    _error(
        "outside-watchdog",
        "A percept is used outside a watchdog on it.",
        "reach: {target: cup}",
        "watchdog: {percept: cup, max_age: 500 ms, reach: {target: cup}}",
    ),
    _error(
        "resource-overlap",
        "Children of a parallel command the same resource.",
        "parallel:\n  - reach: {target: target, hand: left}\n  - reach: {target: target, hand: left}",
        "parallel:\n  - reach: {target: target, hand: left}\n  - within: {percept: target, distance: 0.5 m}",
    ),
)

_WORLD = (
    _error("unknown-tree", "There is no tree of this name."),
    _error(
        "unknown-robot",
        "There is no robot of this name.",
        "format: 1\nrobot: humanod\nroot: {emergency_stop: idle}",
        "format: 1\nrobot: humanoid\nroot: {emergency_stop: idle}",
    ),
    _error(
        "unknown-scene",
        "There is no scene of this name.",
        "format: 1\nscene: ball\nroot: {emergency_stop: idle}",
        "format: 1\nscene: ball_on_stand\nroot: {emergency_stop: idle}",
    ),
    _warning(
        "unknown-percept",
        "The scene does not publish this percept: it is stale for ever.",
        "format: 1\nscene: ball_on_stand\nroot: {watchdog: {percept: bal, max_age: 1 s, wait: 2 s}}",
        "format: 1\nscene: ball_on_stand\nroot: {watchdog: {percept: target, max_age: 1 s, wait: 2 s}}",
    ),
    _error("unknown-object", "The scene has no object of this name."),
    _error("robot-cannot", "The tree commands what its robot does not have."),
    _error("unknown-body", "The robot's model has no body of this name."),
    _error("unknown-joint", "The robot's model has no joint of this name."),
    _error("undriven-joint", "No drive of robot.yaml moves this joint."),
    _error("model", "MuJoCo cannot make the model, or the engine cannot use it."),
)

_SKILLS = (
    _error("broken-skill", "A skill's file cannot be run, or its class is not complete."),
    _error("duplicate-skill", "Two skills of one folder have the same name."),
    _error("taken-name", "A name stands for something else already."),
    _error("unknown-resource", "A skill declares a resource that robots do not have."),
)

_ALLOWING = (
    _error(
        "allow-without-reason",
        "A comment allows a warning and does not say why.",
        "approach: {target: target}  # allow no-time-limit",
        "approach: {target: target}  # allow no-time-limit: the operator ends it",
    ),
    _error(
        "cannot-allow",
        "A comment allows an error. Only warnings can be allowed: safety is not negotiable.",
        "reach: {target: cup}  # allow outside-watchdog: it works",
        "watchdog: {percept: cup, max_age: 500 ms, reach: {target: cup}}",
    ),
    _warning(
        "unknown-code",
        "A comment allows a code that does not exist.",
        "approach: {target: target}  # allow no-time-limt: the operator ends it",
        "approach: {target: target}  # allow no-time-limit: the operator ends it",
    ),
    _warning(
        "unused-allow",
        "A comment allows a warning that does not occur there.",
        "idle: {}  # allow no-hysteresis: it is steady",
        "idle: {}",
    ),
)

CODES: dict[str, Code] = {
    code.name: code for code in (*_FILES, *_VALUES, *_TREES, *_SAFETY, *_WORLD, *_SKILLS, *_ALLOWING)
}
"""Every code by its name."""

ALLOWABLE = frozenset(code.name for code in CODES.values() if code.severity == "warning" and code not in _ALLOWING)
"""The codes that a comment can allow: warnings, but for those about such comments."""


def find(name: str) -> Code:
    """Return a code.

    Raises:
        UserError: there is none of this name.
    """
    if name not in CODES:
        raise UserError(f"no code {name!r}", hint=nearest(name, CODES))
    return CODES[name]
