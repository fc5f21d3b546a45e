"""Files: YAML with the place of every value, one form for it, workspaces."""
