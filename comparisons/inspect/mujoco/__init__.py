"""Access to models by MuJoCo."""
