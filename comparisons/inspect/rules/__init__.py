"""Rules of inspection, grouped by the part of a model that they examine."""
