"""What features know of rotating_beam alone."""
