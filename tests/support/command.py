"""The command line, called as a user calls it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from mbcheck.comparisons.cli import group

MAIN = (sys.executable, "-c", "from mbcheck.comparisons.cli import main; main()")
"""What starts the command line in a process of its own."""

SMALL = "boundary hula_hoop --x force_frequency=5.6:6 --y force_amplitude=15:24 --lines 2"
"""A corner of figure 4, which one curve crosses."""


def invoke(line: str, *words: object, stdin: str | bytes | None = None) -> Result:
    """Run a command line in this process; anything but an exit code is a failure.

    Words that follow the line may hold spaces.
    """
    result = CliRunner().invoke(group.program, [*line.split(), *map(str, words)], stdin)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def succeeds(line: str, *words: object) -> str:
    """Return the standard output of a command line that exits with 0."""
    result = invoke(line, *words)
    assert result.exit_code == 0, result.output
    return result.stdout


def on_a_terminal(line: str, columns: int = 80) -> str:
    """Return what a command line prints on a terminal, its colours left out."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"FORCE_COLOR": "1", "NO_COLOR": "1", "COLUMNS": str(columns)}.items():
            patch.setenv(name, value)
        return re.sub(r"\x1b\[[0-9;]*m", "", succeeds(line))


def process(line: str, *words: object, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command line in a process of its own, with more environment variables."""
    return subprocess.run(
        [*MAIN, *line.split(), *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | environment,
    )


def refusal(line: str) -> str:
    """Return the one line that a command is refused with; nothing else may happen."""
    before = files_here()
    result = invoke(line)
    assert result.exit_code == 2, result.output
    assert not result.stdout
    (message,) = result.stderr.splitlines()
    assert files_here() == before
    return message


OF_TESTS = {".hypothesis", ".pytest_cache"}
"""What other tests write meanwhile."""


def files_here() -> dict[Path, tuple[int, int]]:
    """Return size and time of the last change of each file in the working directory."""
    here = [path for path in Path().iterdir() if path.name not in OF_TESTS]
    return {path: (path.stat().st_size, path.stat().st_mtime_ns) for path in here}
