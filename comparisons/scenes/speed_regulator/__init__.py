"""What features know of speed_regulator alone."""
