"""Continua and their elements: natural frequencies, and how they converge.

There are three layers. A model may *be* a discrete system, a chain of rods: its frequencies must be
those of that system, assembled without the engine (`omega_1`, ...). Elements converge to a
continuum with the order they claim (*order*, `extrapolated`), and elements that claim no more than
that must be off by what halving them predicts. What is left between the model and the scene's own
continuum is `model_error`: that of the rods, or of a beam that stretches or shears where the
scene's does not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...reference import get_scene
from ...reference.linear import Mode, linearise_at, modes
from ...reference.scene import Array, Case
from ..engines.run import contained
from ..engines.setup import Setup
from .comparison import RICHARDSON_SAFETY, model_error
from .verdict import Finding

COUNT = 2
"""Number of modes compared."""

PLANE = "chordwise"
ABOUT = "rotation"

ROUNDING = 1e-8
"""Relative error granted to a frequency: an engine's stiffness is a difference of forces, and
elements that stretch are 1e6 times stiffer along than across."""

STRETCHES = 5
"""Steps of Newton's method from the straight beam to the one that rotation stretches."""

SLACK = 0.1
"""The slope of the finer errors may stay this much below the declared order: right elements stay
0.042 below, a clamp of the whole slope vector 0.17 and more."""

ELEMENT_LEAST = 1e-3
"""Least error as a share of the Taylor remainder, of the elements' order, over a quarter of a wave:
the cubic elements and the rods leave 0.1 of it and more."""

NOISE = 4e-9
"""Relative error of a first frequency by the rounding of matrices in which coordinates that bend
and those that stretch are summed up: three standard deviations, where every entry of mass and
stiffness of 32 elements is off by half a unit in its last place. It is 6e-11 where they are kept
apart, as by Exudyn's adapter."""


def steady(setup: Setup) -> Setup:
    """Return the setup in its steady motion, forces and motors off."""
    scene, case = setup.scene, setup.case
    p = scene.unforced(case.parameters)
    state = scene.equilibria[case.about or next(iter(scene.equilibria))](p)
    return setup.with_case(replace(case, parameters=p, state=state))


def engine_modes(setup: Setup) -> list[Mode]:
    """Return the modes from the engine's own matrices, without the prescribed rotation."""
    setup = steady(setup)
    names = setup.bound.coordinates
    state = np.array(
        [setup.case.state.get(name, 0.0) for name in (*names, *(f"{n}_dot" for n in names))]
    )
    with contained():
        mass, damping, stiffness = setup.bound.linearise(state)
    if setup.bound.equations.scene.continuum.refined is None:
        damping = 0 * mass  # rods turn across themselves: no Coriolis force is linear
    # a model that eliminates what keeps its speed tells fewer or more coordinates than it takes
    places = steady_places(setup.case, names) if len(mass) == len(names) else ()
    # the clamp leaves no direction free, however stiff the beam is against shear
    return modes(mass, damping, stiffness, places, 0.0)[len(places) :]


def of_engine(setup: Setup) -> Array:
    """Return the lowest frequencies (`COUNT`,) [rad/s] from the engine's own matrices."""
    return np.array([mode.omega for mode in engine_modes(setup)[:COUNT]])


def of_model_equations(setup: Setup) -> Array:
    """Return the lowest frequencies of the discrete system that a model is, or is made of.

    Rods are straight in steady rotation; elements stretch until nothing accelerates them.
    """
    setup = steady(setup)
    equations = setup.bound.solved_equations
    scene = equations.scene
    c, state = scene.coefficients(equations.parameters), equations.start(setup.case)
    places = steady_places(setup.case, scene.coordinates)
    free = np.delete(np.arange(len(scene.coordinates)), places)
    mass, damping, stiffness, forces = linearise_at(scene, c, state)
    for _ in range(STRETCHES if setup.bound.discrete else 0):
        state[free] += np.linalg.solve(stiffness[np.ix_(free, free)], forces[free])
        mass, damping, stiffness, forces = linearise_at(scene, c, state)
    if not setup.bound.discrete:
        damping = 0 * mass  # see `engine_modes`
    vibrations = modes(mass, damping, stiffness, places, 0.0)[len(places) :]
    return np.array([mode.omega for mode in vibrations[:COUNT]])


def steady_places(case: Case, names: tuple[str, ...]) -> tuple[int, ...]:
    """Return the indices of the coordinates with a constant speed."""
    keeping = get_scene(case.scene).steady_coordinates.get(case.about or "", ())
    return tuple(names.index(name) for name in keeping)


def of_continuum(setup: Setup) -> Array:
    """Return the frequencies that a model's converge to."""
    equations = setup.bound.equations
    known = equations.scene.continuum.spectrum or setup.scene.continuum.spectrum
    assert known is not None
    return known(equations.parameters, PLANE, COUNT)[0]


