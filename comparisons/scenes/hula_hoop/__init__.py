"""Data of hula_hoop for maps, extremes and trade-offs."""
