"""Bounds on the errors of modes and of orbits."""
