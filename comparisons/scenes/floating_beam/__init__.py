"""Data of floating_beam for maps, extremes and trade-offs."""
