"""The command line: the verbs, and the pytest plugin."""

from __future__ import annotations

from typing import NoReturn

from ..engines import use_one_thread


def main() -> NoReturn:
    """Run the command line of this process, and exit."""
    use_one_thread()
    from .group import program

    program.main()
