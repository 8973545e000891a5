"""rotating_beam as engines model it."""
