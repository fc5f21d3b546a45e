"""From the text of a tree file, or from Python, to nodes."""
