"""What accuracy costs: methods, steps, and all else that limits it."""
