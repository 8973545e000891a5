"""Measures of the rotating_beam paper, and the frequencies and runs that the figures share.

The paper's equations themselves are texts in ``claims.toml``. It names neither the speed of figures
2 and 3 nor the masses of figures 4 and 5; the masses here are those of its section 3.1 and none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh
from scipy.optimize import brentq, minimize_scalar

from ....reference.errors import EngineError
from ....reference.linear import linearise
from ....reference.rotating_beam import (
    FIGURE_4,
    FIGURE_5,
    SCENE,
    beam_scene,
    critical_speed,
    run_quantities,
)
from ....reference.rotating_beam.frequencies.assumed_modes import (
    assumed_modes,
    best_mass_position,
    crossover,
    first_frequency,
    matching_speed,
    rest_modes,
    rest_roots,
)
from ....reference.rotating_beam.frequencies.numbers import Numbers as BeamNumbers
from ....reference.rotating_beam.frequencies.numbers import numbers, tension, time_unit
from ....reference.rotating_beam.frequencies.ritz import gram, places, ritz
from ....reference.rotating_beam.frequencies.stretching import frequencies, stretching
from ....reference.rotating_beam.parameters import RotatingBeam, coefficients, drive, drive_end_time
from ....reference.rotating_beam.shapes import cantilever_modes
from ....reference.scene import Array, Scene
from ....reference.solve.single import states_at
from ...engines.registry import REFERENCE
from ...maps.execute import on_this_machine
from ...maps.store import Map
from ...queries.frequencies import frequencies as engine_frequencies
from ...queries.simulate import simulate
from ..equations import Values
from ..ledger import Numbers
from ..session import Session, once

MASSES = (0.0, 0.4, 0.8, 1.2)
"""Masses [kg]: none, and those of section 3.1."""

SPEED = 7.0
"""Speed of figure 3 [rad/s], at which two assumed modes have the printed maximum for 0.8 kg."""

FASTEST = 12.0
"""Dimensionless speed up to which figure 2 goes."""

HUB_RADIUS = 8.0
"""Radius of the hub in section 3.1 [m]."""

BEAM = RotatingBeam(hub_radius=HUB_RADIUS, angular_speed=SPEED, ramp_time=0.0)
"""Beam of figures 2 and 3."""

PRINTED_MAXIMA = {0.4: 0.442, 0.8: 0.429, 1.2: 0.42}

RODS, SPIN_UP_RODS, MANY_RODS = 16, 24, 32
"""Segments of the engines' models, those of figure 4, and those with ``--full``."""


def segments(session: Session) -> int:
    """Return the number of an engine's rods or elements."""
    return MANY_RODS if session.full else RODS


def frequency_map(session: Session, x: Any, y: Any, engine: str, **more: Any) -> Map:
    """Return a map of frequencies of the beam of figures 2 and 3; ``more`` are parameters."""
    model = more.pop("model", None)
    parameters = {"hub_radius": HUB_RADIUS, **more, "segments": float(segments(session))}
    return session.map(
        SCENE.name, "frequency", x, y, engine=engine, model=model, parameters=parameters
    )


def by_speed(session: Session, engine: str = REFERENCE) -> Map:
    """Return frequencies over speed (columns) and mass at the tip (rows, `MASSES`)."""
    x = ("nondimensional_speed", 0.0, FASTEST, 49 if session.full else 25)
    return frequency_map(session, x, ("mass", MASSES[0], MASSES[-1], len(MASSES)), engine)


def by_ratio(session: Session, engine: str = REFERENCE) -> Map:
    """Return frequencies over mass ratio at the tip (columns) and speed (rows)."""
    x = ("mass_ratio", 0.0, 2.0, 41 if session.full else 17)
    return frequency_map(session, x, ("nondimensional_speed", 0.0, FASTEST, 4), engine)


def by_place(session: Session, engine: str = REFERENCE, model: str | None = None) -> Map:
    """Return frequencies over the mass's place (columns) and mass (rows), at `SPEED`.

    Places are ends of rods: there alone a chain converges with order 2.
    """
    places = (4 if engine == REFERENCE else 1) * segments(session)
    x = ("mass_position", 1 / places, 1.0, places)
    y = ("mass", MASSES[0], MASSES[-1], len(MASSES))
    return frequency_map(session, x, y, engine, model=model, angular_speed=SPEED)


