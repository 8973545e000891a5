"""Measures of the rotating_beam paper, and the frequencies and runs that the figures share.

The paper's equations themselves are texts in ``claims.toml``. It names neither the speed of figures
2 and 3 nor the masses of figures 4 and 5; the masses here are those of its section 3.1 and none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
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
from ....reference.rotating_beam.frequencies.ritz import (
    at_mass,
    basis,
    element_ends,
    gauss,
    gram,
    ritz,
)
from ....reference.rotating_beam.frequencies.ritz import places as gauss_points
from ....reference.rotating_beam.frequencies.stretching import stretching
from ....reference.rotating_beam.parameters import RotatingBeam, coefficients, drive, drive_end_time
from ....reference.rotating_beam.shapes import cantilever_modes
from ....reference.scene import Array, Scene
from ....reference.solve.single import states_at
from ...engines.registry import REFERENCE
from ...maps.execute import on_this_machine
from ...maps.store import Map
from ...queries.frequencies import frequencies
from ...queries.simulate import simulate
from ..equations import Values
from ..ledger import Numbers
from ..session import Session, once

MASSES = (0.0, 0.4, 0.8, 1.2)
"""Masses [kg]: none, and those of section 3.1."""

SPEED = 7.0
"""Speed of figure 3 [rad/s], at which two assumed modes have the printed maximum for 0.8 kg."""

MASS_AXIS = ("mass", MASSES[0], MASSES[-1], len(MASSES))

BEAM = RotatingBeam(hub_radius=8.0, angular_speed=SPEED, ramp_time=0.0)
"""Beam of section 3.1, of figures 2 and 3."""

PRINTED_MAXIMA = {0.4: 0.442, 0.8: 0.429, 1.2: 0.42}


def segments(session: Session, least: int = 16) -> int:
    """Return the number of an engine's rods or elements, 32 with ``--full``."""
    return 32 if session.full else least


def frequency_map(
    session: Session, x: Any, y: Any, engine: str, model: str | None = None, **changes: float
) -> Map:
    """Return a map of frequencies of the beam of figures 2 and 3, with changed parameters."""
    parameters = {"hub_radius": BEAM.hub_radius, "segments": float(segments(session)), **changes}
    settings = {"engine": engine, "model": model, "parameters": parameters}
    return session.map(SCENE.name, "frequency", x, y, **settings)


def by_speed(session: Session, engine: str = REFERENCE) -> Map:
    """Return frequencies over speed (columns) and mass at the tip (rows, `MASSES`)."""
    x = ("nondimensional_speed", 0.0, 12.0, 49 if session.full else 25)
    return frequency_map(session, x, MASS_AXIS, engine)


def by_ratio(session: Session, engine: str = REFERENCE) -> Map:
    """Return frequencies over mass ratio at the tip (columns) and speed (rows)."""
    x = ("mass_ratio", 0.0, 2.0, 41 if session.full else 17)
    return frequency_map(session, x, ("nondimensional_speed", 0.0, 12.0, 4), engine)


def by_place(session: Session, engine: str = REFERENCE, model: str | None = None) -> Map:
    """Return frequencies over the mass's place (columns) and mass (rows), at `SPEED`.

    Places are ends of rods: there alone a chain converges with order 2.
    """
    places = (4 if engine == REFERENCE else 1) * segments(session)
    x = ("mass_position", 1 / places, 1.0, places)
    return frequency_map(session, x, MASS_AXIS, engine, model, angular_speed=SPEED)


def maximum(place: Array, frequency: Array) -> float:
    """Return where a smooth curve through points inside (0, 1] is largest."""
    spline = CubicSpline(place, frequency)
    at = np.append(spline.derivative().roots(extrapolate=False), place[[0, -1]])
    return float(at[np.argmax(spline(at))])


# Runs ---------------------------------------------------------------------------------------------


class Response(NamedTuple):
    """A motion of a beam: times [s], 0 included, and observables by name."""

    beam: RotatingBeam
    times: Array
    values: Mapping[str, Array]


