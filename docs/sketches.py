"""Sketches of the scenes' mechanisms, the first column of the README's picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from mbcheck.comparisons.reports.drawing import FAINT, INK

Point = tuple[float, float]


class Sketch(NamedTuple):
    """A mechanism, drawn part by part.

    Attributes
    ----------
    parts : sequence of (function, arguments)
        What is drawn, one over the other, by functions of this module.
    labels : mapping of str to point
        What is written into it, and where.
    middle, bottom : float
        Of the frame, which has the same size in all sketches.
    """

    parts: Sequence[tuple[Any, ...]]
    labels: Mapping[str, Point]
    middle: float
    bottom: float

    def draw(self, axes: Any) -> None:
        """Draw the mechanism and its labels."""
        for part, *arguments in self.parts:
            part(axes, *arguments)
        for text, place in self.labels.items():
            axes.text(*place, text, va="center", fontsize=8.5)
        axes.set(
            xlim=(self.middle - 1.45, self.middle + 1.45), ylim=(self.bottom, self.bottom + 1.75)
        )


def line(axes: Any, points: Any, width: float = 1.3, dashes: Any = "solid") -> None:
    """Draw a polygon line."""
    axes.plot(*np.transpose(points), color=INK, linewidth=width, linestyle=dashes)


def along(axes: Any, start: Any, end: Any, lengths: Any, heights: Any, width: float = 1.1) -> None:
    """Draw a line through points by their shares of the way from start to end, and heights."""
    way = np.subtract(end, start)
    across = np.array([-way[1], way[0]]) / np.hypot(*way)
    line(axes, start + np.outer(lengths, way) + np.outer(heights, across), width)


def spring(axes: Any, start: Any, end: Any, width: float = 0.08) -> None:
    """Draw a spring."""
    lengths = [0, 0.15, *np.linspace(0.2, 0.8, 7), 0.85, 1]
    along(axes, start, end, lengths, [0, 0, *(width * (-1.0) ** np.arange(7)), 0, 0])


def damper(axes: Any, start: Any, end: Any, width: float = 0.08) -> None:
    """Draw a damper."""
    along(axes, start, end, [0, 0.4], [0, 0])
    along(axes, start, end, [0.75, 0.4, 0.4, 0.75], [width, width, -width, -width])
    along(axes, start, end, [0.6, 0.6], [-0.7 * width, 0.7 * width])
    along(axes, start, end, [0.6, 1], [0, 0])


def wall(axes: Any, start: Any, end: Any) -> None:
    """Draw the ground as a line, hatched on its right seen from start to end."""
    line(axes, (start, end))
    length = float(np.hypot(*np.subtract(end, start)))
    for share in np.arange(0.06, length, 0.1) / length:
        along(axes, start, end, [share, share - 0.07 / length], [0, -0.07], 0.7)


def box(axes: Any, centre: tuple[float, float], width: float, height: float) -> None:
    """Draw a body as a rectangle."""
    x, y = centre[0] - width / 2, centre[1] - height / 2
    fill(axes, [x, x + width, x + width, x], [y, y, y + height, y + height])


def fill(axes: Any, x: Any, y: Any) -> None:
    """Draw a body by its outline."""
    axes.fill(x, y, facecolor="#E8E8E8", edgecolor=INK, linewidth=1.3, zorder=2)


def disc(axes: Any, at: Any, size: float = 8, colour: str = "#0072B2") -> None:
    """Draw a point mass."""
    axes.plot(*at, "o", color=colour, markersize=size)


def joint(axes: Any, at: Any) -> None:
    """Draw a hinge."""
    axes.plot(*at, "o", color="white", markeredgecolor=INK, markersize=4.5)


def turn(axes: Any, centre: Any, radius: float, start: float, end: float) -> None:
    """Draw an arrow along an arc, from one angle to another [rad]."""
    points = np.transpose(polar(centre, radius, np.linspace(start, end, 40)))
    line(axes, points[:-2], 0.8)
    arrow(axes, points[-6], points[-1])


def orbit(axes: Any, centre: Any, radius: float) -> None:
    """Draw the circle on which a point moves."""
    points = polar(centre, radius, np.linspace(0, 2 * np.pi, 80))
    axes.plot(*points, color=FAINT, linewidth=0.8, linestyle=(0, (3, 2)))


def arrow(axes: Any, start: Any, end: Any) -> None:
    """Draw a straight arrow."""
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops={**style, "mutation_scale": 8})


def polar(centre: Any, radius: float, angle: Any) -> tuple[Any, Any]:
    """Return the point at a distance and an angle [rad] from a centre."""
    return centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)


def hula_hoop() -> Sketch:
    """Return a mass on a spring, shaken, with a free mass on a hinged rod."""
    hinge, length, theta = (0.0, 0.75), 0.55, 0.7
    mass = polar(hinge, length, theta)
    parts = (
        (wall, (-0.35, 0), (0.35, 0)),
        (spring, (-0.15, 0), (-0.15, 0.6)),
        (damper, (0.15, 0), (0.15, 0.6)),
        (box, hinge, 0.6, 0.3),
        (orbit, hinge, length),
        (line, (hinge, mass), 1.8),
        (line, (hinge, (length, 0.75)), 0.6),
        (turn, hinge, 0.4, 0.0, theta),
        (joint, hinge),
        (disc, mass),
        (arrow, (-0.75, 0.6), (-0.75, 0.9)),
        (arrow, (0, 1.38), (0, 1.05)),
    )
    labels = {
        "y": (-0.95, 0.75),
        "F cos $\\omega$t": (0.05, 1.36),
        "M": (-0.2, 0.72),
        "m": (0.48, 1.2),
        "theta": (0.46, 0.84),
    }
    return Sketch(parts, labels, 0.0, -0.1)


def rotor_pendulum() -> Sketch:
    """Return a sprung platform with a rotor, and a rod whose end carries a second one."""
    hinge, beta = (0.35, 0.4), np.pi / 6
    end = polar(hinge, 0.85, beta)
    first, second = polar(hinge, 0.3, np.pi - 0.9), polar(end, 0.3, 1.1)
    parts = (
        (wall, (-1.1, 0.05), (-1.1, 0.75)),
        (spring, (-1.1, 0.57), (-0.35, 0.57)),
        (damper, (-1.1, 0.23), (-0.35, 0.23)),
        (box, (0.15, 0.4), 1.0, 0.5),
        (wall, (0.8, 0.1), (-0.5, 0.1)),
        (line, (hinge, end), 2.2),
        (line, (hinge, (1.25, 0.4)), 0.6),
        (turn, hinge, 0.62, 0.0, beta),
        (line, (hinge, first)),
        (disc, first),
        (turn, hinge, 0.4, np.pi - 1.15, np.pi - 2.0),
        (line, (end, second)),
        (disc, second),
        (turn, end, 0.4, 1.35, 2.2),
        (disc, end, 7, INK),
        (joint, hinge),
        (arrow, (-0.2, -0.12), (0.2, -0.12)),
    )
    labels = {
        "x": (0.25, -0.12),
        "phi_1": (0.1, 0.93),
        "phi_2": (0.84, 1.42),
        "beta + phi_3": (1.0, 0.52),
    }
    return Sketch(parts, labels, 0.15, -0.2)


def rotating_beam() -> Sketch:
    """Return a hub that turns, and on it a bent beam with a mass at its tip."""
    hub, radius, angle, length, bent = (0.0, 0.0), 0.22, 0.45, 1.5, -0.35
    way = np.array([np.cos(angle), np.sin(angle)])
    share = np.linspace(0, 1, 40)
    height = bent * (6 * share**2 - 4 * share**3 + share**4) / 3
    beam = np.outer(radius + length * share, way) + np.outer(height, (-way[1], way[0]))
    straight = (radius + length) * way
    parts = (
        (line, (hub, (1.3, 0)), 0.6),
        (line, (hub, 1.12 * straight), 0.6, (0, (6, 2, 1, 2))),
        (turn, hub, 0.95, 0.0, angle),
        (fill, *polar(hub, radius, np.linspace(0, 2 * np.pi, 60))),
        (line, beam, 2.6),
        (turn, hub, 0.36, np.pi - 0.9, np.pi + 0.9),
        (joint, hub),
        (disc, beam[-1]),
        (arrow, straight, straight + 0.85 * (beam[-1] - straight)),
    )
    labels = {
        "J_h": (-0.1, -0.36),
        "theta": (1.02, 0.14),
        "E, I, rho, A, L": (0.3, -0.2),
        "m": (1.8, 0.4),
        "tip_deflection": (0.68, 0.86),
    }
    return Sketch(parts, labels, 0.72, -0.65)


def speed_regulator() -> Sketch:
    """Return a crank that drives a damped and sprung slider by a rod."""
    origin, phi, length = (0.0, 1.2), 0.9, 0.75
    pin = polar(origin, 0.25, phi)
    height = pin[1] - float(np.sqrt(length**2 - pin[0] ** 2))
    foot = (0.0, height)
    parts = (
        (orbit, origin, 0.25),
        (line, (origin, (0.45, 1.2)), 0.6),
        (turn, origin, 0.36, 0.0, phi),
        (turn, origin, 0.42, np.pi - 0.6, np.pi + 0.6),
        (line, (origin, pin), 2.2),
        (box, foot, 0.3, 0.16),
        (line, (pin, foot), 1.8),
        (line, ((-0.19, height - 0.2), (-0.19, height + 0.2)), 0.9),
        (line, ((0.19, height - 0.2), (0.19, height + 0.2)), 0.9),
        (spring, (-0.08, height - 0.08), (-0.08, 0), 0.06),
        (damper, (0.08, height - 0.08), (0.08, 0), 0.05),
        (wall, (-0.3, 0), (0.3, 0)),
        (joint, origin),
        (joint, pin),
        (joint, foot),
    )
    labels = {
        "M_m": (-0.82, 1.2),
        "phi": (0.38, 1.35),
        "A": (0.06, 1.52),
        "B": (0.25, height),
    }
    return Sketch(parts, labels, 0.0, -0.1)


def body(axes: Any, point: Any, centre: Any) -> None:
    """Draw a rigid body with its principal axes, held at a point, and its centre of mass."""
    way = np.subtract(centre, point)
    across = 0.6 * np.array([-way[1], way[0]])
    angles = np.linspace(0, 2 * np.pi, 60)
    outline = centre + 1.15 * np.outer(np.cos(angles), way) + 1.3 * np.outer(np.sin(angles), across)
    fill(axes, *outline.T)
    for axis in (1.3 * way, 1.5 * across, -0.55 * way - 0.9 * across):
        arrow(axes, centre, centre + axis)


def rigid_body() -> Sketch:
    """Return a body on a ball joint that stands still, and its weight."""
    point, centre = (0.0, 0.3), (0.24, 0.72)
    parts = (
        (wall, (0.35, 0.2), (-0.35, 0.2)),
        (body, point, centre),
        (disc, point, 9, INK),
        (disc, centre, 5),
        (arrow, (0.95, 1.1), (0.95, 0.7)),
    )
    labels = {"O": (-0.26, 0.36), "C": (0.3, 0.62), "g": (1.02, 0.9), "J": (-0.2, 1.0)}
    return Sketch(parts, labels, 0.2, 0.0)


def ball_hoop() -> Sketch:
    """Return a mass on a spring, shaken, with a body on a ball joint."""
    point, centre = (0.0, 0.75), (0.34, 1.0)
    parts = (
        (wall, (-0.35, 0), (0.35, 0)),
        (spring, (-0.15, 0), (-0.15, 0.6)),
        (damper, (0.15, 0), (0.15, 0.6)),
        (box, point, 0.6, 0.3),
        (body, point, centre),
        (disc, point, 9, INK),
        (disc, centre, 5),
        (arrow, (-0.75, 0.6), (-0.75, 0.9)),
        (arrow, (-0.2, 1.38), (-0.2, 1.05)),
    )
    labels = {
        "y": (-0.95, 0.75),
        "F cos $\\omega$t": (-0.9, 1.3),
        "M": (-0.24, 0.68),
        "m, J": (0.76, 0.82),
        "r": (0.08, 0.68),
    }
    return Sketch(parts, labels, 0.0, -0.1)


def floating_platform() -> Sketch:
    """Return a platform that nothing holds, with a rotor and a rod on a torsion spring."""
    hub, hinge = np.array([-0.2, 0.7]), np.array([0.35, 0.55])
    end, mass = hinge + np.array([0.3, 0.42]), hub + np.array([-0.12, 0.16])
    angles = np.linspace(0, 2 * np.pi, 60)
    rim = hub + 0.24 * np.column_stack([np.cos(angles), np.sin(angles)])
    parts = (
        (box, (0.1, 0.45), 1.1, 0.24),
        (line, rim, 0.9),
        (line, (hub, mass), 1.8),
        (line, (hinge, end), 1.8),
        (joint, hub),
        (joint, hinge),
        (disc, mass, 7),
        (disc, end, 9),
        (arrow, (-0.75, 0.2), (-0.75, 0.5)),
        (arrow, (-0.75, 0.2), (-0.45, 0.2)),
    )
    labels = {
        "phi": (-0.3, 1.1),
        "theta": (0.5, 0.66),
        "m_1": (-0.62, 0.86),
        "m_3": (0.74, 0.98),
        "m, J": (-0.02, 0.42),
        "x, q": (-0.95, 0.06),
    }
    return Sketch(parts, labels, 0.0, -0.1)


def floating_beam() -> Sketch:
    """Return a hub that nothing holds, a chain of rods on it, and the axes of their hinges."""
    hub = np.array([-0.45, 0.5])
    ways = [[0.33, 0.05], [0.46, 0.1], [0.43, 0.22], [0.32, 0.4]]
    *hinges, tip = hub + np.cumsum(ways, axis=0)
    parts = (
        (body, (-0.7, 0.4), hub),
        (line, [*hinges, tip], 2.4),
        *(
            (arrow, hinge, polar(hinge, 0.45, angle))
            for hinge, angle in zip(hinges, (1.6, 2.0, 2.4), strict=True)
        ),
        *((joint, hinge) for hinge in hinges),
        (disc, tip, 9),
        (arrow, (-1.05, 0.0), (-1.05, 0.3)),
        (arrow, (-1.05, 0.0), (-0.75, 0.0)),
    )
    labels = {
        "theta_1": (-0.14, 0.37),
        "theta_2": (0.38, 0.5),
        "theta_3": (0.84, 0.76),
        "m_t": (1.18, 1.27),
        "m, J": (-0.72, 0.12),
        "x, q": (-1.25, -0.14),
    }
    return Sketch(parts, labels, 0.05, -0.25)


SKETCHES: Mapping[str, Sketch] = {
    "hula_hoop": hula_hoop(),
    "rotor_pendulum": rotor_pendulum(),
    "rotating_beam": rotating_beam(),
    "speed_regulator": speed_regulator(),
    "rigid_body": rigid_body(),
    "ball_hoop": ball_hoop(),
    "floating_platform": floating_platform(),
    "floating_beam": floating_beam(),
}