def maximum(place: Array, frequency: Array) -> float:
    """Return where a smooth curve through points inside (0, 1] is largest."""
    spline = CubicSpline(place, frequency)
    at = np.append(spline.derivative().roots(extrapolate=False), place[[0, -1]])
    return float(at[np.argmax(spline(at))])


# Runs ---------------------------------------------------------------------------------------------


class Response(NamedTuple):
    """Times [s], 0 included, and what was observed."""

    times: Array
    values: Mapping[str, Array]


CASES = {4: FIGURE_4, 5: FIGURE_5}
HORIZONS = {4: 20.0, 5: 16.0}
"""Durations of the runs [s]; the text names none."""

SAMPLES = 16
"""Samples of a run per second."""


def beam_of(figure: int, mass: float) -> RotatingBeam:
    """Return the beam of figure 4 or 5."""
    return CASES[figure].replace(mass=mass)


def simulate_beam(p: RotatingBeam, who: str, horizon: float) -> Response | str:
    """Return a motion by the reference or an engine, or why the engine has none."""
    times = np.arange(round(horizon * SAMPLES) + 1) / SAMPLES
    if who == REFERENCE:
        states = states_at(SCENE, p, SCENE.state({}), times)
        energy = SCENE.energy(*np.split(states, 2), SCENE.coefficients(p))
        return Response(times, with_angle({**SCENE.observe(states, p), "energy": energy}, p))
    try:
        motion = simulate(SCENE.name, engine=who, parameters=p.as_dict(), times=times)
    except EngineError as error:
        return f"failed: {error}"
    return Response(times, with_angle(motion.observables, p))


def with_angle(values: Mapping[str, Array], p: RotatingBeam) -> Mapping[str, Array]:
    """Return observables with the angle of the free end about the hub's axis [rad]."""
    along = p.hub_radius + p.length + values["tip_axial"]
    return {**values, "tip_angle": values["theta"] + np.arctan2(values["tip_deflection"], along)}


@once
def runs(session: Session, figure: int, who: str) -> dict[float, Response | str]:
    """Return the motions of figure 4 or 5 by the reference or an engine, by mass."""
    count = max(segments(session), SPIN_UP_RODS if figure == 4 else 0)
    horizon = HORIZONS[figure] * (2 if session.full else 1)
    beams, motions = [beam_of(figure, mass).replace(segments=count) for mass in MASSES], {}
    run = partial(simulate_beam, who=who, horizon=horizon)
    report = session.follow(f"runs of figure {figure} {who}")
    for i, motion in on_this_machine(session.workers)(run, beams):
        motions[MASSES[i]] = motion
        report(len(motions), len(beams))
    return motions


def response(session: Session, figure: int, who: str, mass: float) -> Response:
    """Return one motion.

    Raises
    ------
    EngineError
        If the engine has none.
    """
    motion = runs(session, figure, who)[mass]
    if isinstance(motion, str):
        raise EngineError("failed", motion)
    return motion


# Properties of curves and motions -----------------------------------------------------------------

LOADS = MASSES[1:]
UNIT = time_unit(BEAM)
FIRST_VARIABLE = "nondimensional_1"


def loaded(mass: float, speed: float = SPEED) -> BeamNumbers:
    """Return the beam of figure 3 with a mass, at a speed [rad/s]."""
    return numbers(BEAM.replace(mass=mass, angular_speed=speed))


def curves_of_figure_3(session: Session, engine: str) -> tuple[Array, Array]:
    """Return places (k,) and first frequencies (masses, k)."""
    curves = by_place(session, engine)
    if curves.problems:
        raise EngineError("failed", curves.problems[0][2])
    return curves.x.values, curves.variables[FIRST_VARIABLE]


@once
def furthest(session: Session, mass: float) -> tuple[float, float]:
    """Return the converged maximum that lies farthest out, and its speed [rad/s]."""
    best = minimize_scalar(
        lambda w: -best_mass_position(loaded(mass, w)), bounds=(4, 15), options={"xatol": 0.2}
    )
    return -float(best.fun), float(best.x)


@once
def matched(session: Session, mass: float) -> float:
    """Return the speed [rad/s] at which two assumed modes have the printed maximum."""
    return matching_speed(loaded(mass), PRINTED_MAXIMA[mass], 2) / UNIT


def crossed(place: float) -> str:
    """Return the place where a mass has no effect, or ``nowhere``."""
    return f"{place:.3f}" if np.isfinite(place) else "nowhere"


