"""Engines, checks, verdicts, reports, command line."""
