"""A paper as data: its figures, rows and causes, read from ``claims.toml`` in its folder.

docs/architecture.md says where to change what; a row and its keys::

    [rows.case_1_speed]
    section = "5.2, case 1"
    claim = "Synchronous speed."
    verdict = "reproduced"
    printed = "153.8 rad/s"
    each = {call = "speed_of", case = "case_1"}
    reproduced_if = ["value rounds to printed", "drift < 1e-6, everyone, ours"]

A measure is a function of the folder's ``measures.py``, with arguments after ``call``, if any; or
a table of formulas. A row, and each table in it, takes the keys that it does not have from the row
that ``like`` names. A row is slow if engines are measured too, and a reading if it has numbers.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cache, partial
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec

from ...reference import SCENES
from ...reference.errors import MbcheckError, UnknownNameError
from .equations import Formulas, Identities, join_lines, sides
from .ledger import (
    CORRECTED,
    DEPENDS,
    NOT_TESTABLE,
    READ,
    REPRODUCED,
    UNCONVERGED,
    Cause,
    Condition,
    Erratum,
    LedgerRow,
    PaperFigure,
)

FILE = "claims.toml"

CONDITIONS = {
    "reproduced_if": REPRODUCED,
    "unconverged_if": UNCONVERGED,
    "corrected_if": CORRECTED,
    "depends_if": DEPENDS,
}
"""Key of a row -> the verdict that it has if all these conditions hold, in order of preference."""

IMPLIED_KINDS = {"candidates": "reading", "erratum": "misprint", "printed": "number"}
"""Key of a row -> the kind that it has if it does not name one; any other is a claim."""

DEFAULTS: Mapping[str, Mapping[str, Any]] = {
    "number": {"reference": "{value:.5g} {unit}", "verdict": REPRODUCED},
    "claim": {"verdict": REPRODUCED},
    "misprint": {"verdict": CORRECTED},
    "reading": {"verdict": READ},
}
"""Kind of row -> values of the keys that it omits."""

DEFAULT_CONDITIONS: Mapping[str, Mapping[str, Any]] = {
    "number": {"reproduced_if": ["value rounds to printed"]},
    "misprint": {"corrected_if": ["corrected < 1e-12", "as_printed > 1e-3"]},
}
"""Kind of row -> its conditions if it gives none."""

CONDITION = re.compile(r"(\S+) (<=|>=|<|>|==|rounds to) (.+?)(, everyone)?(, ours)?")


@dataclass(frozen=True)
class PaperData:
    """The content of a paper's file.

    Attributes
    ----------
    figures : tuple of PaperFigure
    rows : tuple of LedgerRow
    causes : tuple of Cause
    verdict : str
        Whether model and method are right, what comes out and holds, and what to cite instead;
        numbers are taken from rows: ``{case_1_speed.value:.4g}``.
    names : str
        Meaning of the names of numbers that many of its conditions have.
    """

    figures: tuple[PaperFigure, ...] = ()
    rows: tuple[LedgerRow, ...] = ()
    causes: tuple[Cause, ...] = ()
    verdict: str = ""
    names: str = ""

    @property
    def items(self) -> list[PaperFigure | LedgerRow]:
        """The figures, and then the rows."""
        return [*self.figures, *self.rows]


REFUSALS = (LookupError, ValueError, TypeError, AttributeError, ImportError, SyntaxError)
"""Errors that a mistake in a paper's file causes."""


@cache
def read_paper(scene: str) -> PaperData:
    """Return the record of a scene's paper, empty if the scene has no such file.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    MbcheckError
        If the file is invalid: it names row and field.
    """
    if scene not in SCENES:
        raise UnknownNameError("scene", scene, SCENES)
    file = Path(__file__).parent / scene / FILE
    if not file.exists():
        return PaperData()
    text = file.read_text("utf-8")
    try:
        data = tomllib.loads(text)
        shared = data.pop("definitions", {})
        figures = [
            {"number": int(number), **one, "caption": one["caption"].format(**shared)}
            for number, one in data["figures"].items()
        ]
        causes = [{"name": name, **one} for name, one in data["causes"].items()]
        for name, row in data["rows"].items():
            model = data["rows"][row.pop("like")] if "like" in row else {}
            data["rows"][name] = model | {
                key: model.get(key, {}) | one if isinstance(one, dict) else one
                for key, one in row.items()
            }
        rows = [read_row(scene, name, row, shared) for name, row in data["rows"].items()]
        others = {**data, "figures": figures, "causes": causes, "rows": ()}
        return replace(converted(scene, others, PaperData), rows=tuple(rows))
    except REFUSALS as error:
        raise MbcheckError(f"{file}: {error}") from error


def scenes_with_ledger() -> tuple[str, ...]:
    """Return the scenes of papers that are reproduced; others are textbook mechanics."""
    return tuple(scene for scene in SCENES if read_paper(scene).rows)


