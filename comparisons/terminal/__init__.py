"""Common parts of the verbs: exit codes, options, printing, progress."""
