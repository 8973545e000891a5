"""What features know of floating_platform alone."""
