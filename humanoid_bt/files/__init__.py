"""YAML files with the place of every value, one form for them, and workspaces."""