def peak(motion: Response, p: RotatingBeam) -> float:
    """Return the largest deflection [m], whatever its sign."""
    return abs(run_quantities(motion.times, motion.values, p)["tip_peak"][0])


def top_speed(motion: Response, p: RotatingBeam) -> float:
    """Return the largest velocity of the tip in the hub frame [m/s]."""
    return float(np.max(np.abs(motion.values["tip_deflection_dot"])))


def free(motion: Response, p: RotatingBeam) -> Array:
    """Return the deflections [m] once nothing drives the hub."""
    return motion.values["tip_deflection"][motion.times >= drive_end_time(p)]


def free_amplitude(motion: Response, p: RotatingBeam) -> float:
    """Return the largest deflection [m] once nothing drives the hub, whatever its sign."""
    return float(np.max(np.abs(free(motion, p))))


# Sections 1 and 2 ---------------------------------------------------------------------------------


FIRST_AXIAL = np.pi / 2 / BEAM.length * np.sqrt(BEAM.youngs_modulus / BEAM.density)
"""First axial frequency at rest [rad/s], as printed."""

STRAIGHT = {
    "E": BEAM.youngs_modulus, "A": BEAM.area, "I": BEAM.second_moment, "rho": BEAM.density,
    "L": BEAM.length, "a": BEAM.hub_radius, "x": BEAM.length, "d_0": BEAM.length,
    "J_h": BEAM.hub_inertia, "m": 0.4, "g": 9.80665, "theta_t": 1.0,
    "beta_2": float(rest_roots(1)[0]) / BEAM.length,
    **dict.fromkeys(("u", "u_f", "v", "u_x", "u_xx", "v_xx", "u_t", "u_f_t", "v_t"), 0.0),
}  # fmt: skip
"""Values of a straight beam's tip, 0.4 kg there, at 1 rad/s, for equations; beta_2 at rest."""

MODES = 16
"""Number of assumed modes, converged to within 1e-3."""


def root(session: Session, who: str, i: int) -> float:
    """Return beta_i L of the cantilever at rest; an engine's is that of its frequency."""
    if who == REFERENCE:
        return float(np.sqrt(ritz(BeamNumbers(), count=3).omega[i - 1]))
    at_rest = {"angular_speed": 0.0, "segments": segments(session)}
    modes = session.once(
        (SCENE.name, "modes at rest", who),
        lambda: engine_frequencies(SCENE.name, engine=who, parameters=at_rest, count=3).modes,
    )
    return float(np.sqrt(modes[i - 1].omega * UNIT))


def asymptote(session: Session) -> Numbers:
    """Return the relative errors of (2 i - 1) pi/2 as roots, from the third on."""
    i = np.arange(3, 9)
    errors = np.abs((2 * i - 1) * np.pi / 2 / rest_roots(8)[2:] - 1)
    return {"errors": errors, "rises": np.diff(errors)}


def axial_frequencies(session: Session) -> Numbers:
    """Compare the first form of the axial frequencies with an extensible beam's at rest."""
    scene = beam_scene("extensible", 2, 12)
    mass, _, stiffness = linearise(scene, BEAM, np.zeros(2 * len(scene.coordinates)))
    along = slice(3, None)
    omega = np.sqrt(eigh(stiffness[along, along], mass[along, along], eigvals_only=True)[:3])
    printed = FIRST_AXIAL * np.array([1, 3, 5])
    return {"omega": omega, "error": np.max(np.abs(printed / omega - 1))}


def quadrature() -> tuple[Array, Array]:
    """Return places and weights over the beam, 0 to 1."""
    x, weight = legendre.leggauss(64)
    return (1 + x) / 2, weight / 2


def orthogonality(session: Session) -> Numbers:
    """Return the largest integral between two of four modes of the beam, over that of one."""
    x, weight = quadrature()
    parts = gram(rest_modes(x, 4)[0], weight)
    return {"error": np.max(np.abs(parts - np.diag(np.diag(parts)))) / np.max(np.diag(parts))}


def foreshortening(session: Session) -> Numbers:
    """Return the relative errors of u_f at the free end for deflections of 1 and 10 % of L."""
    x, weight = quadrature()
    value, slope, _ = rest_modes(np.append(x, 1.0), 1)
    bends = np.array([[0.01], [0.1]]) * slope[0, :-1] / value[0, -1]  # x is the arc length
    errors = -(bends**2 @ weight) / 2 / ((np.sqrt(1 - bends**2) - 1) @ weight) - 1
    return {"errors": errors, "order": np.log10(errors[1] / errors[0])}


