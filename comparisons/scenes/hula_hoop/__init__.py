"""What features know of hula_hoop alone."""
