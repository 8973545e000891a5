"""Second formulations of the scenes: Newton and Euler with constraint forces, in 50 digits."""
