"""What an engine's process sends is plain data: it changes nothing here, and junk is an error."""

from __future__ import annotations

import json
import math
import os
import pickle
import re
import struct
from base64 import b64encode
from multiprocessing import Pipe
from pathlib import Path
from textwrap import dedent
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.messages import MAX_BYTES, MAX_TEXT, decoded, encoded, received
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.validation import numbers
from mbcheck.reference.errors import (
    BrokenEngineError,
    CannotJudgeError,
    EngineError,
    MbcheckError,
    NoOrbitError,
    UnknownNameError,
    UsageError,
)
from mbcheck.tests.support.engines.plugins import EPSILON


def plain(value: Any) -> Any:
    """Return what a result of an engine's process becomes here."""
    ended, result = decoded(encoded((True, value), plain=True), plain=True)
    assert ended
    return result


def test_no_message_changes_the_judge() -> None:
    """Pickle's BUILD set attributes of classes, so that an accelerations 1 % off passed."""
    before = vars(Setup)["epsilon"]
    for attack in (EPSILON, pickle.dumps((True, os.getcwd)), pickle.dumps((True, 1.0))):
        _, error = decoded(attack, plain=True)
        assert isinstance(error, EngineError)
        assert "no answer" in error.message
    assert vars(Setup)["epsilon"] is before


def array(shape: Any, data: Any) -> str:
    return json.dumps([True, {"type": "array", "shape": shape, "data": data}])


ROW = b64encode(np.zeros(4).tobytes()).decode()
REFUSED: dict[str, str | bytes] = {
    "nothing": "",
    "half a message": '[true, {"type": "arr',
    "a number": "5",
    "a table": '{"a": 1, "b": 2, "c": 3}',
    "another encoding": b"[true, \xff]",
    "three parts": "[true, 1, 2]",
    "an unknown class": '[true, {"type": "Setup", "epsilon": 1e6}]',
    "a class that is no name": '[true, {"type": [1]}]',
    "a field that no motion has": '[true, {"type": "Motion", "positions": 1, "epsilon": 1}]',
    "a motion without velocities": '[true, {"type": "Motion", "positions": 1}]',
    "an error without words": '[true, {"type": "EngineError"}]',
    "a huge shape": array([1 << 40, 8], ROW),
    "a shape that no machine counts": array([1 << 70], ROW),
    "a shape of words": array(["2", "2"], ROW),
    "another shape": array([3], ROW),
    "no shape": array({"a": 1}, ROW),
    "other letters": array([4], "*" * 44),
    "half a number": array([1], "AAAA"),
    "numbers as data": array([1], [1.0]),
    "deeper than any answer": "[true, " + "[" * 200_000 + "]" * 200_000 + "]",
    "more than any answer": "[true, [" + "[]," * (1 << 22) + "1]]",
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_message_is_an_error_of_the_engine(name: str) -> None:
    sent = REFUSED[name]
    ended, error = decoded(sent if isinstance(sent, bytes) else sent.encode(), plain=True)
    assert ended
    assert isinstance(error, EngineError)
    assert error.message.startswith("what its process sent is no answer: ")
    assert len(error.message) < 400
    assert error.message.isprintable()


def test_a_length_is_checked_before_there_is_memory_for_it() -> None:
    ours, theirs = Pipe()
    theirs.send_bytes(b"[false, null]")
    assert received(ours, plain=True) == (False, None)
    os.write(theirs.fileno(), struct.pack("!i", MAX_BYTES + 1))
    with pytest.raises(EOFError):
        received(ours, plain=True)


VALUES = [
    None, True, 3, -0.0, 1e300, math.inf, "words", {}, {"a": 1.5},
    mbcheck.Method("a", 2, "ExplicitMidpoint"),
    mbcheck.Option("a", "1", 1.0, (0.5, 1.0), "closure"),
    mbcheck.ModelDescription(constrained=True, reactions=("a",)),
]  # fmt: skip


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_an_answer_arrives_as_it_was(value: Any) -> None:
    assert plain(value) == value


def test_arrays_arrive_as_numbers_to_the_last_bit() -> None:
    rng = np.random.default_rng(1)
    values = rng.standard_normal((5, 3)) * 10.0 ** rng.integers(-300, 300, (5, 3))
    values[0] = math.nan, math.inf, -0.0
    single = (values[1:] / 1e300).astype(np.float32)
    for one in (values, values.T, values[::2], single, np.arange(3), np.zeros((0, 3)), [values]):
        assert np.asarray(plain(one)).tobytes() == np.asarray(one, dtype=float).tobytes()
    motion = mbcheck.Motion(values, values, steps=np.int64(5), seconds=np.float32(0.5))  # type: ignore[arg-type]
    here = plain(motion)
    assert np.array_equal(here.positions, values, equal_nan=True)
    assert (here.steps, float(here.seconds), here.clock) == (5, 0.5, None)
    assert type(plain(np.bool_(True))) is bool


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (mbcheck.Unsupported("no"), mbcheck.Unsupported),
        (CannotJudgeError("no"), CannotJudgeError),
        (BrokenEngineError("no", "line 1\nline 2"), BrokenEngineError),
        (UnknownNameError("class", "a", ["b"]), UsageError),
        (NoOrbitError("no"), MbcheckError),
        (type("Own", (mbcheck.Unsupported,), {})("no"), mbcheck.Unsupported),
        (EngineError("clock", "no", "line 1\nline 2"), EngineError),
    ],
)
def test_errors_arrive_as_one_of_a_few_classes(
    error: MbcheckError, kind: type[MbcheckError]
) -> None:
    found = plain(error)
    assert type(found) is kind
    assert f"{error}" in f"{found}"
    assert found.traceback == error.traceback
    assert getattr(found, "kind", "") == getattr(error, "kind", "")
    assert plain(ValueError("no")).kind == "raised"