def pull_of_hub(session: Session) -> Numbers:
    """Return the first frequency by (18), with the D_1 of that equation, and the converged one."""
    own, exact = first_frequency(numbers(BEAM), MODES), first_frequency(numbers(BEAM))
    return {"own": own, "exact": exact, "error": abs(own / exact - 1)}


def bending_stiffness(session: Session) -> Numbers:
    """Return the first frequency of (21), dimensionless, without and with K_2, and its errors.

    With 0.4 kg in the middle at 7 rad/s. As printed it is that of a string, converged; with K_2 it
    is that of `MODES` assumed modes, which is compared with the converged one.
    """
    n = numbers(BEAM.replace(mass=0.4, mass_position=0.5))
    exact, own, string = first_frequency(n), assumed_modes(n, MODES)[0], string_frequency(n)
    return {
        "string": string,
        "own": own,
        "exact": exact,
        "corrected": abs(own / exact - 1),
        "as_printed": abs(string / exact - 1),
    }


def string_frequency(n: BeamNumbers, degree: int = 12) -> float:
    """Return the first frequency, dimensionless, of a beam without bending stiffness.

    Its slopes are polynomials from the clamp to the mass, and others from there to the tip.
    """
    x, weight = places(np.array([0.0, n.beta, 1.0]), *legendre.leggauss(2 * degree))
    at, slopes, values = np.append(x, n.beta), [], []
    for start, end in ((0.0, n.beta), (n.beta, 1.0)):
        local = np.clip(2 * (at - start) / (end - start) - 1, -1, 1)
        inside = (start < at) & (at < end)
        slopes += list(legendre.legvander(local, degree).T * inside)
        integrals = legendre.legint(np.eye(degree + 1), lbnd=-1)
        values += list((end - start) / 2 * legendre.legval(local, integrals))
    slope, value = np.array(slopes), np.array(values)
    mass = gram(value, np.append(weight, n.alpha))
    pull = gram(slope[:, :-1], weight * tension(n, x))
    return float(n.gamma * np.sqrt(eigh(pull, mass, eigvals_only=True)[0] - 1))


def extension(session: Session) -> Numbers:
    """Compare a beam that stretches much with one that does not.

    The extension parameter, and the changes of the first frequency by stretch and Coriolis force.
    """
    n, rows = BeamNumbers(0.0, 5.0), []
    for slenderness in (100.0, BEAM.area * BEAM.length**2 / BEAM.second_moment):
        flapwise = stretching(n, slenderness, "flapwise", 1).omega[0]
        chordwise = stretching(n, slenderness, count=1).omega[0]
        stretch = flapwise / ritz(n, "flapwise", 1).omega[0] - 1
        coriolis = chordwise / np.sqrt(flapwise**2 - n.gamma**2) - 1
        rows.append((n.gamma / np.sqrt(slenderness), stretch, coriolis))
    (large, much, with_coriolis), (small, little, _) = rows
    return {
        "large": large,
        "much": much,
        "with_coriolis": with_coriolis,
        "small": small,
        "little": little,
        "least": min(abs(much), abs(with_coriolis)),
        "most": abs(little),
    }


# Section 3.1: frequencies -------------------------------------------------------------------------


THRESHOLD = 0.67
"""Printed place at which the curves of figure 3 cross."""


def slenderness(session: Session, who: str) -> Numbers:
    """Return the relative decrease of the first frequency by stretching, most mass at the tip.

    For the reference also the first axial frequency over that of bending at rest.
    """
    p, numbers = BEAM.replace(mass=LOADS[-1]), {}
    if who == REFERENCE:
        soft = frequencies(p, count=1, continuum="extensible").omega[0]
        bending = frequencies(BEAM.replace(angular_speed=0.0), count=1).omega[0]
        numbers["ratio"] = FIRST_AXIAL / bending
    else:
        soft = by_place(session, who).variables["frequency_1"][-1, -1]
    return {**numbers, "gap": 1 - float(soft) / float(frequencies(p, count=1).omega[0])}


