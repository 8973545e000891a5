"""Data of floating_platform for maps, extremes and trade-offs."""
