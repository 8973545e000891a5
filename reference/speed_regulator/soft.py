r"""speed_regulator with a softly closed loop, as MuJoCo closes loops.

::

               A        phi of the crank, theta of the rod: A to B' is l (sin, -cos) theta
          r  / |        pin_angle = theta - phi, what the hinge in A turns
    M_m -> O   |        B' is the end of the rod, B the slider at (0, y)
               |        residual B' - B, made small by a force f on the rod, -f on the slider
               B'
             ( B )      closed exactly: theta = -b

The tree of crank, rod and slider has three coordinates. Its loop is closed by the regularised
constraint of MuJoCo's documentation ("Computation", constraint model; "Modeling", solver
parameters), solved here in closed form. With the residual r, its rate v, the Jacobian J,
``A = J M^-1 J^T`` and the acceleration a_0 of the residual without the force:

- ``f = (A + R)^-1 (a_ref - a_0)``, ``a_ref = -b v - d k r``,
- the impedance d runs from d_0 at ``|r| = 0`` to d_w at ``|r| = width`` as the spline that
  ``solimp`` (d_0, d_w, width, midpoint, power) describes, clamped to `soft_constraint.IMPEDANCES`,
- ``b = 2 / (d_w timeconst)``, ``k = 1 / (d_w timeconst dampratio)^2`` for positive ``solref``,
  ``b = damping / d_w``, ``k = stiffness / d_w^2`` for (-stiffness, -damping),
- ``R = (1 - d) / d`` times the sum of the two bodies' inverse weights.

So the loop never closes exactly under load, at any step: about ``(1 - d) a_0 / (d k)`` is left
open. An inverse weight belongs to the body in the configuration in which the model was
compiled (`qpos0`, here phi = 0 with the loop closed): the mean over three axes of its centre's
acceleration per unit force, the rest of the tree joined to it, or 1 / m of a body that only
slides. A model compiled elsewhere is a little softer or harder.

Positive ``solref`` holds where timeconst is at least two steps, to which MuJoCo else raises it.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from ..differences import by_complex_step
from ..errors import NoOrbitError
from ..newton import Rows, linearisation, newton
from ..scene import Array, EquationsOfMotion, PeriodicOrbit, with_rates
from ..soft_constraint import SOLIMP, SOLREF, clamped, impedance, reference_spring
from . import SCENE, motions
from . import equations as exact
from .equations import UNITS, SpeedRegulator, position
from .motions import EQUILIBRIA, period

COORDINATES = ("phi", "pin_angle", "y")

NO_DRIFT = "the loop's constraint: its equation J a + dJ/dt v = a_ref lacks dJ/dt v"


class Coefficients(NamedTuple):
    """Coefficients of the tree, SI units.

    Attributes
    ----------
    crank_inertia : float or array
        J + m_b r^2: of the crank with the rod's mass in A.
    rod_inertia : float or array
        m_b l^2 / 3, about A.
    coupling : float or array
        m_b r l / 2.
    inverse_weight : float or array
        Of rod and slider together [1/kg].
    """

    radius: Any
    length: Any
    crank_inertia: Any
    rod_inertia: Any
    coupling: Any
    rod_mass: Any
    flywheel_inertia: Any
    slider_mass: Any
    stiffness: Any
    damping: Any
    torque: Any
    rest: Any
    inverse_weight: Any
    gravity_x: Any
    gravity_y: Any


def coefficients(p: SpeedRegulator) -> Coefficients:
    """Return the coefficients; rod and slider must have a mass."""
    r, l = p.crank_radius, p.rod_length
    crank, rod = p.flywheel_inertia + p.rod_mass * r**2, p.rod_mass * l**2 / 3
    coupling = p.rod_mass * r * l / 2
    # at phi = 0, sin theta = -r/l; mean over x, y and z of what moves the rod's centre
    centre = crank * l**2 / 4 + rod * r**2 - coupling * r**3 / l
    centre = centre / (crank * rod - (coupling * r / l) ** 2) / 3
    return Coefficients(
        radius=r,
        length=l,
        crank_inertia=crank,
        rod_inertia=rod,
        coupling=coupling,
        rod_mass=p.rod_mass,
        flywheel_inertia=p.flywheel_inertia,
        slider_mass=p.slider_mass,
        stiffness=p.stiffness,
        damping=p.damping,
        torque=p.torque,
        rest=p.spring_rest,
        inverse_weight=centre + 1 / p.slider_mass,
        gravity_x=p.gravity_x,
        gravity_y=p.gravity_y,
    )


class Loop(NamedTuple):
    """The open loop at one state, and the tree's mass matrix and forces in (phi, theta), y.

    Pairs are (x, y) where they are of the residual, (phi, theta) where they are of the tree.

    Attributes
    ----------
    drift : tuple[Any, Any]
        dJ/dt times the rates.
    jacobian : tuple[tuple[Any, Any], tuple[Any, Any]]
        Of (phi, theta); that of y is (0, -1).
    coupling : float or array
        Of the mass matrix [kg m^2].
    forces : tuple[Any, Any, Any]
        On phi, theta, y, less the velocity-dependent inertia terms.
    """

    residual: tuple[Any, Any]
    rate: tuple[Any, Any]
    drift: tuple[Any, Any]
    jacobian: tuple[tuple[Any, Any], tuple[Any, Any]]
    coupling: Any
    forces: tuple[Any, Any, Any]


def loop(q: Any, v: Any, c: Coefficients, xp: Any = np) -> Loop:
    """Return the loop at coordinates q (3, ...) and rates v."""
    theta, spin, speed = q[0] + q[1], v[0] + v[1], v[0]
    crank = c.radius * xp.cos(q[0]), c.radius * xp.sin(q[0])  # O to A
    rod = c.length * xp.sin(theta), -c.length * xp.cos(theta)  # A to B'
    coupling, slope = c.coupling * xp.sin(q[1]), c.coupling * xp.cos(q[1])
    jacobian = (-crank[1], -rod[1]), (crank[0], rod[0])
    weight_x, weight_y = c.rod_mass * c.gravity_x, c.rod_mass * c.gravity_y
    return Loop(
        residual=(crank[0] + rod[0], crank[1] + rod[1] - q[2]),
        rate=(
            jacobian[0][0] * speed + jacobian[0][1] * spin,
            jacobian[1][0] * speed + jacobian[1][1] * spin - v[2],
        ),
        drift=(
            -crank[0] * speed * speed - rod[0] * spin * spin,
            -crank[1] * speed * speed - rod[1] * spin * spin,
        ),
        jacobian=jacobian,
        coupling=coupling,
        forces=(
            c.torque - slope * spin * spin + (weight_y * crank[0] - weight_x * crank[1]),
            slope * speed * speed + (weight_y * rod[0] - weight_x * rod[1]) / 2,
            -c.stiffness * (q[2] - c.rest) - c.damping * v[2] + c.slider_mass * c.gravity_y,
        ),
    )


def free_accelerations(at: Loop, forces: Any, c: Coefficients) -> tuple[Any, Any, Any]:
    """Return the accelerations of (phi, theta, y) that forces give to the open tree."""
    crank, rod, coupling = c.crank_inertia, c.rod_inertia, at.coupling
    determinant = crank * rod - coupling * coupling
    return (
        (rod * forces[0] - coupling * forces[1]) / determinant,
        (crank * forces[1] - coupling * forces[0]) / determinant,
        forces[2] / c.slider_mass,
    )


def embedding(p: SpeedRegulator, state: Mapping[str, float]) -> dict[str, float]:
    """Return the tree's state with the loop closed, from phi and phi_dot."""
    phi, speed = state.get("phi", 0.0), state.get("phi_dot", 0.0)
    at = position(phi, exact.coefficients(p))
    theta = -np.arctan2(p.crank_radius * at.cos, at.h)
    spin = p.crank_radius * at.sin / at.h * speed
    return {
        "phi": phi,
        "pin_angle": theta - phi,
        "y": at.y,
        "phi_dot": speed,
        "pin_angle_dot": spin - speed,
        "y_dot": at.y_phi * speed,
    }


