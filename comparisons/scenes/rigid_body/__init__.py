"""What features know of rigid_body alone."""
