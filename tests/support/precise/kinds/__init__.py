"""Kinds of runs: easy ones, and hard ones."""
