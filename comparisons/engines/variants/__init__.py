"""Engines that are modified on purpose."""
