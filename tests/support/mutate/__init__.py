"""Mutants of the package's own modules: whether a test fails when a line is wrong."""
