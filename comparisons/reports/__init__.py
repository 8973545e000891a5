"""Documents of results: console, JSON, JUnit, Markdown, GitHub, HTML."""
