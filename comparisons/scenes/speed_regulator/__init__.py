"""Data of speed_regulator for maps, extremes and trade-offs."""
