"""Reports on a run of checks: console, JSON, JUnit, Markdown, GitHub, and one page."""
