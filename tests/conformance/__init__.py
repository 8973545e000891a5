"""The comparisons as tests: what a user of the suite runs."""
