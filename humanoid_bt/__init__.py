"""Behavior-tree task orchestration for humanoid robots.

The way in: :mod:`humanoid_bt.session` runs a tree file on a simulated robot,
:mod:`humanoid_bt.decision.skill` is the base of every skill, :mod:`humanoid_bt.testing`
tests one alone. Importing this package imports none of the heavy libraries.
"""

__version__ = "0.1.0"
