"""What there is to choose from, on the console."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from ..reports.text import matrix_by_kind, print_line, print_table, print_wrapped
from ..reports.words import assignments


def print_overview(console: Console, overview: Mapping[str, Any]) -> None:
    """Print scenes, engines with their methods, and kinds of check."""
    print_table(console, ["scene", ""], [[s["name"], s["title"]] for s in overview["scenes"]])
    engines = [
        [
            item["name"],
            item["version"] or "not available",
            item["reason"] or ", ".join(f"{m['name']} ({m['order']})" for m in item["methods"]),
        ]
        for item in overview["engines"]
    ]
    print_table(console, ["engine", "version", "methods (order)"], engines)
    print_wrapped(console, f"kinds of check: {', '.join(overview['kinds'])}")
    print_line(console, "more about a scene: mbcheck list SCENE")


def print_coverage(console: Console, coverage: Mapping[str, Any]) -> None:
    """Print how many checks each scene, engine and kind has."""
    cells = coverage["cells"]
    counts: dict[tuple[str, ...], object] = {
        (c["scene"], c["engine"], c["kind"]): c["checks"] or None for c in cells
    }
    print_table(console, *matrix_by_kind(counts))
    for cell in cells:
        if not cell["checks"]:
            place = " ".join((cell["scene"], cell["engine"], cell["kind"]))
            print_line(console, f"{place}: {cell['reason']}")
    print_line(console, "checks that run by default; each judges several quantities")


def print_scene(console: Console, sheet: Mapping[str, Any]) -> None:
    """Print a scene: source, parameters, states, places of rest, models, cases."""
    paper = sheet["paper"]
    print_wrapped(console, f"{sheet['scene']}: {sheet['title']}")
    where = [paper["journal"], f"doi {paper['doi']}" if paper["doi"] else ""]
    source = ", ".join(filter(None, [paper["title"], *where]))
    print_wrapped(console, f"{paper['authors']} ({paper['year']}), {source}")
    names = ("name", "symbol", "default", "unit", "source", "meaning")
    rows = [[item[name] for name in names] for item in sheet["parameters"]]
    print_table(console, ["parameter", *names[1:]], rows)
    lines = {"states and observables:": with_units(sheet["states"])}
    for on_request, label in ((False, "also observed:"), (True, "on request (--observe):")):
        lines[label] = with_units([o for o in sheet["outputs"] if o["on_request"] == on_request])
    lines["states of rest (--about):"] = ", ".join(sheet["about"])
    lines["drive:"] = sheet["drive"] or "none that is a function of time"
    for engine, models in sheet["models"].items():
        lines[f"models of {engine}:"] = ", ".join(models) or "none"
    for label, text in lines.items():
        if text:
            print_wrapped(console, f"{label} {text}")
    console.print()
    cases = [
        [
            item["name"],
            item["horizon"],
            assignments(item["parameters"] | item["state"] | offsets(item["inconsistency"])),
            ", ".join(item["kinds"]) + (" (--full only)" if item["full_only"] else ""),
        ]
        for item in sheet["cases"]
    ]
    print_table(console, ["case", "horizon [s]", "differs by", "kinds"], cases)
    maps = [
        [
            item["quantity"],
            item["about"],
            ", ".join(item["models"]),
            ", ".join(item["variables"]),
            "yes" if item["engines"] else "no",
        ]
        for item in sheet["maps"]
    ]
    if maps:
        heads = ["map (--quantity)", "of", "models of the reference", "variables", "engines"]
        print_table(console, heads, maps)
    if sheet["axes"]:
        rows = [[item[name] for name in ("name", "unit", "meaning")] for item in sheet["axes"]]
        print_table(console, ["axis of a map", "unit", "meaning"], rows)


def with_units(items: list[Mapping[str, Any]]) -> str:
    """Return names with their units."""
    return ", ".join(f"{item['name']} [{item['unit']}]" for item in items)


def offsets(inconsistency: Mapping[str, float]) -> dict[str, float]:
    """Return by how much a mechanism starts open, named as such."""
    return {f"offset of {name}": value for name, value in inconsistency.items()}
