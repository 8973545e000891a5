"""Scenes with rigid bodies in space: coefficients, rotation, floating bases, mistakes."""
