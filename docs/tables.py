"""The tables of scenes, maps, checks and rules in the pages of docs/."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path

from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.cli import catalogue
from mbcheck.comparisons.faults.variants import NOT_PROVOKED
from mbcheck.comparisons.inspect.rules.table import RULES
from mbcheck.comparisons.reports.text import markdown_table
from mbcheck.comparisons.reports.words import assignments
from mbcheck.reference import SCENES


def code(names: Iterable[str]) -> str:
    """Return names in backticks, separated by commas."""
    return ", ".join(f"`{name}`" for name in names)


def scene(name: str) -> str:
    """Return the parameters, observables, models and cases of a scene."""
    sheet = catalogue.scene_sheet(name)
    facts = {
        "State": code(item["name"] for item in sheet["states"]),
        "Also observed": code(o["name"] for o in sheet["outputs"] if not o["on_request"]),
        "On request (`--observe`)": code(o["name"] for o in sheet["outputs"] if o["on_request"]),
        "States of rest (`--about`)": code(sheet["about"]),
        "Drive": sheet["drive"],
        **{f"Models, {engine}": code(models) for engine, models in sheet["models"].items()},
    }
    return "\n\n".join(
        (
            markdown_table(
                ("Parameter", "Symbol", "Unit", "Default", "Meaning"),
                [
                    (f"`{i['name']}`", i["symbol"], i["unit"], i["default"], i["meaning"])
                    for i in sheet["parameters"]
                ],
                digits=10,
            ),
            markdown_table(("", ""), [row for row in facts.items() if row[1]]),
            markdown_table(
                ("Case", "Checks", "Horizon [s]", "Differs by"),
                [
                    (
                        f"`{item['name']}`{' (`--full`)' if item['full_only'] else ''}",
                        ", ".join(item["kinds"]),
                        item["horizon"],
                        assignments(item["parameters"] | item["state"]),
                    )
                    for item in sheet["cases"]
                ],
            ),
        )
    )


def maps() -> str:
    """Return the quantities of all maps."""
    return markdown_table(
        ("Scene", "`--quantity`", "What", "`--model` of the reference", "Engines"),
        [
            (
                name,
                f"`{item['quantity']}`",
                item["about"],
                code(item["models"]),
                "yes" if item["engines"] else "no",
            )
            for name in SCENES
            for item in catalogue.scene_sheet(name)["maps"]
        ],
    )


def variables() -> str:
    """Return the variables of all maps, without the bounds on their errors."""
    return markdown_table(
        ("Scene", "`--quantity`", "Variable", "Unit", "Meaning", "Classes"),
        [
            (name, f"`{item['quantity']}`", f"`{key}`", v["unit"], v["meaning"], code(v["classes"]))
            for name in SCENES
            for item in catalogue.scene_sheet(name)["maps"]
            for key, v in item["variables"].items()
            if "bound" not in key
        ],
    )


def axes() -> str:
    """Return the axes of maps that are no parameters."""
    return markdown_table(
        ("Scene", "Axis", "Unit", "Meaning"),
        [
            (name, f"`{item['name']}`", item["unit"], item["meaning"])
            for name in SCENES
            for item in catalogue.scene_sheet(name)["axes"]
        ],
    )


def coverage() -> str:
    """Return how many checks each scene, engine and kind has."""
    rows: dict[tuple[str, str], list[str]] = {}
    for cell in catalogue.coverage()["cells"]:
        rows.setdefault((cell["scene"], cell["engine"]), []).append(str(cell["checks"]))
    return markdown_table(
        ("Scene", "Engine", *KINDS), [(*place, *checks) for place, checks in rows.items()]
    )


def findings() -> str:
    """Return the rules of ``mbcheck inspect``."""
    return markdown_table(
        ("Rule", "Severity", "Needs", "Finds"),
        [
            (
                f"`{name}`",
                f"*{rule.severity}*" if rule.house else rule.severity,
                rule.needs,
                rule.meaning,
            )
            for name, rule in RULES.items()
        ],
    )


def not_provoked() -> str:
    """Return the known failures that no check provokes."""
    return markdown_table(("Failure", "Why it is not provoked"), NOT_PROVOKED)


def releases() -> str:
    """Return the findings of `compare` in older releases of MuJoCo, as they are committed."""
    path = Path(__file__).with_name("releases.json")
    rows = json.loads(path.read_text(encoding="utf-8"))["rows"]
    return markdown_table(
        ("Model", "Release", "Exit code", "First finding", "More", "Without effect"),
        [
            (
                row["model"],
                row["release"],
                row["exit_code"],
                *(row["findings"] or ["alike"])[:1],
                max(len(row["findings"]) - 1, 0),
                "; ".join(row["idle_defaults"]),
            )
            for row in rows
        ],
    )


TABLES: Mapping[str, Callable[[], str]] = {
    "maps": maps,
    "variables": variables,
    "axes": axes,
    "coverage": coverage,
    "rules of models": findings,
    "failures that are not provoked": not_provoked,
    "releases": releases,
    **{f"scene {name}": partial(scene, name) for name in SCENES},
}
"""The tables by name."""
