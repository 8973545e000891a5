"""Inspection of MJCF models: content, motion, mistakes and redundant parts."""
