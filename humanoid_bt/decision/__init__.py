"""The robot as skills see it: skills, the blackboard, targets out."""
