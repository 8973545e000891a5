"""Cost of accuracy: methods, steps, and other options that limit errors."""
