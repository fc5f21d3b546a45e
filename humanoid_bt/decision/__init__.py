"""The robot as a skill sees it: a snapshot in, targets out; skills and the blackboard."""
