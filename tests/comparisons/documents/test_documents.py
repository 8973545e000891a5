"""Documents: one type each, from which they are written, described and checked."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Any

import jsonschema
import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.documents import DOCUMENTS, document, schema
from mbcheck.comparisons.queries.frequencies import frequencies
from mbcheck.comparisons.queries.orbit import orbit
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.comparisons.reports.run.outcome import Report
from mbcheck.reference.errors import MbcheckError, UsageError
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.results import MIXED, VERSIONS

# Schemas -----------------------------------------------------------------------------------


@cache
def example(name: str, engine: str = "reference") -> dict[str, Any]:
    """Return a document that a verb writes."""
    if name == "check":
        return Report(tuple(MIXED), VERSIONS).as_json()
    if name == "simulate":
        return simulate("hula_hoop", engine=engine, times=[0.0, 0.125]).as_json()
    if name == "orbit":
        return orbit("hula_hoop", engine=engine).as_json()
    return frequencies("hula_hoop", engine=engine).as_json()


EXAMPLES = ("simulate", "orbit", "frequencies", "check")


@pytest.mark.parametrize("engine", ["reference", "mujoco", "exudyn"])
@pytest.mark.parametrize("name", EXAMPLES[:3])
def test_schemas_accept_what_the_verbs_return(name: str, engine: str) -> None:
    validated(name, example(name, engine))


@pytest.mark.parametrize("name", DOCUMENTS)
def test_schemas_are_closed_and_described(name: str) -> None:
    described = schema(name)
    jsonschema.Draft202012Validator.check_schema(described)
    assert described["description"]
    for part in described["$defs"].values():
        assert part["additionalProperties"] is False
        assert all(field["description"] for field in part["properties"].values())


@pytest.mark.parametrize("name", EXAMPLES)
def test_schemas_want_every_field_and_no_other(name: str) -> None:
    described = schema(name)
    first = described["$defs"][described["$ref"].rpartition("/")[2]]
    for field in first["required"]:
        with pytest.raises(jsonschema.ValidationError):
            validated(name, {k: v for k, v in example(name).items() if k != field})
    with pytest.raises(jsonschema.ValidationError):
        validated(name, example(name) | {"extra": 1})


Change = Callable[[Any], Any]
BAD: list[tuple[str, Change]] = [
    ("check", lambda d: d["results"][0].update(verdict="passed")),
    ("check", lambda d: d["results"][0].update(error="NaN")),
    ("check", lambda d: d["results"][0].pop("unit")),
    ("check", lambda d: d.update(schema=3)),
    ("simulate", lambda d: d["observables"].update(y=["lost", 0.0])),
    ("orbit", lambda d: d["floquet_multipliers"][0].pop("modulus")),
    ("orbit", lambda d: d.update(period=None)),
]


@pytest.mark.parametrize(("name", "change"), BAD)
def test_schemas_reject(name: str, change: Change) -> None:
    document = deepcopy(example(name))
    change(document)
    with pytest.raises(jsonschema.ValidationError):
        validated(name, document)


# Writing -------------------------------------------------------------------------------------

MODE: dict[str, Any] = {"re": 0.0, "im": 1.0, "omega": 1.0, "hertz": 0.16}
MODE |= {"damping_ratio": math.nan, "error_bound": 1e-15, "damping_ratio_bound": None}
NAMES = {"scene": "hula_hoop", "engine": "mujoco", "model": "tree", "about": "rest", "plane": None}


def modes(state: Any) -> Any:
    """Return a result as `frequencies` has it, with one field too many."""
    return SimpleNamespace(
        state=state,
        modes=(MODE | {"vector": (1.0,)},),
        parameters=MappingProxyType({"mass": np.float64(2.0), "placement": "absolute"}),
        versions=MappingProxyType({}),
        undamped=np.bool_(True),
        unforced=MappingProxyType({"force": 0.0}),
        steady=(),
        more=print,
    )


def test_a_document_has_the_fields_of_its_type_and_plain_values() -> None:
    written = document("frequencies", modes({"y": np.float32(0.5)}), **NAMES, also="nowhere")
    validated("frequencies", written)
    assert written["state"] == {"y": 0.5}
    assert written["modes"] == [MODE | {"damping_ratio": None}]
    assert written["undamped"] is True
    assert written["parameters"] == {"mass": 2.0, "placement": "absolute"}
    assert not {"more", "also"} & set(written)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"state": {"y": math.inf}}, r"Expected `float`, got `null` - at `\$.state\[...\]`"),
        ({"engine": 3}, r"Expected `str`, got `int` - at `\$.engine`"),
        ({"modes": [{"re": 0.0}]}, "missing required field"),
    ],
)
def test_what_is_not_what_a_document_promises_is_our_fault(
    parts: dict[str, Any], message: str
) -> None:
    with pytest.raises(MbcheckError, match=rf"a fault of mbcheck.*Frequencies.*{message}"):
        document("frequencies", modes({"y": 0.5}), **NAMES | parts)


def test_text_that_no_encoding_has_is_escaped() -> None:
    written = document("frequencies", modes({"y": 0.5}), **NAMES | {"model": "\ud800 ü"})
    assert json.loads(json.dumps(written, ensure_ascii=False).encode())["model"] == "\\ud800 ü"


def test_digits_survive() -> None:
    numbers = [0.1 + 0.2, 1e-300, 1.7976931348623157e308, 2.0**-1074]
    written = document("frequencies", modes(dict(zip("abcd", numbers, strict=True))), **NAMES)
    assert list(json.loads(json.dumps(written))["state"].values()) == numbers


TRADEOFF: Callable[..., Any] = mbcheck.tradeoff
"""As someone calls it who reads no types."""


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: mbcheck.check(scenes="hula_hoop"), "scenes"),
        (lambda: mbcheck.check(engines="hula_hoop"), "engines"),
        (lambda: mbcheck.reproduce("hula_hoop"), "scenes"),
        (lambda: TRADEOFF(Path("hula_hoop")), "scenes"),
        (lambda: mbcheck.inspect("model.xml", select="hula_hoop"), "select"),
    ],
)
def test_one_value_in_place_of_a_list_is_refused(call: Callable[[], Any], field: str) -> None:
    words = rf"{field} must be a list, not 'hula_hoop'; did you mean \['hula_hoop'\]\?"
    with pytest.raises(UsageError, match=words):
        call()


def test_files_may_be_paths(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text('<mujoco><worldbody><light name="sun"/></worldbody></mujoco>')
    assert mbcheck.compare(file, file).exit_code == 0
    with pytest.raises(MbcheckError, match="nothing moves in it"):
        TRADEOFF([file])
