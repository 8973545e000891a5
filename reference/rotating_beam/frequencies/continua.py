"""Natural frequencies of the continua that engines model, in SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import ParameterError, UnknownNameError
from ...scene import Array
from ..parameters import RotatingBeam
from .numbers import numbers, time_unit
from .ritz import ritz
from .stretching import stretching

CONTINUA = ("inextensible", "extensible", "shear_flexible")


@dataclass(frozen=True)
class BeamModes:
    """Natural frequencies about steady rotation.

    Attributes
    ----------
    plane, continuum : str
    omega : array (count,)
        Circular frequencies [rad/s], ascending.
    bound : array (count,)
        On their errors [rad/s].
    places : array (k,)
        Reference coordinate x of the beam [m], 0 to L.
    shapes : array (count, k)
        Deflection of each mode there, 1 at the tip.
    """

    plane: str
    continuum: str
    omega: Array
    bound: Array
    places: Array
    shapes: Array

    @property
    def hertz(self) -> Array:
        """Frequencies [Hz]."""
        return self.omega / (2 * np.pi)


def frequencies(
    p: RotatingBeam,
    plane: str = "chordwise",
    count: int = 2,
    continuum: str = "inextensible",
    shear_stiffness: float | None = None,
    rotary_inertia: bool = False,
) -> BeamModes:
    """Lowest natural frequencies of the beam that rotates at ``angular_speed``.

    Parameters
    ----------
    p : RotatingBeam
    plane : {"chordwise", "flapwise"}
        In the plane of rotation (the hub's speed prescribed), or out of it.
    count : int
    continuum : {"inextensible", "extensible", "shear_flexible"}
        The last one chordwise only.
    shear_stiffness : float, optional
        k G A [N] of the shear-flexible beam.
    rotary_inertia : bool
        Of the shear-flexible beam's cross-sections.
    """
    if continuum not in CONTINUA:
        raise UnknownNameError("continuum", continuum, CONTINUA)
    n, unit = numbers(p), time_unit(p)
    if continuum == "inextensible":
        modes = ritz(n, plane, count)
    else:
        section = p.second_moment / (p.area * p.length**2)
        if continuum == "extensible":
            modes = stretching(n, 1 / section, plane, count)
        elif shear_stiffness is None:
            raise ParameterError("the shear-flexible beam needs its shear_stiffness (k G A)")
        else:
            shear = shear_stiffness * p.length**2 / (p.youngs_modulus * p.second_moment)
            rotary = section if rotary_inertia else 0.0
            modes = stretching(n, 1 / section, plane, count, shear, rotary)
    return BeamModes(
        plane=plane,
        continuum=continuum,
        omega=modes.omega / unit,
        bound=modes.bound / unit,
        places=modes.places * p.length,
        shapes=modes.shapes,
    )
