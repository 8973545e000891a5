"""Files that users name: pipes, devices, depth, size, and values of the wrong type."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.diff import report
from mbcheck.comparisons.diff.changes import compare
from mbcheck.comparisons.diff.document import read
from mbcheck.comparisons.documents import reading
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke, refusal
from mbcheck.tests.support.mjcf.mistakes import written

pytestmark = pytest.mark.usefixtures("own_folder")

LINES = (
    "check hula_hoop --known {}",
    "check --trajectory {} --case hula_hoop/rod_aligned",
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
        assert "'deep'" in (words := refusal(line.format("deep"))) or "deep is" in words


def test_a_cell_longer_than_any_number() -> None:
    for text in (f"t,{'a' * 140_000}\n0,1\n", f"t,y\n0,{'1' * 140_000}x\n"):
        Path("long.csv").write_text(text)
        line = "check --trajectory long.csv --case hula_hoop/rod_aligned"
        assert "field larger than field limit" in refusal(line)


def test_a_large_file_is_refused_before_it_is_read() -> None:
    with open("large.json", "wb") as file:
        file.truncate(reading.MAX_BYTES + 1)
    assert "more than 256 MiB" in refusal("inspect large.json")


# Values of other types -----------------------------------------------------------------------


def mutants(found: Any) -> Iterator[tuple[str, Any]]:
    """Yield a document with each of its values in turn replaced by those of other types."""

    def places(value: Any, path: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for key, item in items:
            yield (*path, key)
            if isinstance(item, dict | list):
                yield from places(item, (*path, key))

    for path in places(found, ()):
        for other in (None, 5, -1.5, True, "x", [], {}, [3], {"a": 3}, 10**400):
            changed = deepcopy(found)
            item = changed
            for key in path[:-1]:
                item = item[key]
            item[path[-1]] = other
            yield f"{path} = {other!r:.20}", changed


def test_a_diff_of_documents_with_wrong_types() -> None:
    """Each is compared, or refused in one line."""
    line = "check hula_hoop --engine mujoco --kind parts --id '*/mass_matrix' --json good.json"
    assert invoke(line.replace("'", "")).exit_code in (0, 2)
    invoke("check hula_hoop --kind parts --engine mujoco --id *rod_aligned* --json good.json")
    good = json.loads(Path("good.json").read_text())
    good["results"] = good["results"][:1]
    refused = 0
    for _, document in mutants(good):
        Path("other.json").write_text(json.dumps(document))
        for names in (("good.json", "other.json"), ("other.json", "good.json")):
            try:
                result = compare(read(names[0]), read(names[1]))
                report.markdown(result)
                json.dumps(result.as_json())
            except UsageError:
                refused += 1
    assert refused > 100


def test_a_document_of_another_verb_is_named(tmp_path: Path) -> None:
    written(tmp_path)
    invoke("inspect model.xml --no-modes --json other.json")
    assert "there is no 'results'" in refusal("diff other.json other.json")
