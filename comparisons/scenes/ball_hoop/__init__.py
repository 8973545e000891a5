"""What features know of ball_hoop alone."""
