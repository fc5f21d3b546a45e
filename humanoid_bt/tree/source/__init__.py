"""From the text of a tree file, or Python, to nodes."""