CASES = {4: FIGURE_4, 5: FIGURE_5}
HORIZONS = {4: 20.0, 5: 16.0}
"""Durations of the runs [s]; the text names none."""

SAMPLES = 16
"""Samples of a run per second."""


def observed(p: RotatingBeam, times: Array, values: Mapping[str, Array]) -> Response:
    """Return observables with the angle of the free end about the hub's axis [rad]."""
    along = p.hub_radius + p.length + values["tip_axial"]
    angle = values["theta"] + np.arctan2(values["tip_deflection"], along)
    return Response(p, times, {**values, "tip_angle": angle})


def solved(scene: Scene, p: RotatingBeam, times: Array) -> Response:
    """Return a motion by the equations of a scene, with its energy [J]."""
    states = states_at(scene, p, scene.state({}), times)
    energy = scene.energy(*np.split(states, 2), scene.coefficients(p))
    return observed(p, times, {**scene.observe(states, p), "energy": energy})


def simulate_beam(p: RotatingBeam, who: str, horizon: float) -> Response | str:
    """Return a motion by the reference or an engine, or the reason why the engine has none."""
    times = np.arange(round(horizon * SAMPLES) + 1) / SAMPLES
    if who == REFERENCE:
        return solved(SCENE, p, times)
    try:
        motion = simulate(SCENE.name, engine=who, parameters=p.as_dict(), times=times)
    except EngineError as error:
        return f"failed: {error}"
    return observed(p, times, motion.observables)


@once
def runs(session: Session, figure: int, who: str) -> dict[float, Response | str]:
    """Return the motions of figure 4 or 5 by the reference or an engine, by mass."""
    count = segments(session, 24 if figure == 4 else 16)
    horizon = HORIZONS[figure] * (2 if session.full else 1)
    beams = [CASES[figure].replace(mass=mass, segments=count) for mass in MASSES]
    run = partial(simulate_beam, who=who, horizon=horizon)
    report, motions = session.follow(f"runs of figure {figure} {who}"), {}
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


def crossed(place: float) -> str:
    """Return the place where a mass has no effect, or ``nowhere``."""
    return f"{place:.3f}" if np.isfinite(place) else "nowhere"


def peak(motion: Response) -> float:
    """Return the largest deflection [m], whatever its sign."""
    return abs(run_quantities(motion.times, motion.values, motion.beam)["tip_peak"][0])


def properties(motion: Response) -> dict[str, float]:
    """Return properties of a motion; all but the first two are of the time when nothing drives it.

    ``peak``, the largest deflection [m], and ``top_speed``, the largest velocity of the tip in the
    hub frame [m/s], both of any sign. Angles [rad] of free end and hub as the drive ends,
    ``free_end`` and ``hub``; the ``amplitude`` of the deflection [m], and that of the second half
    over that of the first; the change of the energy over its largest value.
    """
    times, values = motion.times, motion.values
    free = {name: value[times >= drive_end_time(motion.beam)] for name, value in values.items()}
    deflection = np.abs(free["tip_deflection"])
    first, second = np.array_split(deflection, 2)
    numbers = {
        "peak": peak(motion),
        "top_speed": np.max(np.abs(values["tip_deflection_dot"])),
        "free_end": free["tip_angle"][0],
        "hub": free["theta"][0],
        "amplitude": np.max(deflection),
        "ratio": np.max(second) / np.max(first),
        "drift": np.ptp(free["energy"]) / np.max(values["energy"]) if "energy" in free else np.nan,
    }
    return {name: float(number) for name, number in numbers.items()}


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
    """Return beta_i L of the cantilever at rest, by its frequency."""
    at_rest = {"angular_speed": 0.0, "segments": segments(session)}
    modes = frequencies(SCENE.name, engine=who, parameters=at_rest, count=i).modes
    return float(np.sqrt(modes[-1].omega * UNIT))


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


QUADRATURE = gauss_points(np.array([0.0, 1.0]), *gauss(56))
"""Places on the beam, 0 to 1, and weights of an integral over it."""


