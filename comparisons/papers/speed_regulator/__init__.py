"""The paper on speed_regulator: its figures, and what it prints and claims."""
