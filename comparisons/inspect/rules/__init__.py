"""What inspection finds, by the part of a model in which it looks."""
