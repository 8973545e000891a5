"""The verb `extremes`: where engines break, and who notices, from results of checks."""
