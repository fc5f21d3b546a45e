"""YAML to py_trees: nodes, building, checking, showing, ticking."""
