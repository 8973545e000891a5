"""Data of ball_hoop for maps, extremes and trade-offs."""
