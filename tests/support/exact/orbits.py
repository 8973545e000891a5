"""Periodic orbits in extended precision, many at once, from the positions that the papers draw.

Equations of motion are those of d'Alembert: ``sum m J^T (J a + bias) = Q`` over points whose
positions are differentiated by hand; nothing of the modules' equations is used. They are integrated
by Gragg's method, extrapolated (Hairer, Norsett, Wanner, section II.9).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

LONG, COMPLEX = np.longdouble, np.clongdouble

EXTENDED = np.finfo(LONG).eps < 1e-18
"""Whether numbers have more digits here than doubles do."""

TINY = LONG(10) ** -200

Motion = Callable[[Any, Any, Any], Any]
"""From time, states (2 n, ...) and parameters to their rates."""


def stacked(parameters: Sequence[Any]) -> SimpleNamespace:
    """Return parameters of many points as arrays; words as they are, one each."""
    fields = parameters[0].as_dict()
    return SimpleNamespace(
        **{
            name: np.array([getattr(p, name) for p in parameters])
            if isinstance(value, str)
            else np.array([getattr(p, name) for p in parameters], dtype=LONG)
            for name, value in fields.items()
        }
    )


PI = 4 * np.arctan(LONG(1))


def solved(mass: list[list[Any]], force: list[Any]) -> list[Any]:
    """Solve symmetric equations by elimination, entry by entry over the points."""
    rows = [[*row, value] for row, value in zip(mass, force, strict=True)]
    n = len(rows)
    for i in range(n):
        for j in range(i + 1, n):
            share = rows[j][i] / rows[i][i]
            rows[j] = [a - share * b for a, b in zip(rows[j], rows[i], strict=True)]
    values: list[Any] = [0] * n
    for i in reversed(range(n)):
        known = sum(rows[i][j] * values[j] for j in range(i + 1, n))
        values[i] = (rows[i][n] - known) / rows[i][i]
    return values


def accelerations(points: Sequence[Any], force: Sequence[Any], inertia: Sequence[Any]) -> list[Any]:
    """Return a of ``sum m J^T (J a + bias) + I a = Q``; points are (mass, [(row of J, bias)])."""
    n = len(force)
    mass = [[inertia[i] if i == j else 0 for j in range(n)] for i in range(n)]
    load = list(force)
    for weight, axes in points:
        for row, bias in axes:
            for i in range(n):
                if row[i] is None:
                    continue
                load[i] = load[i] - weight * row[i] * bias
                for j in range(n):
                    if row[j] is not None:
                        mass[i][j] = mass[i][j] + weight * row[i] * row[j]
    return solved(mass, load)


def hula_hoop(t: Any, x: Any, p: Any) -> Any:
    y, theta, y_dot, spin = x
    natural = np.sqrt(p.stiffness / (p.main_mass + p.free_mass))
    sin, cos, arm = np.sin(theta), np.cos(theta), p.rod_length
    slide = 2 * p.damping_ratio * (p.main_mass + p.free_mass) * natural
    hinge = p.hinge_damping_ratio * p.free_mass * arm**2 * natural
    push = p.force_amplitude * np.cos(2 * PI * p.force_frequency * t)
    points = [
        (p.main_mass, [((1, None), 0)]),
        (p.free_mass, [((1, arm * cos), -arm * sin * spin**2),
                       ((None, -arm * sin), -arm * cos * spin**2)]),
    ]  # fmt: skip
    force = [push - slide * y_dot - p.stiffness * y, -hinge * spin]
    inertia = [0, p.inertia_ratio * p.free_mass * arm**2]
    return np.array([y_dot, spin, *accelerations(points, force, inertia)])


def rotor_pendulum(t: Any, x: Any, p: Any) -> Any:
    one, two, rod = x[1], x[2], x[3] + p.installation_angle
    r, l = p.eccentricity, p.rod_length
    relative = (p.motor_placement == "relative").astype(LONG)
    v_1, v_2, v_3 = x[5], x[6], x[7]
    along = (1, None, None, -l * np.sin(rod)), -l * np.cos(rod) * v_3**2
    across = (None, None, None, l * np.cos(rod)), -l * np.sin(rod) * v_3**2
    points = [
        (p.platform_mass, [((1, None, None, None), 0)]),
        (p.rotor_mass, [((1, r * np.sin(one), None, None), r * np.cos(one) * v_1**2),
                        ((None, r * np.cos(one), None, None), -r * np.sin(one) * v_1**2)]),
        (p.rod_mass, [along, across]),
        (p.rotor_mass, [((1, None, -r * np.sin(two), along[0][3]),
                         along[1] - r * np.cos(two) * v_2**2),
                        ((None, None, r * np.cos(two), across[0][3]),
                         across[1] - r * np.sin(two) * v_2**2)]),
    ]  # fmt: skip

    def motor(speed: Any) -> Any:
        return p.motor_slope * (p.synchronous_speed - speed) - p.friction * speed

    second = motor(v_2 - relative * v_3)
    force = [
        -p.platform_damping * x[4] - p.platform_stiffness * x[0],
        motor(v_1),
        second,
        -p.rod_damping * v_3 - p.rod_stiffness * x[3] - relative * second,
    ]
    a = accelerations(points, force, [0, 0, 0, 0])
    return np.array([*x[4:], *a])


def speed_regulator(t: Any, x: Any, p: Any) -> Any:
    phi, speed = x
    r, l = p.crank_radius, p.rod_length
    sin, cos = np.sin(phi), np.cos(phi)
    h = np.sqrt(l**2 - (r * cos) ** 2)
    slope = r * cos - r**2 * sin * cos / h
    bend = -r * sin - r**2 * (cos**2 - sin**2 - (r * sin * cos / h) ** 2) / h
    pin = [(-r * sin, -r * cos * speed**2), (r * cos, -r * sin * speed**2)]
    end = slope, bend * speed**2
    m = p.rod_mass / 6  # a homogeneous rod: a third of it at each end, a sixth between them
    mass = p.flywheel_inertia + (2 * m + p.slider_mass) * slope**2 + 2 * m * r**2
    mass = mass + 2 * m * pin[1][0] * slope
    bias = (2 * m + p.slider_mass) * slope * end[1]
    bias = bias + 2 * m * sum(jacobian * off for jacobian, off in pin)
    bias = bias + m * (pin[1][0] * end[1] + slope * pin[1][1])
    load = p.damping * slope * speed + p.stiffness * (r * sin - h - p.spring_rest)
    return np.array([speed, (p.torque - slope * load - bias) / mass])


def extrapolated(motion: Motion, t: Any, x: Any, h: Any, p: Any, rows: int = 6) -> Any:
    """Advance states by one step h, to the order ``2 rows``."""
    start, columns = motion(t, x, p), []
    for row in range(1, rows + 1):
        count = 2 * row
        step = h / count
        before, now = x, x + step * start
        for i in range(1, count):
            before, now = now, before + 2 * step * motion(t + i * step, now, p)
        columns.append((before + now + step * motion(t + h, now, p)) / 2)
        for k in range(row - 1, 0, -1):
            share = (LONG(row) / k) ** 2 - 1
            columns[k - 1] = columns[k] + (columns[k] - columns[k - 1]) / share
    return columns[0]


def flow(motion: Motion, x: Any, period: Any, p: Any, steps: int, rows: int = 6) -> Any:
    """Return states (steps + 1, 2 n, ...) over one period."""
    states = [x]
    for i in range(steps):
        states.append(extrapolated(motion, i * period / steps, states[-1], period / steps, p, rows))
    return np.array(states)


def slopes(motion: Motion, x: Any, period: Any, p: Any, steps: int) -> tuple[Any, Any]:
    """Return where states (2 n, k) end, and the slopes (k, 2 n, 2 n + 1) by states and period."""
    size = len(x)
    states = np.repeat(x[:, None], size + 1, axis=1).astype(COMPLEX)
    periods = np.repeat(period[None], size + 1, axis=0).astype(COMPLEX)
    states[np.arange(size), np.arange(size)] += 1j * TINY
    periods[size] += 1j * TINY
    ends = flow(motion, states, periods, p, steps)[-1]
    return ends[:, 0].real, np.moveaxis(ends.imag / TINY, -1, 0)


def orbits(
    motion: Motion,
    parameters: Sequence[Any],
    known: Sequence[Any],
    advance: Any,
    section: int | None,
    steps: int,
) -> tuple[Any, Any, Any, Any]:
    """Return states (2 n, k), periods (k,), Jacobians (k, 2 n, 2 n) and the last corrections (k,).

    By Newton's method from the orbits that are known, the matrix that it inverts in doubles.
    """
    p = stacked(parameters)
    x = np.array([orbit.state for orbit in known], dtype=LONG).T
    period = np.array([orbit.period for orbit in known], dtype=LONG)
    if section is None:
        period = 1 / p.force_frequency
    size = len(x)
    end, first = slopes(motion, x, period, p, steps)
    closing = first[:, :, :size] - np.eye(size)
    if section is not None:
        closing[:, :, section] = first[:, :, size]
    matrices = closing.astype(float)
    for number in range(3):
        rest = (end if number == 0 else flow(motion, x, period, p, steps)[-1]) - x - advance
        change = np.linalg.solve(matrices, rest.T.astype(float)[..., None])[..., 0].T.astype(LONG)
        if section is not None:
            period = period - change[section]
            change[section] = 0
        x = x - change
    _, last = slopes(motion, x, period, p, steps)
    return x, period, last[:, :, :size], np.max(np.abs(change), axis=0)
