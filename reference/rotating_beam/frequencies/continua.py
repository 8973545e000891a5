"""Natural frequencies of the continua that engines model, in SI units."""

from __future__ import annotations

from ...errors import ParameterError, UnknownNameError
from ..parameters import RotatingBeam
from .numbers import NaturalModes, numbers, time_unit
from .ritz import ritz
from .stretching import stretching

CONTINUA = ("inextensible", "extensible", "shear_flexible")


def frequencies(
    p: RotatingBeam,
    plane: str = "chordwise",
    count: int = 2,
    continuum: str = "inextensible",
    shear_stiffness: float | None = None,
    rotary_inertia: bool = False,
) -> NaturalModes:
    """Lowest natural frequencies [rad/s] of the beam that rotates at ``angular_speed``.

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
    return NaturalModes(modes.omega / unit, modes.bound / unit)
