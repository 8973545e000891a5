"""Compare two readings of one model: what each compiled, and what it does at states."""
