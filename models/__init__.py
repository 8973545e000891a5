"""The scenes as engine models: MJCF and Exudyn."""
