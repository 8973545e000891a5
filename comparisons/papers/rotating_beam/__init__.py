"""The paper on rotating_beam: its figures, and what it prints and claims."""
