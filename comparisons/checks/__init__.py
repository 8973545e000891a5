"""The list of checks, their truth, tolerances and verdicts."""
