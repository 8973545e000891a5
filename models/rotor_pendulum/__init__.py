"""rotor_pendulum as MJCF and as Exudyn models."""