def orthogonality(session: Session) -> Numbers:
    """Return the largest integral between two of four modes of the beam, over that of one."""
    x, weight = QUADRATURE
    parts = gram(rest_modes(x, 4)[0], weight)
    return {"error": np.max(np.abs(parts - np.diag(np.diag(parts)))) / np.max(np.diag(parts))}


def foreshortening(session: Session) -> Numbers:
    """Return the relative errors of u_f at the free end for deflections of 1 and 10 % of L."""
    x, weight = QUADRATURE
    value, slope, _ = rest_modes(np.append(x, 1.0), 1)
    bends = np.array([[0.01], [0.1]]) * slope[0, :-1] / value[0, -1]  # x is the arc length
    errors = -(bends**2 @ weight) / 2 / ((np.sqrt(1 - bends**2) - 1) @ weight) - 1
    return {"errors": errors, "order": np.log10(errors[1] / errors[0])}


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
    """Return the first frequency, dimensionless, of a beam without bending stiffness."""
    ends = element_ends(n)
    at, of_mass = basis(ends, degree, *gauss(degree), times=1), at_mass(n, ends, degree, times=1)
    pull = gram(at.slope, at.weight * tension(n, at.x))
    mass = gram(at.value, at.weight) + np.outer(of_mass, of_mass)
    return float(n.gamma * np.sqrt(eigh(pull, mass, eigvals_only=True)[0] - 1))


def extension(session: Session) -> Numbers:
    """Return extension parameters of a beam that stretches much and of this one, at gamma = 5.

    And the changes of the first frequency by stretch and by the Coriolis force.
    """
    n, this = BeamNumbers(gamma=5.0), BEAM.area * BEAM.length**2 / BEAM.second_moment
    flapwise, chordwise = (
        np.array([stretching(n, slenderness, plane, 1).omega[0] for slenderness in (100.0, this)])
        for plane in ("flapwise", "chordwise")
    )
    stretch = flapwise / ritz(n, "flapwise", 1).omega[0] - 1
    coriolis = chordwise / np.sqrt(flapwise**2 - n.gamma**2) - 1
    return {
        "large": n.gamma / np.sqrt(100.0),
        "much": stretch[0],
        "with_coriolis": coriolis[0],
        "small": n.gamma / np.sqrt(this),
        "little": stretch[1],
        "least": min(abs(stretch[0]), abs(coriolis[0])),
        "most": abs(stretch[1]),
    }


# Section 3.1: frequencies -------------------------------------------------------------------------


THRESHOLD = 0.67
"""Printed place at which the curves of figure 3 cross."""


def softening(session: Session, who: str) -> Numbers:
    """Return the relative decrease of the first frequency by stretching, most mass at the tip."""
    p = BEAM.replace(mass=LOADS[-1], segments=segments(session))
    model = "extensible" if who == REFERENCE else None
    soft = frequencies(SCENE.name, engine=who, model=model, parameters=p.as_dict(), count=1)
    return {"gap": 1 - soft.modes[0].omega * UNIT / first_frequency(numbers(p))}


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


def crossovers(session: Session, fast: float, fastest: float) -> Numbers:
    """Return the crossovers by mass, converged and of two modes, and the speed of that at 0.67.

    Those of two modes, and their maxima, at the speed too that gives the printed maximum of 0.4 kg.
    ``fast`` and ``fastest`` are more speeds [rad/s].
    """
    speed = best_place(session, LOADS[0])["matched"]
    faster = crossings(speed, 2)

    def effect(speed: float) -> float:
        n = loaded(LOADS[0], speed)._replace(beta=THRESHOLD)
        return first_frequency(n) - first_frequency(n._replace(alpha=0.0))

    return {
        "matched": speed,
        "two_faster": faster,
        "two_first": faster[0],
        "two_maxima": best(speed, 2),
        "converged": crossings(SPEED),
        "two": crossings(SPEED, 2),
        "speed": brentq(effect, 5, 40),
        "fast": crossings(fast),
        "fastest_first": crossover(loaded(LOADS[0], fastest)),
    }


