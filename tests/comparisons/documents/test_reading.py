"""Files that users name: pipes, devices, depth, size, and values of the wrong type."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from mbcheck.comparisons.documents import reading
from mbcheck.tests.support.command import invoke, refusal
from mbcheck.tests.support.mjcf.mistakes import written

pytestmark = pytest.mark.usefixtures("own_folder")

LINES = (
    "check hula_hoop --known {}",
    "judge {} --case hula_hoop/rod_aligned",
    "inspect model.xml --waivers {}",
    "inspect model.xml --baseline {}",
    "inspect {}",
    "diff {0} {0}",
    "compare-maps {0} {0}",
    "boundary hula_hoop --x force_frequency=5.6:6 --y force_amplitude=15:24 -o {}",
    "tradeoff model.xml --resume {}",
)
"""Command lines that read a file."""


@pytest.mark.parametrize("line", [line for line in LINES if " -o " not in line])
@pytest.mark.parametrize("name", ["pipe", "/dev/zero"])
def test_pipes_and_devices_are_refused(line: str, name: str, tmp_path: Path) -> None:
    """They may never end."""
    written(tmp_path)
    os.mkfifo("pipe")
    assert "no regular file" in refusal(line.format(name))


DEEP = "[" * 20_000


@pytest.mark.parametrize("line", LINES[:-1])
def test_what_is_nested_deeply_is_refused(line: str, tmp_path: Path) -> None:
    written(tmp_path)
    for text in (DEEP, f"x = {DEEP}", f'{{"a": {DEEP}'):
        Path("deep").write_text(text)
        assert "deep" in refusal(line.format("deep"))


def test_a_cell_longer_than_any_number() -> None:
    for text in (f"t,{'a' * 140_000}\n0,1\n", f"t,y\n0,{'1' * 140_000}x\n"):
        Path("long.csv").write_text(text)
        line = "judge long.csv --case hula_hoop/rod_aligned"
        assert "field larger than field limit" in refusal(line)


def test_a_large_file_is_refused_before_it_is_read() -> None:
    with open("large.json", "wb") as file:
        file.truncate(reading.MAX_BYTES + 1)
    assert "more than 256 MiB" in refusal("inspect large.json")


def test_a_document_of_another_verb_is_named(tmp_path: Path) -> None:
    written(tmp_path)
    invoke("inspect model.xml --no-modes --json other.json")
    assert "missing required field" in refusal("diff other.json other.json")