def curves_of_figure_2(session: Session, who: str) -> Numbers:
    """Return properties of the curves of figure 2, over speed and over mass ratio.

    ``falls``: more mass at the tip lowers all frequencies; their means by mass, and differences at
    one speed. ``convex``: they are convex functions of the mass ratio at all speeds.
    """
    over_speed, over_ratio = (
        read(session, who).variables[FIRST_VARIABLE] for read in (by_speed, by_ratio)
    )
    return {
        "falls": np.all(np.diff(over_speed, axis=0) < 0),
        "means": np.mean(over_speed, axis=1) / np.mean(over_speed[0]),
        "drops": -np.diff(over_speed[:, 14]),
        "convex": np.all(np.diff(over_ratio, 2, axis=1) > 0),
    }


# Where curves cross, and their maxima


def crossings(speed: float, modes: int | None = None) -> list[float]:
    """Return the place where each mass crosses the beam without mass at a speed [rad/s]."""
    return [crossover(loaded(mass, speed), modes=modes) for mass in LOADS]


def best(speed: float, modes: int | None = None) -> list[float]:
    """Return the best place of each mass at a speed [rad/s]."""
    return [best_mass_position(loaded(mass, speed), modes) for mass in LOADS]


def crossover_of_0_4(session: Session, who: str) -> float:
    """Return where the curve of 0.4 kg crosses that without mass."""
    if who == REFERENCE:
        return crossover(loaded(LOADS[0]))
    place, curves = curves_of_figure_3(session, who)
    return float(CubicSpline(place, curves[1] - curves[0]).roots(extrapolate=False)[-1])


def crossovers(session: Session, fast: float, fastest: float) -> Numbers:
    """Return the crossovers by mass, converged and of two modes, and the speed of that at 0.67.

    Those of two modes, and their maxima, at the speed too that gives the printed maximum of 0.4 kg.

    Parameters
    ----------
    fast, fastest : float
        Speeds [rad/s] at which the first crossing, and the last, are at the threshold.
    """
    speed = matched(session, LOADS[0])
    faster = crossings(speed, 2)

    def beyond(w: float) -> float:
        return crossover(loaded(LOADS[0], w)) - THRESHOLD

    return {
        "matched": speed,
        "two_faster": faster,
        "two_first": faster[0],
        "two_maxima": best(speed, 2),
        "converged": crossings(SPEED),
        "two": crossings(SPEED, 2),
        "speed": session.once((SCENE.name, "speed"), lambda: brentq(beyond, 5, 40, rtol=1e-4)),
        "fast": crossings(fast),
        "fastest_first": crossover(loaded(LOADS[0], fastest)),
    }


def crossings_inside(session: Session, fast: float, fastest: float) -> Numbers:
    """Return where masses cross each other, and 0.4 kg the beam without mass, by circumstance."""
    places = {
        "slowly": crossover(loaded(LOADS[0], 4.0)),
        "still": crossover(loaded(LOADS[0], 0.0)._replace(delta=1)),
        "no_hub": crossover(loaded(LOADS[0])._replace(delta=0)),
        "two": crossover(loaded(LOADS[0]), modes=2),
    }
    last = {
        name: min(crossover(loaded(b, w), loaded(a, w).alpha) for a, b in pairwise(LOADS))
        for name, w in (("last", SPEED), ("fast", fast), ("fastest", fastest))
    }
    return last | {name: crossed(place) for name, place in places.items()}


def place_of_maximum(session: Session, who: str, mass: float) -> float:
    """Return where a mass makes the first frequency largest, at the speed of figure 3."""
    if who == REFERENCE:
        return best_mass_position(loaded(mass))
    place, curves = curves_of_figure_3(session, who)
    return maximum(place, curves[MASSES.index(mass)])


def best_place(session: Session, who: str, mass: float) -> Numbers:
    """Return the best place of a mass; for the reference also other best places and speeds.

    The best place at any speed and that speed; the best place of two modes, and the speed at which
    they have the printed one. Speeds are in rad/s.
    """
    value = {"value": place_of_maximum(session, who, mass)}
    if who != REFERENCE:
        return value
    top, at = furthest(session, mass)
    two = best_mass_position(loaded(mass), 2)
    off = abs(two - PRINTED_MAXIMA[mass])
    others = {"top": top, "at": at, "matched": matched(session, mass), "two": two, "two_off": off}
    return value | others


def best_places(session: Session, who: str) -> Numbers:
    """Return the best places by mass, and their least distance from 0.42."""
    places = np.array([place_of_maximum(session, who, mass) for mass in LOADS])
    return {"places": places, "outward": np.diff(places), "gap": np.min(np.abs(places - 0.42))}


