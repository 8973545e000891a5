"""Initial value problems: single, batched, stiff, by Taylor series."""

HEYOKA = "heyoka"
BACKENDS = ("auto", "numpy", HEYOKA)
"""What many steps at once are computed by."""
