"""Tables for the console: trajectories, orbits, modes, and what there is to choose from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..queries.frequencies import Frequencies
from ..queries.orbit import OrbitReport
from ..queries.simulate import Simulation
from .report import heading

SHOWN_ORDERS = 4
"""Harmonics of an orbit that fit a line; JSON has more."""

NUMBER_WIDTH = 17
"""Characters of a float with ten digits."""

LEAST_ROWS, MOST_ROWS = 8, 40
"""Longer trajectories are shown by their beginning and end; the limit is for all tables together,
as long as that leaves each its least number of rows."""


def show(console: Console, *words: object) -> None:
    """Print words as they are: unwrapped, without markup."""
    console.print(Text(" ".join(str(word) for word in words)), soft_wrap=True)


def table(
    console: Console,
    heads: Iterable[str],
    rows: Iterable[Iterable[object]],
    digits: int = 10,
    narrow: bool = False,
) -> None:
    """Print rows under heads; numbers stand to the right."""
    listed = [list(row) for row in rows]
    drawn = Table(
        box=SIMPLE_HEAD,
        padding=(0, 0, 0, 1) if narrow else (0, 1),
        show_edge=not narrow,
        pad_edge=False,
        header_style="bold",
    )
    for column, head in enumerate(heads):
        numeric = all(isinstance(row[column], float | int | None) for row in listed)
        drawn.add_column(
            Text(head),
            justify="right" if numeric else "left",
            no_wrap=numeric or column == 0,
            overflow="fold",
        )
    for row in listed:
        drawn.add_row(*(Text(cell(value, digits)) for value in row))
    console.print(drawn)


def cell(value: object, digits: int = 10) -> str:
    """Return a value as text; floats with so many digits."""
    if value is None:
        return "-"
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def who(found: Simulation | OrbitReport) -> str:
    """Return scene, engine, method, model and step of a result in one line."""
    step = "" if found.step is None else f", step {found.step!r} s"
    return f"{found.scene}: {found.engine} {found.method}, model {found.model}{step}"


def parameter_line(parameters: Mapping[str, Any]) -> str:
    """Return parameters in one line."""
    return f"parameters: {assignments(parameters)}"


def print_simulation(console: Console, found: Simulation) -> None:
    """Print a trajectory: its beginning and end, if it is long."""
    show(console, who(found))
    show(console, parameter_line(found.parameters))
    heads = [f"{name} [{found.units[name]}]" for name in found.observables]
    widest = max(NUMBER_WIDTH, *map(len, heads))
    fit = max(1, (console.width - NUMBER_WIDTH) // (widest + 3))
    most = max(LEAST_ROWS, MOST_ROWS // -(-len(heads) // fit))
    for first in range(0, len(heads), fit):
        columns = list(found.observables.values())[first : first + fit]
        rows: list[list[object]] = [
            [float(value) for value in row] for row in zip(found.times, *columns, strict=True)
        ]
        if len(rows) > most:
            gap: list[object] = ["..."] * len(rows[0])
            rows = [*rows[: most // 2], gap, *rows[-most // 2 :]]
        table(console, ["t [s]", *heads[first : first + fit]], rows)
    if found.error_bound is not None:
        bounds = (f"{name} {value:.2g}" for name, value in found.error_bound.items())
        show(console, "error bound:", ", ".join(bounds))
    show(
        console,
        f"{found.work['steps']} steps in {found.work['seconds']:.3g} s;",
        "all digits with --csv or --json",
    )


def print_orbit(console: Console, found: OrbitReport) -> None:
    """Print an orbit: state, multipliers, harmonics, powers."""
    show(console, who(found))
    show(console, parameter_line(found.parameters))
    show(console, f"period {found.period!r} s,", "stable" if found.stable else "unstable")
    if found.mean_speed is not None:
        show(console, f"mean speed {cell(found.mean_speed)} rad/s")
    states = [
        [name, value, found.error_bound[name] if found.error_bound else None]
        for name, value in found.state.items()
    ]
    table(console, ["state where a period begins", "value", "error bound"], states)
    multipliers = [
        [z.real, z.imag, abs(z), "trivial" if i == found.trivial_multiplier else ""]
        for i, z in enumerate(found.floquet_multipliers)
    ]
    table(console, ["Floquet multiplier: re", "im", "modulus", ""], multipliers)
    spectra = [
        [name, mean, *(term.amplitude for term in terms[:SHOWN_ORDERS])]
        for name, (mean, terms) in found.harmonics.items()
    ]
    orders = range(1, len(spectra[0]) - 1)
    table(console, ["harmonic", "mean", *map(str, orders)], spectra, digits=3)
    table(console, ["mean power", "W"], found.power.items())
    if found.quantities:
        named = [[name, value, unit] for name, (value, unit) in found.quantities.items()]
        table(console, ["quantity", "value", "unit"], named)


def print_frequencies(console: Console, found: Frequencies) -> None:
    """Print modes."""
    kind = found.plane or ("undamped" if found.undamped else "damped")
    show(console, f"{found.scene}: {found.engine}, model {found.model}, {kind}")
    show(console, parameter_line(found.parameters))
    show(console, f"about {found.about}:", assignments(found.state))
    rows = [[m.omega, m.hertz, m.damping_ratio, m.re, m.im] for m in found.modes]
    table(console, ["omega [rad/s]", "[Hz]", "damping ratio", "re [1/s]", "im [1/s]"], rows)


def print_overview(console: Console, found: Mapping[str, Any]) -> None:
    """Print scenes, engines with their methods, and kinds of check."""
    table(console, ["scene", ""], [[item["name"], item["title"]] for item in found["scenes"]])
    engines = [
        [
            item["name"],
            item["version"] or "not available",
            item["reason"] or ", ".join(f"{m['name']} ({m['order']})" for m in item["methods"]),
        ]
        for item in found["engines"]
    ]
    table(console, ["engine", "version", "methods (order)"], engines)
    show(console, "kinds of check:", ", ".join(found["kinds"]))
    show(console, "more about a scene: mbcheck list SCENE")


def print_coverage(console: Console, found: Mapping[str, Any]) -> None:
    """Print how many checks each scene, engine and kind has."""
    kinds = list(dict.fromkeys(cell["kind"] for cell in found["cells"]))
    rows: dict[tuple[str, str], dict[str, object]] = {}
    notes = []
    for item in found["cells"]:
        row = rows.setdefault((item["scene"], item["engine"]), {})
        row[item["kind"]] = item["checks"] or None
        if not item["checks"]:
            place = " ".join((item["scene"], item["engine"], item["kind"]))
            notes.append(f"{place}: {item['reason']}")
    listed: list[list[object]] = []
    for scene in dict.fromkeys(scene for scene, _ in rows):
        listed.append([scene, *[""] * len(kinds)])
        listed += [
            [f"  {engine}", *(row[kind] for kind in kinds)]
            for (of, engine), row in rows.items()
            if of == scene
        ]
    table(console, ["", *(heading(kind, narrow=True) for kind in kinds)], listed, narrow=True)
    for note in notes:
        show(console, note)
    show(console, "checks that run by default; each judges several quantities")


def print_scene(console: Console, found: Mapping[str, Any]) -> None:
    """Print a scene: source, parameters, states, places of rest, models, cases."""
    paper = found["paper"]
    show(console, f"{found['scene']}: {found['title']}")
    where = [paper["journal"], f"doi {paper['doi']}" if paper["doi"] else ""]
    cited = ", ".join(filter(None, [paper["title"], *where]))
    show(console, f"{paper['authors']} ({paper['year']}), {cited}")
    names = ("name", "symbol", "default", "unit", "source", "meaning")
    rows = [[item[name] for name in names] for item in found["parameters"]]
    table(console, ["parameter", *names[1:]], rows)
    states = ", ".join(f"{item['name']} [{item['unit']}]" for item in found["states"])
    show(console, "states and observables:", states)
    for on_request, label in ((False, "also observed:"), (True, "on request (--observe):")):
        named = [o for o in found["outputs"] if o["on_request"] == on_request]
        if named:
            show(console, label, ", ".join(f"{o['name']} [{o['unit']}]" for o in named))
    show(console, "states of rest (--about):", ", ".join(found["about"]))
    for engine, models in found["models"].items():
        show(console, f"models of {engine}:", ", ".join(models) or "none")
    cases = [
        [
            item["name"],
            item["horizon"],
            assignments(item["parameters"] | item["state"] | offsets(item["inconsistency"])),
            ", ".join(item["kinds"]) + (" (--full only)" if item["full_only"] else ""),
        ]
        for item in found["cases"]
    ]
    table(console, ["case", "horizon [s]", "differs by", "kinds"], cases)
    maps = [
        [
            item["quantity"],
            item["about"],
            ", ".join(item["models"]),
            ", ".join(item["variables"]),
            "yes" if item["engines"] else "no",
        ]
        for item in found["maps"]
    ]
    heads = ["map (--quantity)", "of", "models of the reference", "variables", "engines"]
    table(console, heads, maps)
    if found["axes"]:
        rows = [[item["name"], item["unit"], item["meaning"]] for item in found["axes"]]
        table(console, ["axis of a map", "unit", "meaning"], rows)


def offsets(inconsistency: Mapping[str, float]) -> dict[str, float]:
    """Return by how much a mechanism starts open, named as such."""
    return {f"offset of {name}": value for name, value in inconsistency.items()}


def assignments(values: Mapping[str, Any]) -> str:
    """Return values as NAME=VALUE, in one line."""
    return ", ".join(f"{name}={cell(value)}" for name, value in values.items())