def best_places_otherwise(session: Session) -> Numbers:
    """Return the best places of two assumed modes by mass, and their least distance from 0.42.

    And the outermost without rotation, and the best places at any speed by mass.
    """
    two = np.array(best(SPEED, 2))
    return {
        "two": two,
        "two_outward": np.diff(two),
        "two_gap": np.min(np.abs(two - 0.42)),
        "still": max(best(0.0)),
        "tops": [furthest(session, mass)[0] for mass in LOADS],
    }


def curves(session: Session, who: str) -> Numbers:
    """Return properties of the curves of figure 3.

    ``holds``: each with a mass rises first, and turns once; its largest less smallest frequency.
    ``falls``: more mass lowers the frequency at all places beyond the threshold. And the innermost
    place inside at which more mass does not raise it, in words too.
    """
    place, frequency = curves_of_figure_3(session, who)
    outward, by_load = np.diff(frequency[1:], axis=1), np.diff(frequency, axis=0)
    turns = np.count_nonzero(np.diff(np.sign(outward)), axis=1)
    spans = np.ptp(frequency[1:], axis=1)
    wrong = place[(place < THRESHOLD) & np.any(by_load <= 0, axis=0)]
    innermost = float(np.min(wrong, initial=np.inf))
    return {
        "holds": np.all(outward[:, 0] > 0) and np.all(turns == 1),
        "ranges": spans,
        "growth": np.diff(spans),
        "falls": np.all(by_load[:, place > THRESHOLD] < 0),
        "words": f"not at beta = {innermost:.3f}" if np.isfinite(innermost) else "yes",
    }


# Readings


def maxima_at_speeds(session: Session, speeds: Sequence[float]) -> Numbers:
    """Return the best places and the crossover of 0.4 kg, of two modes and converged, by speed.

    At these speeds [rad/s], and at those, ``matched``, that give two modes the printed maxima.
    """
    own = [matched(session, mass) for mass in LOADS]
    every = sorted([*speeds, own[0], own[-1]])
    return {
        "matched": own,
        "two": [best(speed, 2) for speed in every],
        "converged": [best(speed) for speed in every],
        "two_crossings": [crossover(loaded(LOADS[0], speed), modes=2) for speed in every],
        "crossings": [crossover(loaded(LOADS[0], speed)) for speed in every],
    }


def maxima_of_modes(session: Session, most: int) -> Numbers:
    """Return the best places by number of assumed modes, the last converged, and their errors.

    Each number of modes at the speed [rad/s] at which they come nearest to the printed places; the
    crossings there; and the larger error of one and two modes, ``within``.
    """

    def error(speed: float, modes: int | None) -> float:
        return float(np.max(np.abs(np.subtract(best(speed, modes), list(PRINTED_MAXIMA.values())))))

    numbers = (*range(1, most + 1), None)
    options = {"xatol": 1e-3}
    minima = [minimize_scalar(error, args=(n,), bounds=(4, 9), options=options) for n in numbers]
    speeds, off = [float(one.x) for one in minima], [float(one.fun) for one in minima]
    return {
        "speeds": speeds,
        "off": off,
        "within": max(off[:2]),
        "places": list(map(best, speeds, numbers)),
        "crossings": list(map(crossings, speeds, numbers)),
    }


# Section 3.2: responses ---------------------------------------------------------------------------


Measure = Callable[[Response, RotatingBeam], float]


def driven(values: Values) -> Values:
    """Return the scene's drives (22), as an acceleration, and (23) at a time share T/2, and 2 T."""
    end, at = values["T"], np.array([values["share"] / 2, 2.0]) * values["T"]
    ramp = FIGURE_4.replace(angular_speed=values.get("omega_0", 1.0), ramp_time=end)
    pulse = FIGURE_5.replace(torque_amplitude=values.get("tau_0", 1.0), torque_period=end)
    accelerations, torques = (drive(at, coefficients(p)) for p in (ramp, pulse))
    return {
        "acceleration": float(accelerations[0]),
        "torque": float(torques[0]),
        "after": float(np.max(np.abs([accelerations[1], torques[1]]))),
    }


def by_mass(session: Session, who: str, figure: int, of: Measure) -> Array:
    """Return a measure of the motions of figure 4 or 5, by mass."""
    return np.array(
        [of(response(session, figure, who, mass), beam_of(figure, mass)) for mass in MASSES]
    )