@cache
def soft_scene(
    solref: tuple[float, float] = SOLREF,
    solimp: tuple[float, ...] = SOLIMP,
    drift: float = 1.0,
) -> EquationsOfMotion:
    """Return the scene whose loop is closed this softly; the same object for the same numbers.

    Its coordinates are `COORDINATES`. ``forces`` holds the closure's force, found, like
    MuJoCo's, from the mass matrix without damping, whatever the integrator.

    Parameters
    ----------
    solref, solimp : tuple of float
        As MuJoCo's attributes of these names.
    drift : float
        Factor on dJ/dt v in the closure's equation; MuJoCo up to 3.6 has none.
    """
    solimp = clamped(solimp)
    spring, damper = reference_spring(solref, solimp[1])

    def closing(at: Loop, c: Coefficients, xp: Any) -> tuple[Any, Any]:
        """Force of the closure on the rod, its opposite on the slider [N]."""
        (rx, ry), (vx, vy) = at.residual, at.rate
        stiff = impedance(rx * rx + ry * ry, solimp, xp)
        softness = (1 - stiff) / stiff * c.inverse_weight
        free = free_accelerations(at, at.forces, c)
        (xx, xt), (yx, yt) = at.jacobian
        along = free_accelerations(at, (xx, xt, 0.0), c)
        across = free_accelerations(at, (yx, yt, -1.0), c)
        wanted_x = -damper * vx - stiff * spring * rx - drift * at.drift[0]
        wanted_y = -damper * vy - stiff * spring * ry - drift * at.drift[1]
        wanted_x = wanted_x - (xx * free[0] + xt * free[1])
        wanted_y = wanted_y - (yx * free[0] + yt * free[1] - free[2])
        a_xx = xx * along[0] + xt * along[1] + softness
        a_xy = xx * across[0] + xt * across[1]
        a_yy = yx * across[0] + yt * across[1] - across[2] + softness
        determinant = a_xx * a_yy - a_xy * a_xy
        return (
            (a_yy * wanted_x - a_xy * wanted_y) / determinant,
            (a_xx * wanted_y - a_xy * wanted_x) / determinant,
        )

    def closed(at: Loop, force: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        """All forces on phi, theta, y."""
        (xx, xt), (yx, yt) = at.jacobian
        return (
            at.forces[0] + xx * force[0] + yx * force[1],
            at.forces[1] + xt * force[0] + yt * force[1],
            at.forces[2] - force[1],
        )

    def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
        """Forces on the coordinates, less the velocity-dependent inertia terms."""
        at = loop(q, v, c, xp)
        on_phi, on_theta, on_y = closed(at, closing(at, c, xp))
        return [on_phi + on_theta, on_theta, on_y]

    def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
        """Accelerations of the coordinates."""
        at = loop(q, v, c, xp)
        phi, theta, y = free_accelerations(at, closed(at, closing(at, c, xp)), c)
        return [phi, theta - phi, y]

    def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
        """Powers [W] of the motor, the damper, and the closure."""
        at = loop(q, v, c)
        force = closing(at, c, np)
        return {
            "motor": c.torque * v[0],
            "damper": -c.damping * v[2] ** 2,
            "closure": force[0] * at.rate[0] + force[1] * at.rate[1],
        }

    def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
        """Openness of the loop, and the exact scene's outputs: the closure's force is B's."""
        at = loop(q, v, c, xp)
        force = closing(at, c, xp)
        phi_ddot, theta_ddot, _ = free_accelerations(at, closed(at, force), c)
        (rx, ry), (vx, vy) = at.residual, at.rate
        theta, spin = q[0] + q[1], v[0] + v[1]
        (xx, xt), (yx, yt) = at.jacobian
        half_x, half_y = yt / 2, -xt / 2  # A to the rod's centre
        centre_x = xx * phi_ddot + xt / 2 * theta_ddot - yx * v[0] ** 2 - half_x * spin**2
        centre_y = yx * phi_ddot + yt / 2 * theta_ddot + xx * v[0] ** 2 - half_y * spin**2
        return {
            "position_violation": xp.sqrt(rx * rx + ry * ry),
            "velocity_violation": xp.sqrt(vx * vx + vy * vy),
            "rod_angle": -theta,
            "rod_angle_dot": -spin,
            "rod_x": yx + half_x,
            "rod_y": -xx + half_y,
            "rod_x_dot": xx * v[0] + xt / 2 * spin,
            "rod_y_dot": yx * v[0] + yt / 2 * spin,
            "cos_b": xp.cos(theta),
            "reaction_a_x": force[0] - c.rod_mass * (centre_x - c.gravity_x),
            "reaction_a_y": force[1] - c.rod_mass * (centre_y - c.gravity_y),
            "reaction_b_x": force[0],
            "reaction_b_y": force[1],
        }

    def equilibrium(name: str, p: SpeedRegulator) -> dict[str, float]:
        """Return the rest state near the exact one of this name, by Newton's method."""
        state = embedding(p, motions.equilibrium(name, p))
        c = coefficients(p)
        start = np.array([[state[coordinate]] for coordinate in COORDINATES], dtype=float)

        def residual(rows: Rows, q: Any) -> Any:
            return np.array(np.broadcast_arrays(*accelerations(0.0, q, 0 * q, c)))

        roots = newton(residual, linearisation(residual, by_complex_step), start)
        if not roots.closed[0]:
            raise NoOrbitError(f"this closure leaves speed_regulator no equilibrium {name!r}")
        return dict(zip(COORDINATES, roots.unknowns[:, 0].tolist(), strict=True))

    return EquationsOfMotion(
        name=SCENE.name,
        title=SCENE.title + ", its loop closed softly",
        parameters=SpeedRegulator,
        coordinates=COORDINATES,
        units=UNITS
        | with_rates(pin_angle="rad")
        | {"position_violation": "m", "velocity_violation": "m/s"},
        coefficients=coefficients,
        mass_matrix=mass_matrix,
        forces=forces,
        accelerations=accelerations,
        damping_matrix=lambda c: np.diag([0.0, 0.0, c.damping]),
        energy=energy,
        powers=powers,
        equilibria={name: partial(equilibrium, name) for name in EQUILIBRIA},
        rotations_per_period={"phi": 1, "pin_angle": -1},
        stiff=(1e-12, 1e-10),
        period=period,
        orbit=PeriodicOrbit(orbit_guesses, "phi"),
        outputs=outputs,
        observed=("position_violation", "velocity_violation"),
        embedding=embedding,
        mistakes={NO_DRIFT: soft_scene(solref, solimp, 0.0)} if drift else {},
    )


def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """Mass matrix of the open tree."""
    coupling = c.coupling * xp.sin(q[1])
    both = c.rod_inertia + coupling
    return [
        [c.crank_inertia + both + coupling, both, 0.0],
        [both, c.rod_inertia, 0.0],
        [0.0, 0.0, c.slider_mass],
    ]


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Kinetic energy plus that of spring and gravity [J]; the closure's has none."""
    spin = v[0] + v[1]
    kinetic = c.crank_inertia * v[0] ** 2 + c.rod_inertia * spin**2 + c.slider_mass * v[2] ** 2
    coupled = c.coupling * np.sin(q[1]) * v[0] * spin
    inner = coupled + (kinetic + c.stiffness * (q[2] - c.rest) ** 2) / 2
    theta = q[0] + q[1]
    rod_x = c.radius * np.cos(q[0]) + c.length / 2 * np.sin(theta)
    rod_y = c.radius * np.sin(q[0]) - c.length / 2 * np.cos(theta)
    rod = c.rod_mass * (c.gravity_x * rod_x + c.gravity_y * rod_y)
    return inner - (rod + c.slider_mass * c.gravity_y * q[2])


def orbit_guesses(p: SpeedRegulator) -> list[Array]:
    """Return the exact scene's guesses with the loop closed."""
    guesses = []
    for phi, speed in motions.orbit_guesses(p):
        state = embedding(p, {"phi": phi, "phi_dot": speed})
        guesses.append(np.array(list(state.values())))
    return guesses