def crossings_inside(session: Session, fast: float, fastest: float) -> Numbers:
    """Return where masses cross each other, and 0.4 kg the beam without mass, by circumstance."""
    own = loaded(LOADS[0])
    places = {
        "slowly": crossover(loaded(LOADS[0], 4.0)),
        "still": crossover(own._replace(gamma=0.0)),
        "no_hub": crossover(own._replace(delta=0.0)),
        "two": crossover(own, modes=2),
    }
    last = {
        name: min(crossover(loaded(b, w), loaded(a, w).alpha) for a, b in pairwise(LOADS))
        for name, w in (("last", SPEED), ("fast", fast), ("fastest", fastest))
    }
    return last | {name: crossed(place) for name, place in places.items()}


@once
def best_place(session: Session, mass: float) -> Numbers:
    """Return other best places of a mass, and their speeds [rad/s].

    The best place at any speed and that speed; the best place of two modes, and the speed at which
    they have the printed one.
    """
    farthest = minimize_scalar(
        lambda w: -best_mass_position(loaded(mass, w)), bounds=(4, 15), options={"xatol": 0.2}
    )
    two, printed = best_mass_position(loaded(mass), 2), PRINTED_MAXIMA[mass]
    return {
        "top": -float(farthest.fun),
        "at": float(farthest.x),
        "matched": matching_speed(loaded(mass), printed, 2) / UNIT,
        "two": two,
        "two_off": abs(two - printed),
    }


@once
def best_places(session: Session, who: str) -> Numbers:
    """Return the best places by mass, and their least distance from 0.42.

    And the place where 0.4 kg cross the beam without mass; all at the speed of figure 3.
    """
    if who == REFERENCE:
        crossing, places = crossover(loaded(LOADS[0])), np.array(best(SPEED))
    else:
        place, curves = curves_of_figure_3(session, who)
        crossing = CubicSpline(place, curves[1] - curves[0]).roots(extrapolate=False)[-1]
        places = np.array([maximum(place, curve) for curve in curves[1:]])
    gap = np.min(np.abs(places - 0.42))
    return {"places": places, "outward": np.diff(places), "gap": gap, "crossing": float(crossing)}


def place_in_figure_3(session: Session, who: str, mass: float | None = None) -> float:
    """Return the best place of a mass, or the crossing of 0.4 kg."""
    features = best_places(session, who)
    return float(features["crossing"] if mass is None else features["places"][LOADS.index(mass)])


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
        "tops": [best_place(session, mass)["top"] for mass in LOADS],
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
    own = [best_place(session, mass)["matched"] for mass in LOADS]
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


def by_mass(session: Session, who: str, figure: int) -> dict[str, Array]:
    """Return the properties of the motions of figure 4 or 5, by mass."""
    every = [properties(response(session, figure, who, mass)) for mass in MASSES]
    return {name: np.array([one[name] for one in every]) for name in every[0]}


def against_none(session: Session, who: str, figure: int, of: str) -> Numbers:
    """Return a property by mass, its ratios to that without mass, and how it grows."""
    values = by_mass(session, who, figure)[of]
    shares = values[1:] / values[0]
    return {
        "values": values,
        "changes": np.diff(values),
        "shares": shares,
        "least": np.min(shares),
        "most": np.max(shares),
        "steadily": "monotonically" if np.all(np.diff(values) > 0) else "not monotonically",
    }


def order_of_angles(session: Session) -> Numbers:
    """Return the time [s] from which on the angle falls with the mass, and its size then.

    The latter in percent of the angle after the pulse.
    """
    motions = [response(session, 5, REFERENCE, mass) for mass in MASSES]
    paths, times = np.array([motion.values["tip_angle"] for motion in motions]), motions[0].times
    wrong = np.any(np.diff(paths, axis=0) >= 0, axis=0) & (times <= FIGURE_5.torque_period)
    last = np.flatnonzero(wrong)[-1]
    little = np.max(paths[:, last]) / properties(motions[0])["free_end"]
    return {"start": float(times[last]), "little": 100 * little}