def against_none(session: Session, who: str, figure: int, of: Measure) -> Numbers:
    """Return a measure by mass, its ratios to that without mass, and how it grows."""
    values = by_mass(session, who, figure, of)
    shares = values[1:] / values[0]
    return {
        "values": values,
        "changes": np.diff(values),
        "shares": shares,
        "least": np.min(shares),
        "most": np.max(shares),
        "steadily": "monotonically" if np.all(np.diff(values) > 0) else "not monotonically",
    }


def angle_after_pulse(motion: Response, p: RotatingBeam, name: str = "tip_angle") -> float:
    """Return an angle when the pulse ends [rad]: that of the free end, or ``theta`` of the hub."""
    return float(motion.values[name][motion.times == p.torque_period][0])


def order_of_angles(session: Session) -> Numbers:
    """Return the time [s] from which on the angle falls with the mass, and its size then.

    The latter in percent of the angle after the pulse.
    """
    motions = [response(session, 5, REFERENCE, mass) for mass in MASSES]
    paths, times = np.array([motion.values["tip_angle"] for motion in motions]), motions[0].times
    wrong = np.any(np.diff(paths, axis=0) >= 0, axis=0) & (times <= FIGURE_5.torque_period)
    start = float(times[wrong][-1])
    little = np.max(paths[:, times == start]) / angle_after_pulse(motions[0], FIGURE_5)
    return {"start": start, "little": 100 * little}


def amplitude_ratio(motion: Response, p: RotatingBeam) -> float:
    """Return the amplitude of the second half of the free vibration over that of the first."""
    first, second = np.array_split(np.abs(free(motion, p)), 2)
    return float(np.max(second)) / float(np.max(first))


def decay(session: Session, who: str) -> Numbers:
    """Return that ratio after the pulse by mass, how far it is from 1, and amplitudes [m]."""
    ratios = by_mass(session, who, 5, amplitude_ratio)
    amplitudes = by_mass(session, who, 5, free_amplitude)
    return {"ratios": ratios, "off": np.abs(ratios - 1), "amplitudes": amplitudes}


def energy_change(motion: Response, p: RotatingBeam) -> float:
    """Return the largest change of the energy after the pulse, over its largest value."""
    energy = motion.values["energy"]
    return float(np.ptp(energy[motion.times >= p.torque_period]) / np.max(energy))


def energy_drift(session: Session) -> Numbers:
    """Return that change, the largest of all masses, and amplitudes as `against_none` has them."""
    drift = np.max(by_mass(session, REFERENCE, 5, energy_change))
    return {"drift": drift, **against_none(session, REFERENCE, 5, free_amplitude)}


# The pulse, linear about rest


def linear_pulse(p: RotatingBeam, times: Array, scene: Scene = SCENE) -> Response:
    """Return the motion under the pulse (23), linear about rest: mode by mode, in closed form."""
    size = len(scene.coordinates)
    mass, _, stiffness = linearise(scene, p.replace(drive="torque"), np.zeros(2 * size))
    squares, shapes = eigh(stiffness, mass)
    end, w = p.torque_period, 2 * np.pi / p.torque_period
    during, after = np.minimum(times, end), np.maximum(times - end, 0.0)
    q, v = np.zeros((2, size, len(times)))
    for square, shape in zip(squares, shapes.T, strict=True):
        omega = np.sqrt(max(square, 0.0))
        if omega < 1e-3 * w:  # the hub turns freely
            at = during / w - np.sin(w * during) / w**2
            rate = (1 - np.cos(w * during)) / w
        else:
            gain = 1 / (omega**2 - w**2)
            at = gain * (np.sin(w * during) - w / omega * np.sin(omega * during))
            rate = gain * w * (np.cos(w * during) - np.cos(omega * during))
        cos, sin, lag = np.cos(omega * after), np.sin(omega * after), np.sinc(omega / np.pi * after)
        push = shape[0] * p.torque_amplitude
        q += push * np.outer(shape, at * cos + rate * after * lag)
        v += push * np.outer(shape, rate * cos - omega * at * sin)
    return Response(times, with_angle(scene.observe(np.concatenate([q, v]), p), p))


