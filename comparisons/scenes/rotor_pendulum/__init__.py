"""Data of rotor_pendulum for maps, extremes and trade-offs."""
