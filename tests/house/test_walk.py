"""A check goes down the layers: how often its way climbs back is held."""

import re
import subprocess
import sys
from pathlib import Path

from mbcheck.tests.support.house.walk import collapsed

FORM = r"(\d+) rooms, (\d+) stays, (\d+) returns"


def test_the_way_of_a_check_is_as_short_as_the_page_says() -> None:
    command = [sys.executable, "-m", "mbcheck.tests.support.house.walk"]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    measured = [int(number) for number in re.findall(r"\d+", found.stdout)]
    page = Path(__file__).parents[2] / "docs" / "architecture.md"  # pages are not installed
    (printed,) = re.findall(FORM, page.read_text(encoding="utf-8"))
    assert re.fullmatch(FORM, found.stdout.strip())
    within = all(one <= int(most) for one, most in zip(measured, printed, strict=True))
    assert within, f"docs/architecture.md says {printed}, measured {found.stdout}"


def test_repeats_count_once() -> None:
    assert collapsed(list("abcabcabd")) == list("abcabd")
    assert collapsed(list("aabbab")) == list("ab")
