"""Trajectories in higher precision by a second route, and draws to hold the reference against."""
