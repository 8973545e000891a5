"""What the verbs of the command line share: exit codes, options, printing, progress."""
