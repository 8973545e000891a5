"""Inspection of MJCF models: what is in a file, how it moves, and what it could do without."""
