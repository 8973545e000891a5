"""Rules: warnings before a run."""
