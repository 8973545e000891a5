"""Parameters of scenes: frozen, validated, in SI units, with what `mbcheck list` prints of them."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import numpy as np

from .errors import ParameterError, UnknownNameError

PLAIN = re.compile(r"[+-]?(([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|inf|nan)")
"""Numbers as text: decimal, in the digits 0 to 9; Python alone would take ``1_0`` too."""

LARGEST_ANGLE = 1e9
"""Largest angle [rad]; rounding of one of 1e12 rad leaves 1e-4 rad of it open."""

BOUNDS: Mapping[str, tuple[Callable[[Any], Any], str]] = {
    "positive": (lambda value: value > 0, "greater than 0"),
    "non-negative": (lambda value: value >= 0, "0 or greater"),
    "any": (lambda value: value == value, "a number"),
    "angle": (
        lambda value: abs(value) <= LARGEST_ANGLE,
        f"an angle of {LARGEST_ANGLE:g} rad at most",
    ),
}


def as_number(value: Any) -> float:
    """Return a number, which may be plain decimal text.

    Raises
    ------
    ValueError, TypeError, OverflowError
        If it is none.
    """
    if isinstance(value, str) and not PLAIN.fullmatch(value.strip(" ")):
        raise ValueError(f"{value!r} is no decimal number")
    return float(value)


def quantity(
    default: float, symbol: str, unit: str, source: str, meaning: str, bound: str = "positive"
) -> Any:
    """Declare one field of a `Parameters` class, with what `mbcheck list` prints of it.

    A ``source`` is a place in the paper, or says that the value is chosen, or ``calibrated:`` to
    something or ``derived:`` from it.
    """
    about = dict(symbol=symbol, unit=unit, source=source, meaning=meaning, bound=bound)
    return field(default=default, metadata=about)


GRAVITY = ("gravity_x", "gravity_y")
"""Parameters that tell it."""


def gravity(axis: str, meaning: str) -> Any:
    """Declare the component of gravity along an axis of the scene's plane, 0 by default."""
    return quantity(0.0, f"g_{axis}", "m/s^2", "chosen", f"gravity {meaning}", "any")


def choice(options: tuple[str, ...], source: str, meaning: str) -> Any:
    """Declare a field with one of some words, the first by default."""
    about = dict(symbol="", unit="", source=source, meaning=meaning, bound=" or ".join(options))
    return field(default=options[0], metadata={**about, "options": options})


class BoundarySearch(NamedTuple):
    """Loss of stability of a periodic orbit, near the parameters of a case.

    Attributes
    ----------
    kind : str
        One of `reference.continuation.bifurcations.KINDS`, or `HOMOCLINIC`.
    parameter : str
        What is varied to come there.
    rest : str
        Of a homoclinic orbit: the name of its saddle among the equilibria.
    """

    kind: str
    parameter: str
    rest: str = ""


@dataclass(frozen=True)
class Parameters:
    """Base of the scenes' parameters: frozen, validated, SI units.

    A field is a float; where many parameter points are solved at once it may be an
    array, and all arrays broadcast against each other.

    Raises
    ------
    ParameterError
        If a value is not finite or outside its bound.
    """

    def __post_init__(self) -> None:
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if "options" in item.metadata:
                if value not in item.metadata["options"]:
                    raise UnknownNameError(item.name, str(value), item.metadata["options"])
                continue
            try:
                many = np.ndim(value) > 0
                number: Any = np.array(value, dtype=float) if many else as_number(value)
            except (TypeError, ValueError, OverflowError):
                raise ParameterError(f"{item.name} must be a number, not {value!r}") from None
            kind = "angle" if item.metadata["unit"] == "rad" else item.metadata["bound"]
            inside, words = BOUNDS[kind]
            finite = np.isfinite(number) if many else math.isfinite(number)
            for fits, what in ((finite, "finite"), (inside(number), words)):
                if not (np.all(fits) if many else fits):
                    wrong = float(number[~fits][0]) if many else value
                    raise ParameterError(f"{item.name} must be {what}, not {wrong!r}")
            if many:
                number.flags.writeable = False
            object.__setattr__(self, item.name, number)
        self.validate()

    def validate(self) -> None:
        """Check what no single value tells; for scenes to override.

        Raises
        ------
        ParameterError
            If the values contradict each other.
        """

    @property
    def has_gravity(self) -> bool:
        """Whether a component of gravity, which scenes have as `gravity`, is not 0."""
        return any(np.any(getattr(self, name)) for name in self.names() if name in GRAVITY)

    def without_gravity(self) -> Self:
        """Return the same without gravity."""
        return self.replace(**{name: 0.0 for name in self.names() if name in GRAVITY})

    def refuse_gravity(self, what: str) -> None:
        """Refuse gravity for what has none in its equations.

        Raises
        ------
        ParameterError
            If there is gravity; it names what cannot have it.
        """
        if self.has_gravity:
            raise ParameterError(f"no gravity in {what}: leave it 0")

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return tuple(item.name for item in dataclasses.fields(cls))

    @classmethod
    def choices(cls) -> dict[str, tuple[str, ...]]:
        """Words that a parameter may be, of those that are no number."""
        fields = dataclasses.fields(cls)
        return {f.name: f.metadata["options"] for f in fields if "options" in f.metadata}

    @classmethod
    def numeric_names(cls) -> tuple[str, ...]:
        """Names of those that are numbers, in order."""
        return tuple(name for name in cls.names() if name not in cls.choices())

    @classmethod
    def unit_of(cls, name: str) -> str:
        """Return the unit of a parameter, 1 where it has none."""
        return cls.__dataclass_fields__[name].metadata["unit"] or "1"

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some values changed.

        Raises
        ------
        UnknownNameError
            If a name is no parameter of this scene.
        ParameterError
            If a value is impossible.
        """
        for name in changes:
            if name not in self.names():
                raise UnknownNameError("parameter", name, self.names())
        return dataclasses.replace(self, **changes)

    def at(self, row: int) -> Self:
        """Return the parameters of one of many points: all of them numbers or words."""
        arrays = {name: value for name, value in vars(self).items() if np.ndim(value) == 1}
        return self.replace(**{name: float(value[row]) for name, value in arrays.items()})

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name, in SI units."""
        return dataclasses.asdict(self)
