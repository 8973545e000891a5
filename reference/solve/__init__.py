"""Initial value problems: single, batched, stiff, by Taylor series."""