def read_row(
    scene: str, name: str, data: Mapping[str, Any], shared: Mapping[str, str]
) -> LedgerRow:
    """Return a row of a paper from its table in the file."""
    try:
        implied = (kind for key, kind in IMPLIED_KINDS.items() if key in data)
        kind = data.get("kind", next(implied, "claim"))
        is_slow = "each" in data or {"numbers", "candidates"} <= data.keys()
        own = {"kind": kind, "name": name, "slow": is_slow}
        row = {**own, **DEFAULTS.get(kind, {}), **data}
        if not CONDITIONS.keys() & data.keys() and row["verdict"] != NOT_TESTABLE:
            row |= DEFAULT_CONDITIONS.get(kind, {})
        row["judgement"] = {
            verdict: [vars(read_condition(text)) for text in row.pop(key)]
            for key, verdict in CONDITIONS.items()
            if key in row
        }
        if "equations" in row:
            row["equations"] = read_equations(scene, row["equations"], shared)
            if "erratum" in row:
                row = add_forms(row)
        return converted(scene, row, LedgerRow)
    except REFUSALS as error:
        raise ValueError(f"row {name}: {error}") from error


def add_forms(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of a misprint with its forms, printed and corrected, from its equations.

    Products are blanks there, as in other formulas.
    """
    pairs = pairwise(sides(row["equations"]["text"]))
    wrong = [(own, other) for (_, own), (left, other) in pairs if left == "printed"]
    texts = ["; ".join(own) for own in zip(*wrong, strict=True)]
    texts = [text.replace("**", "^").replace("*", " ") for text in texts]
    forms = dict(zip(("corrected", "printed"), texts, strict=False))
    row = {"printed": forms.pop("printed", ""), **row}
    return {**row, "erratum": {**forms, **row["erratum"]}}


def read_equations(
    scene: str, data: Mapping[str, Any], shared: Mapping[str, str]
) -> dict[str, Any]:
    """Return a table of equations with the definitions and values that several rows share.

    Each of the definitions is a text, or the name of a shared one; among the values
    ``from`` names a table in a module, which has others.
    """
    definitions = (shared.get(text, text) for text in data.get("definitions", ()))
    values = dict(data.get("values", {}))
    table = values.pop("from", None)
    others = measure(scene, table) if table else {}
    return {**data, "definitions": join_lines(*definitions), "values": others | values}


def read_condition(text: str) -> Condition:
    """Return a condition from its text.

    >>> read_condition("share >= 0.9, everyone, ours")
    Condition(name='share', relation='>=', limit=0.9, everyone=True, ours=True)
    """
    match = CONDITION.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is no condition such as 'error < 1e-3, everyone, ours'")
    name, relation, word, everyone, ours = match.groups()
    limit: Any = {"true": True, "false": False}.get(word, word)
    if relation != "rounds to" and re.fullmatch(r"[-+\d.e]*\d[-+\d.e]*", word):
        limit = float(word)
    return Condition(name, relation, limit, bool(everyone), bool(ours))


RECORDS = {"erratum": Erratum, "equations": Identities, "figures": PaperFigure, "causes": Cause}
"""Key -> kind of the records under it."""


def converted(scene: str, data: Mapping[str, Any], kind: Any) -> Any:
    """Return a record of a kind; measures are found by their names."""
    check_keys(data, kind)
    return msgspec.convert(data, kind, dec_hook=lambda _, value: measure(scene, value))


def check_keys(data: Mapping[str, Any], kind: Any) -> None:
    """Refuse keys that a kind of record does not have, which would be ignored silently."""
    known = [item.name for item in fields(kind)]
    for key, value in data.items():
        if key not in known:
            raise ValueError(f"{key!r} is no field; there are {', '.join(known)}")
        for part in value if isinstance(value, list) else [value]:
            if key in RECORDS and isinstance(part, dict):
                check_keys(part, RECORDS[key])


def measure(scene: str, named: str | Mapping[str, Any]) -> Any:
    """Return the object of this name in the measures of a scene, its arguments filled in.

    ``second_order``, or ``{call = "distances", plate = true}``; another module is named before a
    point, ``figures.figure_2``; an argument may be a function, ``{call = "peak"}``. A table without
    ``call`` has formulas, ``{value = "share_of(blue_o_5)"}``.
    """
    if isinstance(named, str):
        module, _, name = named.rpartition(".")
        return getattr(import_module(f"{__package__}.{scene}.{module or 'measures'}"), name)
    if "call" not in named:
        for text in named.values():
            compile(text, text, "eval")
        return Formulas(named, import_module(f"{__package__}.{scene}.measures"))
    function = measure(scene, named["call"])
    arguments = {name: argument(scene, value) for name, value in named.items() if name != "call"}
    return partial(function, **arguments) if arguments else function


def argument(scene: str, value: Any) -> Any:
    """Return an argument of a measure, with tuples for lists and functions for their names."""
    if isinstance(value, list):
        return tuple(argument(scene, one) for one in value)
    return measure(scene, value) if isinstance(value, dict) and "call" in value else value
