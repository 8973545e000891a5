"""Engines that are wrong on purpose: what checks must catch, and how engines are known to fail."""
