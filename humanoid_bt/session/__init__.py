"""Running a tree on a robot: the loops wired together, and the report of what happened."""