def decay(session: Session, who: str) -> Numbers:
    """Return amplitudes [m] after the pulse by mass, those of the second half over the first's.

    And the distances of these ratios from 1; the largest change of the energy over its maximum.
    """
    properties_by_mass = by_mass(session, who, 5)
    ratios = properties_by_mass["ratio"]
    return {
        "ratios": ratios,
        "off": np.abs(ratios - 1),
        "amplitudes": properties_by_mass["amplitude"],
        "drift": np.max(properties_by_mass["drift"]),
    }


# The pulse, linear about rest


def linear_pulse(p: RotatingBeam, times: Array, scene: Scene = SCENE) -> Response:
    """Return the motion under the pulse (23), linear about rest: mode by mode, in closed form."""
    mass, _, stiffness = linearise(scene, p, np.zeros(2 * len(scene.coordinates)))
    squares, shapes = eigh(stiffness, mass)
    end, w = p.torque_period, 2 * np.pi / p.torque_period
    squares = np.where(squares > 1e-6 * w**2, squares, 0.0)[:, None]  # the hub turns freely
    omega = np.sqrt(squares)
    during, after = np.minimum(times, end), np.maximum(times - end, 0.0)
    push = p.torque_amplitude * shapes[0][:, None] / (squares - w**2)
    at = push * (np.sin(w * during) - w * during * np.sinc(omega * during / np.pi))
    rate = push * w * (np.cos(w * during) - np.cos(omega * during))
    cos, lag = np.cos(omega * after), after * np.sinc(omega * after / np.pi)
    states = shapes @ (at * cos + rate * lag), shapes @ (rate * cos - squares * at * lag)
    return observed(p, times, scene.observe(np.concatenate(states), p))


def pulses(session: Session, **hubs: Sequence[float]) -> Numbers:
    """Return the results of figure 5 by a parameter of the hub and mass, linear about rest.

    The hub's angle after the pulse [rad], the largest deflection [m], its increase over that
    without mass [percent], and the largest deflection after the pulse [m].
    """
    times = np.linspace(0.0, 20.0, 641)
    sets = [{name: one} for name, values in hubs.items() for one in values]
    results = [
        [properties(linear_pulse(FIGURE_5.replace(mass=mass, **hub), times)) for mass in MASSES]
        for hub in sets
    ]
    angle, largest, left = (
        np.array([[one[name] for one in row] for row in results])
        for name in ("hub", "peak", "amplitude")
    )
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


def models_of_figure_4(session: Session) -> Numbers:
    """Return the largest deflections [m] of figure 4 with the least and the largest load.

    By the exact equations, and by (14) to (16) corrected, converged and with two modes; by how
    many percent the converged ones overshoot; the speed [rad/s] above which the beam diverges
    without the second-order coupling.
    """
    times, beams = (
        np.arange(8 * SAMPLES + 1) / SAMPLES,
        [FIGURE_4, FIGURE_4.replace(mass=LOADS[-1])],
    )
    scenes = {
        "exact": SCENE,
        "converged": beam_scene("second_order", 8, 0),
        "two_modes": beam_scene("second_order", 2, 1, cantilever_modes),
    }
    peaks = {
        name: np.array([peak(solved(scene, p, times)) for p in beams])
        for name, scene in scenes.items()
    }
    over = 100 * (peaks["converged"] / peaks["exact"] - 1)
    return {**peaks, "over": over, "critical": critical_speed(beams[0])}


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
    beams = [[numbers(BEAM.replace(hub_radius=a, mass=mass)) for mass in LOADS] for a in radii]
    words = {}
    for name, own, modes in (("two", "two_best", 2), ("converged", "best", None)):
        words[name] = [crossed(crossover(by_mass[0], modes=modes)) for by_mass in beams]
        words[own] = [
            ", ".join(f"{best_mass_position(n, modes):.3g}" for n in by_mass)
            if crossing != "nowhere"
            else "none"
            for by_mass, crossing in zip(beams, words[name], strict=True)
        ]
    return {**words, **pulses(session, hub_radius=radii)}