def exact(case: Case) -> Array:
    """Return the frequencies of the scene's own continuum."""
    known = get_scene(case.scene).continuum.spectrum
    assert known is not None
    return known(case.parameters, PLANE, COUNT)[0]


def measure_frequencies(setup: Setup) -> list[Finding]:
    """Compare with the discrete system claimed, or with the continuum that elements approach."""
    omegas, truth = of_engine(setup), exact(setup.case)
    if setup.bound.approximates_continuum and not setup.bound.discrete:
        right = of_continuum(setup)
        order = setup.bound.description.element_order
        gain = 2**order - 1
        coarse = of_engine(setup.with_segments(0.5))
        error = np.abs(omegas - coarse) / gain
        room = RICHARDSON_SAFETY * error + ROUNDING * right
        reason = f"halving {setup.case.parameters.segments:g} elements predicts an error of"
        reasons = [f"{reason} {value:.2g}" for value in error]
        predicted = right
    else:
        right = predicted = of_model_equations(setup)
        room = ROUNDING * right
        reasons = [f"the same of {setup.bound.solved_equations.scene.title}"] * COUNT
    findings = [
        Finding(
            f"omega_{i + 1}",
            "rad/s",
            float(omegas[i]),
            float(right[i]),
            float(abs(omegas[i] - right[i])),
            float(room[i]),
            reasons[i],
        )
        for i in range(COUNT)
    ]
    off, expected = (float(np.max(np.abs(item / truth - 1))) for item in (omegas, predicted))
    title = setup.bound.equations.scene.title
    reason = f"frequencies are off those of the scene's continuum: {title}"
    return [*findings, model_error(off, expected, float(np.max(room / truth)), reason)]


class Refinement(NamedTuple):
    """Convergence of the first frequency with elements halved twice.

    Attributes
    ----------
    errors : array (3,)
    slope : float
        Order of the last two.
    away : float
        Relative error of the extrapolation of the last two.
    spread : float
        Its distance from the extrapolation of the first two.
    """

    errors: Array
    slope: float
    away: float
    spread: float


def refinement(runs: Sequence[float], truth: float, order: int) -> Refinement:
    """Return the convergence of first frequencies (3,) for elements of an order."""
    errors, gain = np.array(runs) / truth - 1, 2**order - 1
    slope = float(np.log2(abs(errors[1]) / abs(errors[2])))
    limits = [b + (b - a) / gain for a, b in pairwise(runs)]
    return Refinement(errors, slope, abs(limits[1] / truth - 1), abs(limits[1] - limits[0]) / truth)


def measure_order(setup: Setup) -> list[Finding]:
    """Halve the elements twice, and judge the first frequency.

    If their own equations are known, these set the expected order: a mass between the nodes of
    equal elements lies elsewhere in each mesh, and errors of coarse elements then shrink
    irregularly.
    """
    order = setup.bound.description.element_order
    truth = float(of_continuum(setup)[0])
    several = [setup.with_segments(factor) for factor in (0.5, 1, 2)]
    seen = refinement([float(of_engine(one)[0]) for one in several], truth, order)
    errors, room = seen.errors, seen.spread + ROUNDING
    slack = SLACK + float(np.log2(1 + NOISE / abs(errors[2])))
    counts = ", ".join(f"{one.case.parameters.segments:g}" for one in several)
    listed = ", ".join(f"{error:.2g}" for error in errors)
    reason = f"relative errors {listed} of the first frequency with {counts} elements"
    expected, left = float(order), 0.0
    known = setup.bound.discrete or not setup.bound.approximates_continuum
    if known and (order - seen.slope > SLACK or seen.away > room / 2):
        right = refinement([float(of_model_equations(one)[0]) for one in several], truth, order)
        expected, left = min(expected, right.slope), right.away
        reason += f"; by their own equations the order is {right.slope:.3g} there"
    findings = [
        Finding("order", "1", seen.slope, expected, max(0.0, expected - seen.slope), slack, reason),
        Finding(
            "extrapolated",
            "1",
            seen.away,
            left,
            max(0.0, seen.away - left),
            room,
            "relative error of the first frequency extrapolated to elements of no length",
        ),
    ]
    waves = np.pi / setup.case.parameters.segments  # a quarter of a wave over half the elements
    least = ELEMENT_LEAST * waves**order / math.factorial(order + 1)
    findings.append(
        Finding(
            "least_error",
            "1",
            float(abs(errors[0])),
            least,
            least / max(abs(errors[0]), least * NOISE),
            1.0,
            f"elements of order {order} leave an error of {least:.2g} or more in the first "
            "frequency; a smaller one is not that of elements",
        )
    )
    if expected := setup.bound.frequency_side:
        wrong = float(any(np.sign(error) != expected for error in errors))
        where = "above" if expected > 0 else "below"
        findings.append(
            Finding("bracket", "1", wrong, 0.0, wrong, 0.25, f"expected {where}: {listed}")
        )
    return findings
