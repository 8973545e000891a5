"""Reports of results: console, JSON, JUnit, SARIF, Markdown, GitHub, HTML."""
