"""Exudyn as an adapter."""
