"""Bounds on the errors of a periodic orbit, from a second run and from perturbed ones.

The orbit is solved for again with half as many steps more: a method of order 8 then errs by 4 % of
what it did, so that the difference shows the truncation error. Round-off is common to both runs. It
is measured by orbits whose coefficients, and whose states at the ends of parts of the period, are
off at random by a multiple of their round-off (Higham, Accuracy and Stability of Numerical
Algorithms, 2nd edition, section 1.17). The changes of all results are divided by that multiple.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eig, matrix_balance

from ..differences import EPS, PROBE
from ..errors import NoOrbitError
from ..newton import Rows
from ..orbits import (
    Orbit,
    Orbits,
    hidden_by_rounding,
    mean_powers,
    orbit_samples,
    reference_map,
    state_scale,
)
from ..periodic import spectrum_of
from ..scene import Array, EquationsOfMotion, coefficients_at
from ..solve.rk8 import rk8_samples
from .modes import pair_bounds, separations


class OrbitBoundOptions(NamedTuple):
    """Second run and perturbed runs of an orbit.

    Attributes
    ----------
    finer : float
        Ratio of the steps of the second run to those of the orbit.
    safety : float
        Factor on the truncation error that the second run shows.
    draws : int
        Number of perturbed orbits.
    displacement : float
        Size of their departures from the orbit, relative to the states: large against round-off,
        and small enough for changes to be linear.
    deviations : float
        Standard deviations of random round-off that a bound covers.
    coefficient, step : float
        Standard deviation of the relative round-off of a coefficient, and of a state in one step.
    parts : int
        Parts of a period, at the ends of which states are perturbed.
    samples : int
        Samples of each part.
    curved : float
        Relative change of the period map's Jacobian within the orbit's error above which the orbit
        counts as unknown.
    orders : int
        Harmonics that are bounded, the mean included.
    """

    finer: float = 1.5
    safety: float = 2.0
    draws: int = 16
    displacement: float = 1e-7
    deviations: float = 7.0
    coefficient: float = 0.5 * EPS
    step: float = 0.4 * EPS
    parts: int = 16
    samples: int = 16
    curved: float = 0.25
    orders: int = 7


OPTIONS = OrbitBoundOptions()


@dataclass(frozen=True)
class OrbitBounds:
    """Bounds on the errors of a periodic orbit.

    Attributes
    ----------
    period : float [s]
    state : array (2 n,)
    multipliers : array (2 n,)
    power, quantities : mapping of str to float
    harmonics : array (2 n,)
        Bound on the mean of each state and on the complex amplitudes of its harmonics.
    """

    period: float
    state: Array
    multipliers: Array
    power: Mapping[str, float]
    quantities: Mapping[str, float]
    harmonics: Array


class NearbyOrbits(NamedTuple):
    """Orbits near one another, with samples over their periods.

    Attributes
    ----------
    c : NamedTuple of arrays (k,)
    orbits : Orbits
    samples : array (k, 2 n, m)
    """

    c: Any
    orbits: Orbits
    samples: Array


def solve_orbits(
    scene: EquationsOfMotion, c: Any, orbit: Orbit, steps: int, kicks: Array, samples: int
) -> NearbyOrbits:
    """Return the orbits of perturbed equations near an orbit.

    Parameters
    ----------
    scene : EquationsOfMotion
    c : NamedTuple of arrays (k,)
    orbit : Orbit
    steps : int
        Steps in the period.
    kicks : array (parts, 2 n, columns, k)
        Changes at the ends of parts of the period, of the states relative to themselves, and of the
        entries of the Jacobian, which has these columns.
    samples : int
        Samples of each part.
    """
    parts, count = len(kicks), kicks.shape[-1]

    def follow(rows: Rows, x: Any, periods: Any, spacing: int) -> Any:
        derivative, path = scene.derivative(coefficients_at(c, rows)), [x[..., None]]
        columns = np.repeat(np.arange(len(rows) // len(np.unique(rows))), len(np.unique(rows)))
        number = -(-steps // (parts * spacing))
        for part, kick in enumerate(kicks):
            times = (part + np.arange(1, spacing + 1)[:, None] / spacing) * periods / parts
            ends = rk8_samples(derivative, x, part * periods / parts, times, number)
            x = ends[..., -1]
            size = x.real + 1j * PROBE * about.scale[:, rows] if np.iscomplexobj(x) else x
            x += kick[:, columns, rows] * size
            path.append(ends)
        return np.concatenate(path, axis=-1)

    states = np.repeat(orbit.state[:, None], count, axis=1)
    about = reference_map(scene, c, states, np.full(count, orbit.period), steps)
    flow = replace(about, flow=lambda rows, x, periods: follow(rows, x, periods, 1)[..., -1])
    orbits = flow.close()  # Newton's Jacobian precedes its last correction: begin again there
    orbits = replace(flow, states=orbits.states, periods=orbits.periods).close()
    path = follow(np.arange(count), orbits.states, orbits.periods, samples)[..., :-1]
    return NearbyOrbits(c, orbits, path.swapaxes(0, 1))


def measure(
    scene: EquationsOfMotion, c: Any, state: Array, period: float, samples: Array
) -> dict[Any, Any]:
    """Return the results of one orbit, by the fields of `OrbitBounds`."""
    turns = [scene.rotations_per_period.get(name, 0) for name in scene.state_names]
    spectra = [spectrum_of(*pair)[: OPTIONS.orders] for pair in zip(samples, turns, strict=True)]
    powers, quantities = mean_powers(scene, samples, c, period), scene.orbit.quantities(samples, c)
    return {
        "period": period,
        "state": state,
        "harmonics": 2 * np.array(spectra),
        **{("power", name): value for name, value in powers.items()},
        **{("quantity", name): value for name, value in quantities.items()},
    }


def deviation(changes: Array) -> Array:
    """Return the largest random error, from changes (k, ...) by perturbations."""
    squares = np.mean(np.abs(changes[1:]) ** 2, axis=0)  # the first orbit is not perturbed
    return np.asarray(OPTIONS.deviations * np.sqrt(squares))


def multiplier_roundoff(matrices: Array, gain: float, multipliers: Any) -> Array:
    """Return bounds (2 n,) on the round-off of multipliers.

    To first order an eigenvalue changes as its matrix does between its eigenvectors; two that
    nearly coincide part as the roots of a parabola.

    Parameters
    ----------
    matrices : array (k, 2 n, 2 n)
        Monodromy matrices, the first without perturbations.
    gain : float
        Size of the perturbations over that of round-off.
    multipliers : array (2 n,)
    """
    balanced, (unit, _) = matrix_balance(matrices[0], permute=False, separate=True)
    values, left, right = eig(balanced, left=True, right=True)
    with np.errstate(all="ignore"):
        left = left.conj() / np.sum(left.conj() * right, axis=0)
        changes = (matrices - matrices[0]) * unit / unit[:, None]
        random = deviation(np.einsum("mi,kmj,ji->ki", left, changes, right)) / gain
        own = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0)
        bounds = pair_bounds(separations(values), random + EPS * np.linalg.norm(balanced) * own)
    return np.asarray(bounds[np.argmin(np.abs(multipliers[:, None] - values), axis=1)])


def orbit_bounds(scene: EquationsOfMotion, parameters: Any, orbit: Orbit) -> OrbitBounds:
    """Bound the errors of a periodic orbit of the reference.

    Parameters
    ----------
    scene : EquationsOfMotion
    parameters : Parameters of it
    orbit : Orbit

    Raises
    ------
    NoOrbitError
        If the orbit is so nearly one of a family that rounding hides it.
    """
    c, n, count = scene.coefficients(parameters), len(orbit.state), OPTIONS.draws + 1
    scale = state_scale(scene, orbit.state, 2 * np.pi / orbit.period)
    gain = OPTIONS.displacement / float(np.max(orbit.error_bound / scale))
    rng = np.random.default_rng(n)
    kicks = rng.choice([-1.0, 1.0], (OPTIONS.parts, n, n + 1, count))
    signs = rng.choice([-1.0, 1.0], (len(c), count))
    kicks[..., 0], signs[:, 0] = 0.0, 0.0
    kicks *= gain * OPTIONS.step * np.sqrt(orbit.steps / OPTIONS.parts + 4)
    signs *= gain * OPTIONS.coefficient
    points = type(c)(*(value * (1 + row) for value, row in zip(c, signs, strict=True)))
    steps = int(np.ceil(OPTIONS.finer * orbit.steps))
    with np.errstate(all="ignore"):
        coarse = orbit.steps // 4  # round-off needs no more digits
        near = solve_orbits(scene, points, orbit, coarse, kicks, OPTIONS.samples)
        fine = solve_orbits(scene, points, orbit, steps, kicks[..., :1], 2 * OPTIONS.samples)
        slopes = near.orbits.closing
        bend = deviation(np.linalg.solve(slopes[0], slopes - slopes[0])) / gain
    bent = float(np.max(np.sum(bend, axis=1)))
    if not (np.all(near.orbits.closed) and np.all(fine.orbits.closed) and bent < OPTIONS.curved):
        raise NoOrbitError(hidden_by_rounding(scene))
    base = measure(scene, c, orbit.state, orbit.period, orbit_samples(scene, parameters, orbit))
    second, *several = (
        measure(
            scene, coefficients_at(runs.c, i), runs.orbits.states[:, i],
            float(runs.orbits.periods[i]), runs.samples[i],
        )
        for runs, i in ((fine, 0), *((near, i) for i in range(count)))
    )  # fmt: skip
    truncation, bounds = OPTIONS.safety / (1 - OPTIONS.finer**-8), {}
    for key, value in base.items():
        off = np.array([second[key] - value, *(one[key] - several[0][key] for one in several)])
        if scene.orbit.units.get(key[1]) == "rad":
            off = np.angle(np.exp(1j * off))
        random = deviation(off[1:]) / gain
        bounds[key] = truncation * np.abs(off[0]) + random + 2 * EPS * np.abs(value)
    values, others = orbit.multipliers, fine.orbits.multipliers[:, 0]
    apart = np.min(np.abs(values[:, None] - others), axis=1)
    return OrbitBounds(
        period=float(bounds["period"]),
        state=bounds["state"] / (1 - bent),
        multipliers=truncation * apart + multiplier_roundoff(near.orbits.monodromy, gain, values),
        power={key[1]: float(bound) for key, bound in bounds.items() if key[0] == "power"},
        quantities={key[1]: float(bound) for key, bound in bounds.items() if key[0] == "quantity"},
        harmonics=np.max(bounds["harmonics"], axis=1),
    )
