"""What changed between two runs of ``mbcheck check``."""
