"""mbcheck."""
