"""What would help, for each kind of cause."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping

PAGE = "docs/what-stopped-my-robot.md"
CONTROL_LOG = "RECORDING.control.log"
"""Stands for the file in which control notes what happens."""
EXPLAIN_NODE, EXPLAIN_JOINT = "explain --node NAME", "explain --joint NAME"
"""Stand for the commands that explain the node behind a cause, and a joint that it names."""

HINTS: dict[str, tuple[str, ...]] = {
    "success": (),
    "estop": ("humanoid-bt reset lets it go on, once the reason is gone; --on-estop wait keeps the run for it",),
    "estop_node": ("look at the condition above that node: what it asked for is what stopped the robot",),
    "killed": (
        "look at what killed the program: dmesg (out of memory), a supervisor of services, a second Ctrl-C",
        "RECORDING.control.log beside the recording says what control did afterwards",
    ),
    "slow_tick": (
        "a skill must return at once: take what it waits for into a thread, and look at it in each update()",
        "docs/realtime.md says what a tick may take",
    ),
    "silent": ("decision had no processor, or the program paused between two steps: docs/realtime.md",),
    "refused": ("correct what the node commands; docs/safety.md says what is refused",),
    "not_finite": ("a division by zero or a percept that was not there: check numbers before you command them",),
    "percept_lost": (
        "docs/scenes.md says what perception sees; a longer max_age bridges gaps, on_stale says what to do meanwhile",
    ),
    "percept_doubtful": (
        "more hysteresis, a lower threshold, or look at the target from nearer: docs/tree-reference.md",
    ),
    "out_of_reach": ("walk nearer before reaching (approach), or to where the other hand gets there",),
    "torque_limit": ("a heavy load or a stretched arm: go nearer, or see 'drives' in robot.yaml (docs/robots.md)",),
    "push": ("nothing in the tree did it: look at what touched the robot; docs/safety.md says what it withstands",),
    "fall": ("look at the seconds before in the viewer; slower walking and nearer targets leave more balance",),
    "state": ("a sensor that sends nonsense, or a simulation that diverged: look at the joints with --at",),
    "sensor": ("look at that sensor and its cable", f"{EXPLAIN_JOINT} shows what it said"),
    "plant": (
        "look at the cable, and at what the plant says in its own terminal or log",
        "docs/your-robot.md says what each side does then",
    ),
    "way": (
        "look at what stands there, and let perception see it: walk_to and approach go round what is solid",
        "docs/safety.md says when the robot goes on by itself, and when it waits for humanoid-bt reset",
    ),
    "ik": ("a target that cannot be met together with the others: command fewer, or nearer ones",),
    "exception": ("catch it in the skill, or put on_error above the node; the traceback is in the report (--report)",),
    "conflict": ("only one node at a time may command a resource: docs/concepts.md",),
    "timeout": ("a longer duration, or find out why the node did not end", f"{EXPLAIN_NODE} shows what it did"),
    "failed": (f"{EXPLAIN_NODE} shows what the node did", "docs/tree-reference.md has recovery"),
    "control": (
        "RECORDING.control.log says what control noted last; dmesg says whether the system killed it",
        "docs/realtime.md says what keeps the machine from stalling it",
    ),
    "cut": (
        "look whether the recorder was killed (dmesg), or its disk is full; the run's report knows the rest",
        "RECORDING.control.log says what control noted",
    ),
    "damaged": (
        "copy it again, if it is a copy; the run's report knows the rest",
        "RECORDING.control.log says what control noted",
    ),
    "stop": ("look at who asked for the stop",),
    "error": ("the traceback is in the report (--report)",),
    "interrupted": (),
    "unfinished": ("a longer --duration lets it go on", f"{EXPLAIN_NODE} shows what held it up"),
}
"""Kind of a cause -> what would help, the most likely first."""


def hints(kind: str, known: Mapping[str, str]) -> Iterator[str]:
    """Yield what would help, without what speaks of something that is not known.

    Args:
        kind: of the cause.
        known: what stands for something, and what it stands for; "" if that is not known.
    """
    for hint in HINTS.get(kind, ()):
        named = [name for name in known if name in hint]
        if all(known[name] for name in named):
            yield functools.reduce(lambda text, name: text.replace(name, known[name]), named, hint)
