"""Numbers as text are plain decimal ones."""

from __future__ import annotations

import math

import pytest

import mbcheck
from mbcheck.reference import get_scene
from mbcheck.reference.errors import ParameterError
from mbcheck.reference.parameters import as_number

WRONG = ("1_0", "\uff11", "\u0663", "0x10", "1,5", "", "1e", "ten", "1 0", "1\u00a0", "Infinity")


@pytest.mark.parametrize("text", WRONG)
def test_other_text_is_no_number(text: str) -> None:
    with pytest.raises(ValueError, match="no decimal number"):
        as_number(text)
    with pytest.raises(ParameterError, match="main_mass must be a number"):
        get_scene("hula_hoop").parameters().replace(main_mass=text)
    with pytest.raises(ParameterError, match="main_mass must be a number"):
        mbcheck.simulate("hula_hoop", parameters={"main_mass": text}, times=[0.1])


@pytest.mark.parametrize("text", ["1", " 1.0 ", "+1.", "100e-2", ".1E1"])
def test_plain_text_is_one(text: str) -> None:
    assert as_number(text) == 1.0


def test_what_is_too_large_is_infinite() -> None:
    assert math.isinf(as_number("1e999"))
