"""Data of rigid_body for maps, extremes and trade-offs."""
