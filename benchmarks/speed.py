"""What the slowest computations cost, in units of SciPy's DOP853 on the same equations.

    python benchmarks/speed.py [--quick]

CPU times within one run, each divided into that of a loop of ``solve_ivp(DOP853)`` with right-hand
sides on floats: ratios that one machine and another share. A loop over the points of a map is
extrapolated from a few of them.

1. hula_hoop ``floquet``, 64 x 64 points, against 100 periods of the force at each.
2. hula_hoop ``class`` and rotor_pendulum ``sync``, against runs as long as theirs.
3. ``orbit rotor_pendulum``, against 100 turns of its rotors.
4. 12 ANCF elements of rotating_beam in a pulse, with a bound on the error, against one run.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp

import mbcheck
from mbcheck.comparisons.maps.request import Axis, Request, resolved
from mbcheck.comparisons.maps.run import compute
from mbcheck.comparisons.maps.store import Map
from mbcheck.reference import get_scene
from mbcheck.reference.rotating_beam.elements import element_scene
from mbcheck.reference.scene import Dynamics
from mbcheck.reference.solve.single import solve
from mbcheck.reference.solve.solution import state_size

TOLERANCE, ROUGH = 1e-12, 1e-6
"""Relative tolerance of the loop: where digits are promised, and where a class is asked for."""

PERIODS = 100

HOOP = (Axis("force_frequency", 1.0, 10.0, 64), Axis("force_amplitude", 5.0, 150.0, 64))
RATIOS = (Axis("n_x", 0.5, 7.0, 64), Axis("n_phi", 0.5, 7.0, 64))


def cpu(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the CPU time [s] of a call, and what it returns."""
    begin = process_time()
    result = work()
    return process_time() - begin, result


def with_count(axes: tuple[Axis, Axis], count: int) -> tuple[Axis, Axis]:
    """Return the axes with so many values each."""
    x, y = (Axis(axis.name, axis.low, axis.high, count) for axis in axes)
    return x, y


def run_seconds(scene: str, parameters: Any, span: float, rtol: float, state: Any) -> float:
    """Return the CPU time [s] of one run of the loop."""
    size = np.maximum(np.abs(state), np.max(np.abs(state)) * 1e-3 + 1e-3)
    return one_run(get_scene(scene), parameters, span, rtol, state, size)


def one_run(
    equations: Dynamics, parameters: Any, span: float, rtol: float, state: Any, size: Any
) -> float:
    """Return the CPU time [s] of DOP853 over a span [s], with errors relative to these sizes."""
    derivative = equations.right_hand_side(parameters)
    return cpu(
        lambda: solve_ivp(derivative, (0, span), state, "DOP853", rtol=rtol, atol=rtol * size)
    )[0]


def floquet_loop(sampled: int) -> float:
    """Return the CPU time [s] of a point of the loop, from rotations' guesses."""
    scene, random, times = get_scene("hula_hoop"), np.random.default_rng(0), []
    for _ in range(sampled):
        frequency, force = random.uniform(1, 10), random.uniform(5, 150)
        p = scene.parameters().replace(force_frequency=frequency, force_amplitude=force)
        guess = scene.orbit.guesses(p)[0]
        times.append(run_seconds(scene.name, p, PERIODS / frequency, TOLERANCE, guess))
    return float(np.mean(times))


def mapped(scene: str, quantity: str, axes: tuple[Axis, Axis], count: int) -> tuple[float, Map]:
    """Return the CPU time [s] of a map of count x count points, and the map."""
    asked = resolved(Request(scene, quantity, *with_count(axes, count)))
    return cpu(lambda: compute(asked))


def from_rest_loop(scene: str, axes: tuple[Axis, Axis], spans: Any, sampled: int) -> float:
    """Return the CPU time [s] of a point: two runs from rest over spans [s] (n_y, n_x)."""
    equations, random, times = get_scene(scene), np.random.default_rng(1), []
    x, y = with_count(axes, spans.shape[0])
    for _ in range(sampled):
        row, column = random.integers(0, spans.shape[0], 2)
        values = {x.name: x.values[column], y.name: y.values[row]}
        known = set(equations.parameters.names())
        p = equations.parameters().replace(**{k: v for k, v in values.items() if k in known})
        start = np.zeros(2 * len(equations.coordinates))
        seconds = run_seconds(scene, p, float(spans[row, column]), ROUGH, start)
        times.append(2 * seconds)
    return float(np.mean(times))


def elements(span: float) -> tuple[float, float]:
    """Return the CPU times [s] of elements in a pulse over a span [s], and of one run of them."""
    beam, case = element_scene(12), get_scene("rotating_beam").case("pulse_quick")
    state, rtol = beam.state({}), (beam.stiff or (TOLERANCE, 0.0))[0]
    seconds, found = cpu(lambda: solve(beam, case.parameters, state, [span]))
    return seconds, one_run(beam, case.parameters, span, rtol, state, state_size(found))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="fewer points")
    quick = parser.parse_args().quick
    table = Table(title="CPU time of the loop / of the suite")
    for heading in ("what", "seconds", "loop", "ratio"):
        table.add_column(heading, justify="right", no_wrap=True)

    def row(what: str, seconds: float, loop: float) -> None:
        table.add_row(what, f"{seconds:.3g}", f"{loop:.3g}", f"{loop / seconds:.3g}")

    sampled, count, few = (2, 16, 8) if quick else (8, 64, 30)
    mapped("hula_hoop", "floquet", HOOP, 4)  # imports and warms up
    seconds, _ = mapped("hula_hoop", "floquet", HOOP, count)
    row(f"floquet {count} x {count}", seconds, count**2 * floquet_loop(sampled))
    seconds, found = mapped("hula_hoop", "class", HOOP, few)
    spans = (240 + 120) / np.broadcast_to(found.x.values, (few, few))
    loop = from_rest_loop("hula_hoop", HOOP, spans, sampled)
    row(f"class {few} x {few}", seconds, few**2 * loop)
    seconds, found = mapped("rotor_pendulum", "sync", RATIOS, few)
    loop = from_rest_loop("rotor_pendulum", RATIOS, found.variables["duration"], sampled)
    row(f"sync {few} x {few}", seconds, few**2 * loop)
    turns = PERIODS * float(
        get_scene("rotor_pendulum").period(get_scene("rotor_pendulum").parameters())
    )
    seconds, orbit = cpu(lambda: mbcheck.orbit("rotor_pendulum"))
    scene = get_scene("rotor_pendulum")
    p, state = scene.parameters(), np.array(list(orbit.state.values()))
    row("orbit rotor_pendulum", seconds, run_seconds(scene.name, p, turns, TOLERANCE, state))
    row("12 elements", *elements(0.05 if quick else 0.2))
    Console().print(table)


if __name__ == "__main__":
    main()
