"""What features know of floating_beam alone."""
