"""Trajectories that were computed elsewhere, judged against the reference of their case."""