@pytest.mark.parametrize(
    "value",
    [lambda: 0, (i for i in "a"), 1j, np.array([1j]), {1, 2}, b"a", {(1, 2): 3}, np.array(["1.5"]),
     np.ma.masked_equal([1.0, 2.0], 2.0)],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_what_is_no_plain_data_is_not_sent(value: Any) -> None:
    error = plain(value)
    assert isinstance(error, EngineError)
    assert error.message.startswith("its answer cannot be sent: ")


@pytest.mark.parametrize("value", [["1.5"], np.array(["1.5"]), np.array(["1.5"], object), [None],
                                   [10**400], [True, "1"]], ids=repr)  # fmt: skip
def test_arrays_of_text_are_no_numbers(value: Any) -> None:
    with pytest.raises(EngineError, match="accelerations must be real numbers, not "):
        numbers("accelerations", value, np.shape(value))


def test_text_is_cut_at_the_door() -> None:
    long = "\x1b[2J\u202e" + "x" * 10**6
    ((key, in_a_table),) = plain({long: long}).items()
    (in_a_list,) = plain([long])
    refusal, failure = plain(mbcheck.Unsupported(long)), plain(EngineError(long, "b", long))
    for text in (plain(long), key, in_a_table, in_a_list, f"{refusal}", failure.kind):
        assert text.startswith("\\x1b[2J\\u202exx")
        assert len(text) <= MAX_TEXT
    assert len(failure.traceback) <= 8000


def test_the_message_of_the_page_is_read() -> None:
    """Written by the few lines of docs/engines.md, as a process without mbcheck does."""
    page = (Path(__file__).resolve().parents[3] / "docs" / "engines.md").read_text()
    (lines,) = re.findall(r"^    import base64\n(?:    .*\n|\n)+", page, re.MULTILINE)
    space: dict[str, Any] = {}
    exec(dedent(lines), space)
    ours, theirs = Pipe()
    os.write(theirs.fileno(), space["message"])
    ended, motion = received(ours, plain=True)
    assert ended
    assert motion.positions.tolist() == [[0.0], [0.1]]
