"""Engines of others that do what they must not."""
