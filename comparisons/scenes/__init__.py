"""Data of each scene for maps, extremes and trade-offs, in a folder for each."""
