"""Documents: one type each, from which they are written, described and checked."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from copy import deepcopy
from types import MappingProxyType, SimpleNamespace
from typing import Any

import jsonschema
import numpy as np
import pytest

from mbcheck.comparisons.documents import DOCUMENTS, document, schema
from mbcheck.comparisons.queries.frequencies import frequencies
from mbcheck.comparisons.queries.orbit import orbit
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.comparisons.reports.run.outcome import Report
from mbcheck.reference.errors import MbcheckError
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.results import MIXED, VERSIONS

# Schemas -----------------------------------------------------------------------------------

RUN = {
    "schema": 2,
    "scene": "hula_hoop",
    "engine": "mujoco",
    "model": "tree",
    "parameters": {"main_mass": 0.45},
    "versions": VERSIONS,
}
SIMULATE = RUN | {
    "method": "RK4",
    "step": 1e-3,
    "times": [0.0, 0.5],
    "observables": {"y": [0.0, 1e-300]},
    "units": {"y": "m"},
    "error_bound": None,
    "work": {"steps": 500, "rhs_evaluations": None, "seconds": 0.01},
    "lost_from": None,
    "cautions": [{"rule": "step_limit", "message": "a step of 0.1 s is unstable"}],
}
ORBIT = RUN | {
    "method": "RK4",
    "step": None,
    "period": 1 / 3,
    "state": {"theta": 5.3},
    "mean_speed": 18.8,
    "stable": True,
    "floquet_multipliers": [
        {"re": 0.5, "im": -0.1, "modulus": 0.51, "trivial": False} | {"error_bound": 1e-15}
    ],
    "harmonics": {
        "theta": {"mean": 0.1, "terms": [{"order": 1, "amplitude": 0.2, "phase": -3.0}]}
        | {"error_bound": None}
    },
    "power": {"force": 10.0, "damper": -10.0},
    "quantities": {"torque": {"value": 3.0, "unit": "N m", "error_bound": 1e-12}},
    "error_bound": {"theta": 1e-12},
    "period_bound": None,
    "mean_speed_bound": None,
    "power_bound": {"force": 1e-12, "damper": 1e-12},
}
FREQUENCIES = RUN | {
    "undamped": False,
    "about": "rod_across",
    "plane": None,
    "state": {"theta": 0.0},
    "modes": [
        {"re": 0.0, "im": 0.0, "omega": 0.0, "hertz": 0.0, "damping_ratio": None}
        | {"error_bound": 0.0, "damping_ratio_bound": None}
    ],
}
CHECK = Report(tuple(MIXED), VERSIONS).as_json()
EXAMPLES = {"simulate": SIMULATE, "orbit": ORBIT, "frequencies": FREQUENCIES, "check": CHECK}


@pytest.mark.parametrize("name", EXAMPLES)
def test_schemas_accept_documents(name: str) -> None:
    validated(name, EXAMPLES[name])


@pytest.mark.parametrize("engine", ["reference", "mujoco", "exudyn"])
def test_schemas_accept_what_the_verbs_return(engine: str) -> None:
    pytest.importorskip("numpy" if engine == "reference" else engine, exc_type=ImportError)
    validated("simulate", simulate("hula_hoop", engine=engine, times=[0.0, 0.125]).as_json())
    validated("orbit", orbit("hula_hoop", engine=engine).as_json())
    validated("frequencies", frequencies("hula_hoop", engine=engine).as_json())


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
            validated(name, {k: v for k, v in EXAMPLES[name].items() if k != field})
    with pytest.raises(jsonschema.ValidationError):
        validated(name, EXAMPLES[name] | {"extra": 1})


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
    document = deepcopy(EXAMPLES[name])
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
