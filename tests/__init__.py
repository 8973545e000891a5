"""The tests of mbcheck."""
