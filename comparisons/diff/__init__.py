"""Changes between two runs of ``mbcheck check``."""
