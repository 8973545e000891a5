"""Independent routes with more digits than doubles have."""
