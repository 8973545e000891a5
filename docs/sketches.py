"""Sketches of the scenes' mechanisms, the first column of the README's picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from mbcheck.comparisons.reports.drawing import FAINT, INK
from mbcheck.reference.scene import Array


def line(axes: Any, *points: tuple[float, float], **how: Any) -> None:
    """Draw a polygon line."""
    axes.plot(*np.transpose(points), **{"color": INK, "linewidth": 1.3} | how)


def along(start: Any, end: Any, shape: Array) -> Array:
    """Return points (2, k) given as (length, height) shares of the way from start to end."""
    begin, way = np.asarray(start, float), np.subtract(end, start).astype(float)
    across = np.array([-way[1], way[0]]) / np.hypot(*way)
    return begin[:, None] + way[:, None] * shape[0] + across[:, None] * shape[1]


def spring(axes: Any, start: Any, end: Any, width: float = 0.08) -> None:
    """Draw a spring."""
    share = np.array([0, 0.15, *np.linspace(0.2, 0.8, 7), 0.85, 1])
    height = np.array([0, 0, *(width * (-1.0) ** np.arange(7)), 0, 0])
    axes.plot(*along(start, end, np.array([share, height])), color=INK, linewidth=1.1)


def damper(axes: Any, start: Any, end: Any, width: float = 0.08) -> None:
    """Draw a damper."""
    cup = np.array([[0.75, 0.4, 0.4, 0.75], [width, width, -width, -width]])
    piston = [[0.6, 0.6], [-0.7 * width, 0.7 * width]]
    for shape in ([[0, 0.4], [0, 0]], cup, piston, [[0.6, 1], [0, 0]]):
        axes.plot(*along(start, end, np.array(shape, dtype=float)), color=INK, linewidth=1.1)


def wall(axes: Any, start: Any, end: Any) -> None:
    """Draw the ground as a line, hatched on its right seen from start to end."""
    axes.plot(*np.transpose([start, end]), color=INK, linewidth=1.3)
    length = float(np.hypot(*np.subtract(end, start)))
    for share in np.arange(0.06, length, 0.1) / length:
        tick = np.array([[share, share - 0.07 / length], [0, -0.07]])
        axes.plot(*along(start, end, tick), color=INK, linewidth=0.7)


def box(axes: Any, centre: tuple[float, float], width: float, height: float) -> None:
    """Draw a body as a rectangle."""
    x, y = centre[0] - width / 2, centre[1] - height / 2
    axes.fill(
        [x, x + width, x + width, x], [y, y, y + height, y + height],
        facecolor="#E8E8E8", edgecolor=INK, linewidth=1.3, zorder=2,
    )  # fmt: skip


def disc(axes: Any, at: Any, size: float = 8, colour: str = "#0072B2") -> None:
    """Draw a point mass."""
    axes.plot(*at, "o", color=colour, markersize=size, zorder=4)


def joint(axes: Any, at: Any) -> None:
    """Draw a hinge."""
    axes.plot(*at, "o", color="white", markeredgecolor=INK, markersize=4.5, zorder=5)


def turn(axes: Any, centre: Any, radius: float, start: float, end: float) -> None:
    """Draw an arrow along an arc, from one angle to another [rad]."""
    angles = np.linspace(start, end, 40)
    x, y = polar(centre, radius, angles)
    axes.plot(x[:-2], y[:-2], color=INK, linewidth=0.8)
    arrow(axes, (x[-6], y[-6]), (x[-1], y[-1]))


def orbit(axes: Any, centre: Any, radius: float) -> None:
    """Draw the circle on which a point moves."""
    points = polar(centre, radius, np.linspace(0, 2 * np.pi, 80))
    axes.plot(*points, color=FAINT, linewidth=0.8, linestyle=(0, (3, 2)))


def arrow(axes: Any, start: Any, end: Any) -> None:
    """Draw a straight arrow."""
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops={**style, "mutation_scale": 8})


def frame(axes: Any, middle: float, bottom: float) -> None:
    """Show a sketch in the same frame as the others."""
    axes.set(xlim=(middle - 1.45, middle + 1.45), ylim=(bottom, bottom + 1.75))


def polar(centre: Any, radius: float, angle: Any) -> tuple[Any, Any]:
    """Return the point at a distance and an angle [rad] from a centre."""
    return centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)


def sketch_hula_hoop(axes: Any) -> None:
    """Draw a mass on a spring, shaken, with a free mass on a hinged rod."""
    hinge, length, theta = (0.0, 0.75), 0.55, 0.7
    wall(axes, (-0.35, 0), (0.35, 0))
    spring(axes, (-0.15, 0), (-0.15, 0.6))
    damper(axes, (0.15, 0), (0.15, 0.6))
    box(axes, hinge, 0.6, 0.3)
    orbit(axes, hinge, length)
    mass = polar(hinge, length, theta)
    line(axes, hinge, mass, zorder=3, linewidth=1.8)
    line(axes, hinge, (hinge[0] + length, hinge[1]), linewidth=0.6, zorder=3)
    turn(axes, hinge, 0.4, 0.0, theta)
    joint(axes, hinge)
    disc(axes, mass)
    arrow(axes, (-0.75, 0.6), (-0.75, 0.9))
    arrow(axes, (0, 1.38), (0, 1.05))
    for text, place in (
        ("y", (-0.95, 0.75)),
        ("F cos $\\omega$t", (0.05, 1.36)),
        ("M", (-0.2, 0.72)),
        ("m", (0.48, 1.2)),
        ("theta", (0.46, 0.84)),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.0, -0.1)


def sketch_rotor_pendulum(axes: Any) -> None:
    """Draw a sprung platform with a rotor, and a rod whose end carries a second one."""
    hinge, beta = (0.35, 0.4), np.pi / 6
    end = polar(hinge, 0.85, beta)
    wall(axes, (-1.1, 0.05), (-1.1, 0.75))
    spring(axes, (-1.1, 0.57), (-0.35, 0.57))
    damper(axes, (-1.1, 0.23), (-0.35, 0.23))
    box(axes, (0.15, 0.4), 1.0, 0.5)
    wall(axes, (0.8, 0.1), (-0.5, 0.1))
    line(axes, hinge, end, linewidth=2.2, zorder=3)
    line(axes, hinge, (1.25, 0.4), linewidth=0.6, zorder=3)
    turn(axes, hinge, 0.62, 0.0, beta)
    for centre, angle, way in ((hinge, np.pi - 0.9, -1), (end, 1.1, 1)):
        mass = polar(centre, 0.3, angle)
        line(axes, centre, mass, zorder=3)
        disc(axes, mass)
        turn(axes, centre, 0.4, angle + 0.25 * way, angle + 1.1 * way)
    disc(axes, end, 7, INK)
    joint(axes, hinge)
    arrow(axes, (-0.2, -0.12), (0.2, -0.12))
    for text, place in (
        ("x", (0.25, -0.12)),
        ("phi_1", (0.1, 0.93)),
        ("phi_2", (0.84, 1.42)),
        ("beta + phi_3", (1.0, 0.52)),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.15, -0.2)


def sketch_rotating_beam(axes: Any) -> None:
    """Draw a hub that turns, and on it a bent beam with a mass at its tip."""
    hub, radius, angle, length, bent = (0.0, 0.0), 0.22, 0.45, 1.5, -0.35
    way = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-way[1], way[0]])
    share = np.linspace(0, 1, 40)
    height = bent * (6 * share**2 - 4 * share**3 + share**4) / 3
    beam = np.outer(radius + length * share, way) + np.outer(height, across)
    straight = (radius + length) * way
    line(axes, hub, (1.3, 0), linewidth=0.6)
    line(axes, hub, tuple(1.12 * straight), linewidth=0.6, linestyle=(0, (6, 2, 1, 2)))
    turn(axes, hub, 0.95, 0.0, angle)
    axes.plot(*beam.T, color=INK, linewidth=2.6, zorder=3)
    axes.fill(*polar(hub, radius, np.linspace(0, 2 * np.pi, 60)), facecolor="#E8E8E8",
        edgecolor=INK, linewidth=1.3, zorder=2)  # fmt: skip
    turn(axes, hub, 0.36, np.pi - 0.9, np.pi + 0.9)
    joint(axes, hub)
    disc(axes, beam[-1])
    arrow(axes, straight, straight + 0.85 * (beam[-1] - straight))
    for text, place in (
        ("J_h", (-0.1, -0.36)),
        ("theta", (1.02, 0.14)),
        ("E, I, rho, A, L", (0.3, -0.2)),
        ("m", (1.8, 0.4)),
        ("tip_deflection", (0.68, 0.86)),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.72, -0.65)


def sketch_speed_regulator(axes: Any) -> None:
    """Draw a crank that drives a damped and sprung slider by a rod."""
    origin, phi, length = (0.0, 1.2), 0.9, 0.75
    pin = polar(origin, 0.25, phi)
    foot = (0.0, pin[1] - float(np.sqrt(length**2 - pin[0] ** 2)))
    orbit(axes, origin, 0.25)
    line(axes, origin, (0.45, origin[1]), linewidth=0.6)
    turn(axes, origin, 0.36, 0.0, phi)
    turn(axes, origin, 0.42, np.pi - 0.6, np.pi + 0.6)
    line(axes, origin, pin, linewidth=2.2)
    line(axes, pin, foot, linewidth=1.8, zorder=3)
    box(axes, foot, 0.3, 0.16)
    for x in (-0.19, 0.19):
        line(axes, (x, foot[1] - 0.2), (x, foot[1] + 0.2), linewidth=0.9)
    spring(axes, (-0.08, foot[1] - 0.08), (-0.08, 0), 0.06)
    damper(axes, (0.08, foot[1] - 0.08), (0.08, 0), 0.05)
    wall(axes, (-0.3, 0), (0.3, 0))
    for at in (origin, pin, foot):
        joint(axes, at)
    for text, place in (
        ("M_m", (-0.82, 1.2)),
        ("phi", (0.38, 1.35)),
        ("A", (0.06, 1.52)),
        ("B", (0.25, foot[1])),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.0, -0.1)


SKETCHES: Mapping[str, Callable[[Any], None]] = {
    "hula_hoop": sketch_hula_hoop,
    "rotor_pendulum": sketch_rotor_pendulum,
    "rotating_beam": sketch_rotating_beam,
    "speed_regulator": sketch_speed_regulator,
}
