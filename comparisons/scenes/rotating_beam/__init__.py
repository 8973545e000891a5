"""Data of rotating_beam for maps, extremes and trade-offs."""
