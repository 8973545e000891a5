"""speed_regulator as MJCF and as Exudyn models."""
