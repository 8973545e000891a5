"""The paper on rotor_pendulum: its figures, and what it prints and claims."""
