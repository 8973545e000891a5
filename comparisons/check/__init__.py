"""The verb `check`: a request, the checks that it plans, and the report of their results."""
