"""What features know of rotor_pendulum alone."""