def pulses(
    session: Session, hub_inertias: Sequence[float] = (10.0,), hub_radii: Sequence[float] = (0.0,)
) -> Numbers:
    """Return the results of figure 5 for several hubs, by hub and mass, linear about rest.

    The hub's angle after the pulse [rad], the largest deflection [m], its increase over that
    without mass [percent], and the largest deflection after the pulse [m].
    """
    times = np.linspace(0.0, 20.0, 641)
    angle, largest, left = np.zeros((3, len(hub_inertias) * len(hub_radii), len(MASSES)))
    hubs = [(inertia, radius) for inertia in hub_inertias for radius in hub_radii]
    for i, (inertia, radius) in enumerate(hubs):
        for j, mass in enumerate(MASSES):
            p = FIGURE_5.replace(hub_inertia=inertia, hub_radius=radius, mass=mass)
            motion = linear_pulse(p, times)
            angle[i, j], largest[i, j] = angle_after_pulse(motion, p, "theta"), peak(motion, p)
            left[i, j] = free_amplitude(motion, p)
    growth = 100 * (largest[:, 1:] / largest[:, :1] - 1)
    most = np.max(growth, axis=1)
    return {
        "angle": angle,
        "largest": largest,
        "left": left,
        "growth": growth,
        "least_most": np.min(most),
        "most_most": np.max(most),
    }


# Readings


def peaks_by_mass(session: Session) -> Numbers:
    """Return the largest deflections [m] of figures 4 and 5, by mass."""
    return {f"figure_{figure}": by_mass(session, REFERENCE, figure, peak) for figure in (4, 5)}


def angles_by_mass(session: Session) -> Numbers:
    """Return the angles [rad] of the hub and of the free end after the pulse, by mass."""
    hub, free_end = (
        by_mass(session, REFERENCE, 5, partial(angle_after_pulse, name=name))
        for name in ("theta", "tip_angle")
    )
    return {"hub": hub, "free_end": free_end}


def models_of_figure_4(session: Session) -> Numbers:
    """Return the largest deflections [m] of figure 4 with the least and the largest load.

    By the exact equations, and by (14) to (16) corrected, converged and with two modes; by how
    many percent the converged ones overshoot; the speed [rad/s] above which the beam diverges
    without the second-order coupling.
    """
    times, loads = np.arange(8 * SAMPLES + 1) / SAMPLES, (LOADS[0], LOADS[-1])
    scenes = {
        "exact": SCENE,
        "converged": beam_scene("second_order", 8, 0),
        "two_modes": beam_scene("second_order", 2, 1, cantilever_modes),
    }
    peaks: dict[str, list[float]] = {}
    for name, scene in scenes.items():
        for p in (beam_of(4, mass) for mass in loads):
            values = scene.observe(states_at(scene, p, scene.state({}), times), p)
            peaks.setdefault(name, []).append(peak(Response(times, values), p))
    over = 100 * (np.array(peaks["converged"]) / peaks["exact"] - 1)
    return {**peaks, "over": over, "critical": critical_speed(beam_of(4, loads[0]))}


def damped_shares(session: Session, ratios: Sequence[float]) -> Numbers:
    """Return the shares of the amplitude that damping ratios leave in 10 s, with 0.4 kg.

    And the frequency of the first mode with a free hub [rad/s].
    """
    p = FIGURE_5.replace(mass=LOADS[0])
    mass, _, stiffness = linearise(SCENE, p, np.zeros(2 * len(SCENE.coordinates)))
    omega = float(np.sqrt(eigh(stiffness, mass, eigvals_only=True)[1]))
    return {"omega": omega, "shares": np.exp(-np.array(ratios) * omega * 10)}


def hub_radii(session: Session, radii: Sequence[float]) -> Numbers:
    """Return `pulses` by hub radius [m], and the place where 0.4 kg cross the beam without mass.

    In words, of two modes and converged, with the best places; without a crossing there are none.
    """
    words: dict[str, list[str]] = {"two": [], "two_best": [], "converged": [], "best": []}
    for radius in radii:
        n = [numbers(BEAM.replace(hub_radius=radius, mass=mass)) for mass in LOADS]
        for name, own, modes in (("two", "two_best", 2), ("converged", "best", None)):
            place = crossover(n[0], modes=modes)
            words[name].append(crossed(place))
            best = [best_mass_position(one, modes) for one in n] if np.isfinite(place) else []
            words[own].append(", ".join(f"{one:.3g}" for one in best) or "none")
    return {**words, **pulses(session, hub_radii=radii)}
