"""Curves of periodic orbits and of their bifurcations, over two parameters."""
