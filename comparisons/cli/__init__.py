"""The command line: the verbs, and the pytest plugin."""

from __future__ import annotations

from typing import NoReturn


def main() -> NoReturn:
    """Run the command line of this process, and exit."""
    from .group import program

    program.main()
