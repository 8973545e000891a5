"""Maps of rotor_pendulum: the coupling of the rotors, their phase, their synchronism.

Axes are any parameters, or the frequency ratios n_x and n_phi of (19). These set the stiffnesses
by the inverse of `mbcheck.reference.rotor_pendulum.theory.ratios` at the speed at which motor
and bearing balance (`operating_speed`, 153.81 rad/s by default), not at the motors' own 50 pi.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.equations import RotorPendulum, operating_speed
from ....reference.scene import Array
from ..bounds import conditions, with_bounds
from ..quantity import AxisName, Points, Quantity, QuantityValues, Variable
from .phase import PHASE, phase
from .steps import columns
from .synchronism import SYNC, sync


def _with_n_x(p: RotorPendulum, n_x: Array) -> RotorPendulum:
    mass = p.platform_mass + p.rod_mass + 2 * np.asarray(p.rotor_mass)
    return p.replace(platform_stiffness=mass * (operating_speed(p) / n_x) ** 2)


def _with_n_phi(p: RotorPendulum, n_phi: Array) -> RotorPendulum:
    inertia = (p.rotor_mass + p.rod_mass) * np.square(p.rod_length)
    return p.replace(rod_stiffness=inertia * (operating_speed(p) / n_phi) ** 2)


AXES: Mapping[str, AxisName] = {
    "n_x": AxisName(
        "1", "rotors' speed over the platform's natural frequency: sets k_x", _with_n_x
    ),
    "n_phi": AxisName("1", "rotors' speed over the rod's: sets k_phi", _with_n_phi),
}


NAMES = ("mu_1", "mu_2", "mu_3", "mu_4")

COUPLING = with_bounds(
    {
        "mu_1": Variable("1", "x by the rotors' push on the platform"),
        "mu_2": Variable("1", "x by the second rotor's pull on the rod"),
        "mu_3": Variable("1", "phi_3 by the push on the platform"),
        "mu_4": Variable("1", "phi_3 by the pull on the rod"),
    },
    *NAMES,
)


def coupling(points: Points) -> QuantityValues:
    """Coupling coefficients (22) at the motors' operating speed, NaN at resonance."""

    def coefficients(p: RotorPendulum) -> theory.Coupling:
        return theory.coupling_coefficients(theory.ratios(p), as_printed=points.model == "paper")

    p = points.parameters
    numbers = [*coefficients(p), *conditions(coefficients, p)]
    values = (np.where(np.isfinite(one), one, np.nan) for one in columns(points, *numbers))
    return QuantityValues(dict(zip(COUPLING, values, strict=True)))


QUANTITIES: Mapping[str, Quantity] = {
    "coupling": Quantity(
        "coupling coefficients (22) of platform, rod and rotors; paper: mu_1 as printed",
        COUPLING,
        coupling,
        models=("corrected", "paper"),
        engines=False,
        block=4096,
    ),
    "phase": Quantity(
        "stable phase difference: theory (30), (36); paper (33) to the letter; damped: with the "
        "dampers; exact, reduced (11) and engines: of the synchronous orbit",
        PHASE,
        phase,
        models=("theory", "paper", "damped", "exact", "reduced"),
        block=128,
        engine_block=8,
    ),
    "sync": Quantity(
        "whether the start from rest ends synchronised, not, or undecided",
        SYNC,
        sync,
        of_start=True,
        models=("exact", "reduced"),
        block=1024,
        engine_block=4,
    ),
}
