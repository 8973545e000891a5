"""Motions that are followed for long."""
