"""Trajectories, orbits and modes on the console."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console

from ...reference import get_scene
from ..queries.frequencies import Frequencies
from ..queries.orbit import OrbitReport
from ..queries.simulate import Simulation
from .text import DIGITS, print_line, print_table
from .words import assignments, number

FIRST_ORDERS = 4
"""Harmonics of an orbit that fit a line; JSON has more."""

NUMBER_WIDTH = 17
"""Characters of a float with ten digits, and the gap before it."""

LEAST_ROWS, MOST_ROWS = 8, 40
"""Longer trajectories are shown by their beginning and end; the limit is for all tables together,
as long as that leaves each its least number of rows."""


def print_origin(console: Console, result: Simulation | OrbitReport) -> None:
    """Print scene, engine, method, model, step and parameters of a result."""
    step = "" if result.step is None else f", step {result.step!r} s"
    print_line(
        console, f"{result.scene}: {result.engine} {result.method}, model {result.model}{step}"
    )
    print_parameters(console, result.parameters)


def print_parameters(console: Console, parameters: Mapping[str, Any]) -> None:
    """Print parameters."""
    print_line(console, f"parameters: {assignments(parameters)}")


def print_simulation(console: Console, result: Simulation) -> None:
    """Print a trajectory: its beginning and end, if it is long.

    Its observables go to as many tables, one below the other, as the width of the console needs.
    """
    print_origin(console, result)
    heads = [f"{name} [{result.units[name]}]" for name in result.observables]
    width = max(NUMBER_WIDTH, *(len(head) + 2 for head in heads))
    ends = [*result.times[:MOST_ROWS], *result.times[-MOST_ROWS:]]
    longest = max(len(number(float(time), DIGITS)) for time in ends)
    fit = max(1, (console.width - longest) // width)
    most = max(LEAST_ROWS, MOST_ROWS // -(-len(heads) // fit))
    for first in range(0, len(heads), fit):
        columns = list(result.observables.values())[first : first + fit]
        rows: list[list[object]] = [
            ["lost" if np.isnan(value) else float(value) for value in row]
            for row in zip(result.times, *columns, strict=True)
        ]
        if len(rows) > most:
            rows[most // 2 : -most // 2] = [["...", *("" for _ in columns)]]
        print_table(console, ["t [s]", *heads[first : first + fit]], rows)
    if result.error_bound is not None:
        bounds = (f"{name} {number(value, 2)}" for name, value in result.error_bound.items())
        print_line(console, f"error bound: {', '.join(bounds)}")
    if result.lost:
        print_line(console, result.lost)
    print_line(
        console,
        f"{result.work['steps']} steps in {number(result.work['seconds'])} s; all digits with "
        "--csv or --json",
    )


def print_orbit(console: Console, result: OrbitReport) -> None:
    """Print an orbit: state, multipliers, harmonics, powers."""
    print_origin(console, result)
    stable = f"{'' if result.stable else 'un'}stable; other orbits may exist at these parameters"
    print_line(console, f"period {result.period!r} s, {stable}")
    units = get_scene(result.scene).units
    if result.mean_speed is not None:
        print_line(console, f"mean speed {number(result.mean_speed, 10)} rad/s")
    state = result.error_bound or {}
    states = [
        [name, value, units.get(name, ""), state.get(name)] for name, value in result.state.items()
    ]
    if result.period_bound is not None:
        states.append(["period", result.period, "s", result.period_bound])
    print_table(console, ["state where a period begins", "value", "unit", "error bound"], states)
    multipliers = [
        [one.re, one.im, one.modulus, one.error_bound, "trivial" if one.trivial else ""]
        for one in result.floquet_multipliers
    ]
    heads = ["Floquet multiplier: re", "im", "modulus", "error bound", ""]
    print_table(console, heads, multipliers)
    spectra = [
        [
            f"{name} [{units.get(name, 1)}]",
            one.mean,
            *(term.amplitude for term in one.terms[:FIRST_ORDERS]),
        ]
        for name, one in result.harmonics.items()
    ]
    orders = range(1, len(spectra[0]) - 1)
    print_table(console, ["amplitude of harmonic", "mean", *map(str, orders)], spectra, digits=3)
    bound = result.power_bound or {}
    power = [[name, value, bound.get(name)] for name, value in result.power.items()]
    print_table(console, ["mean power", "W", "error bound"], power)
    if result.quantities:
        quantities = [
            [name, one.value, one.unit, one.error_bound] for name, one in result.quantities.items()
        ]
        print_table(console, ["quantity", "value", "unit", "error bound"], quantities)


def print_frequencies(console: Console, result: Frequencies) -> None:
    """Print modes."""
    kind = result.plane or ("undamped" if result.undamped else "damped")
    words = f"{kind} modes{', with ' * bool(result.unforced)}{assignments(result.unforced)}"
    words += "".join(f", {name} keeps its speed" for name in result.steady)
    print_line(console, f"{result.scene}: {result.engine}, model {result.model}, {words}")
    print_parameters(console, {**result.parameters, **result.unforced})
    print_line(console, f"about {result.about}: {assignments(result.state)}")
    rows = [
        [
            m.omega,
            m.hertz if m.im else None,
            m.damping_ratio,
            m.re,
            m.im,
            number(m.error_bound, 2, "-"),
        ]
        for m in result.modes
    ]
    heads = ["omega [rad/s]", "[Hz]", "damping ratio", "re [1/s]", "im [1/s]", "error bound"]
    print_table(console, heads, rows)


def csv_text(result: Simulation, bounds: bool = False) -> str:
    """Return a trajectory as CSV: comments with its origin, ``t``, the observables, all digits.

    Cells are empty where the motion is lost; ``bounds`` adds a column ``NAME_bound`` for each
    observable of the reference.
    """
    text, bound = io.StringIO(), result.error_bound or {}
    tables = {
        "parameters [SI]": result.parameters,
        "units": {"t": "s", **result.units},
        "largest error": bound,
        "versions": result.versions,
    }
    step = "" if result.step is None else f", step {result.step!r} s"
    lines = [f"{result.scene} by {result.engine} {result.method}, model {result.model}{step}"]
    lines += [
        f"{name}: {', '.join(f'{key}={value}' for key, value in table.items())}"
        for name, table in tables.items()
        if table
    ]
    text.writelines(f"# {line}\n" for line in (*lines, result.lost) if line)
    columns = {"t": result.times, **result.observables}
    for name, size in bound.items() if bounds else ():
        columns[f"{name}_bound"] = np.where(np.isnan(columns[name]), np.nan, size)
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*(values.tolist() for values in columns.values()), strict=True):
        writer.writerow("" if math.isnan(value) else value for value in row)
    return text.getvalue()
