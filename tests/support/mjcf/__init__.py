"""MJCF models that tests are about."""
