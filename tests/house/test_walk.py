"""A check goes down the layers: how often its way climbs back is held."""

import re
import subprocess
import sys

from mbcheck.tests.support.house.walk import HOUSE, collapsed

FORM = r"(\d+) rooms, (\d+) stays, (\d+) returns"


def test_the_way_of_a_check_is_as_short_as_the_page_says() -> None:
    command = [sys.executable, "-m", "mbcheck.tests.support.house.walk"]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    measured = [int(number) for number in re.findall(r"\d+", found.stdout)]
    page = (HOUSE / "docs" / "architecture.md").read_text(encoding="utf-8")
    (printed,) = re.findall(FORM, page)
    assert re.fullmatch(FORM, found.stdout.strip())
    too_long = [one > int(most) for one, most in zip(measured, printed, strict=True)]
    assert not any(too_long), f"docs/architecture.md says {printed}, measured {found.stdout}"


def test_repeats_count_once() -> None:
    assert collapsed(list("abcabcabd")) == list("abcabd")
    assert collapsed(list("aabbab")) == list("ab")
