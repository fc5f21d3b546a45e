"""A tree file of any size."""

from __future__ import annotations

_HEAD = """\
format: 1
name: sample
description: Reach for the target by the first of many ways that fits.
robot: humanoid
parameters:
  target: target          # the percept to go for
  min_confidence: 0.6
  max_age: 0.5 s
  patience: 20 s
root:
  emergency_stop:
    watchdog:
      percept: $target
      max_age: $max_age
      on_stale: {idle: {look_around: true}}
      reactive_selector:
        - reactive_selector:
            name: ways
            children:
"""

_WAY = """\
              - reactive_sequence:
                  name: way {number}
                  children:
                    - confident: {{percept: $target, above: $min_confidence, hysteresis: 0.1}}
                    - within: {{percept: $target, distance: {distance:.2f} m, bearing: 0.4 rad}}
                    - timeout: {{duration: $patience, reach: {{target: $target, hand: nearest}}}}
"""

_STEP = 0.22  # m; by so much each way reaches farther than the one before it


def sample_tree(nodes: int) -> str:
    """Return the text of a tree file.

    Its ways are tried in turn, each with two conditions, a timeout and a skill; the seventh reaches 1.5 m.

    Args:
        nodes: how many nodes it has, a multiple of 5 and at least 10.

    Raises:
        ValueError: there is no such tree.
    """
    ways, rest = divmod(nodes - 5, 5)
    if rest or ways < 1:
        raise ValueError(f"a sample tree has 10, 15, 20, ... nodes, not {nodes}")
    return _HEAD + "".join(_WAY.format(number=way, distance=_STEP * way) for way in range(1, ways + 1))
