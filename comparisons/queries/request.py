"""Requests of queries: their options, and the fields that their functions take.

Nothing heavy is imported here, since help texts are made from it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import TYPE_CHECKING, Annotated, Any

from ...reference.errors import UsageError
from ..documents.fields import OptionMark, number_from
from ..engines import REFERENCE

if TYPE_CHECKING:
    from ...reference.scene import Case
    from ..engines.setup import Setup


MOST_TIMES = 1_000_000
"""Longer lists of times are refused as a typing error."""


def times_from(text: str, flag: str) -> list[float]:
    """Return times from ``T1,T2,...`` or ``START:STOP:STEP``.

    A range is START + i STEP in decimal arithmetic, STOP included: as exact as it is typed.

    Raises
    ------
    UsageError
        If it is neither.
    """
    if ":" not in text:
        return [number_from(word.strip(), "--times: a time") for word in text.split(",")]
    words = text.split(":")
    if len(words) != 3:
        raise UsageError(f"--times needs T1,T2,... or START:STOP:STEP, not {text!r}")
    start, stop, step = (decimal(word) for word in words)
    if step <= 0 or stop < start:
        raise UsageError(f"--times {text}: STEP must be positive and STOP not before START")
    intervals = float((stop - start) / step)
    if intervals > MOST_TIMES:
        raise UsageError(f"--times {text}: more than {MOST_TIMES} times; choose a larger STEP")
    count = math.floor(intervals * (1 + 1e-12) + 1e-9)
    return [float(start + i * step) for i in range(count + 1)]


def decimal(text: str) -> Decimal:
    """Return a decimal number from the command line.

    Raises
    ------
    UsageError
        If it is none, or too large or small for a float.
    """
    number_from(text, "--times: a time")
    value = Decimal(text.strip())
    if not math.isfinite(float(value)) or (value and not float(value)):
        raise UsageError(f"--times: a time must be finite, not {text!r}")
    return value


@dataclass(frozen=True, kw_only=True)
class ModelQuery:
    """A scene at a user's parameters, and the engine's model that computes it.

    Attributes
    ----------
    scene : str
        Name of the scene.
    engine : str
        Engine that computes it.
    model : str or None
        One of the engine's models of the scene.
    parameters : mapping of str to float or str
        Change a parameter from its default, SI units.
    """

    scene: Annotated[str, OptionMark(flags=())] = field(kw_only=False)
    engine: Annotated[str, OptionMark("ENGINE")] = REFERENCE
    model: Annotated[str | None, OptionMark("NAME")] = None
    parameters: Annotated[Mapping[str, Any] | None, OptionMark("NAME=VALUE", ("--set",))] = None

    @property
    def case(self) -> Case:
        """The case that the user describes.

        Raises
        ------
        UsageError
            For unknown names or impossible values.
        """
        from .query import user_case

        return user_case(self.scene, self.parameters)

    def model_setup(self) -> Setup:
        """Return the case with its engine and model, where nothing is integrated.

        Raises
        ------
        UsageError
            For unknown names or impossible values.
        """
        from ..engines.setup import Setup
        from .query import choose_engine

        case = self.case
        engine, model = choose_engine(self.engine, case, self.model)
        return Setup(engine, case, model)


@dataclass(frozen=True, kw_only=True)
class MethodQuery(ModelQuery):
    """The same with a method and a step.

    Attributes
    ----------
    method : str or None
        Integrator as the engine spells it; by default that of highest order.
    step : float or None
        Fixed step [s].
    """

    method: Annotated[str | None, OptionMark("METHOD")] = None
    step: Annotated[float | None, OptionMark("H")] = None

    def setup(self) -> Setup:
        """Return the case with its engine, model, method and step.

        Raises
        ------
        UsageError
            For unknown names, impossible values, or what the engine cannot run.
        """
        from .query import choose_method, valid_step

        setup = self.model_setup()
        method = choose_method(setup.engine, setup.case, setup.model, self.method)
        if self.step is not None and setup.engine.name == REFERENCE:
            raise UsageError("the reference chooses its own steps: leave the step out")
        step = None if self.step is None else valid_step(self.step)
        return replace(setup, method=method, step=step)


@dataclass(frozen=True, kw_only=True)
class Query(MethodQuery):
    """The same, from a user's initial state.

    Attributes
    ----------
    state : mapping of str to float
        Initial value, otherwise 0, SI units.
    """

    state: Annotated[Mapping[str, float] | None, OptionMark("NAME=VALUE")] = None

    @property
    def case(self) -> Case:
        """The case that the user describes, see `ModelQuery.case`."""
        from .query import user_case

        return user_case(self.scene, self.parameters, self.state)


@dataclass(frozen=True, kw_only=True)
class SimulateRequest(Query):
    """A run from t = 0.

    Attributes
    ----------
    times : sequence of float
        Sample times [s], on the grid of the step; STOP is included.
    observe : sequence of str
        Also show this output of the scene, see mbcheck list SCENE; 'all' for all outputs of the
        engine.
    """

    times: Annotated[Iterable[float], OptionMark("T1,T2,...|START:STOP:STEP", parse=times_from)]
    observe: Annotated[Sequence[str], OptionMark("NAME")] = ()


@dataclass(frozen=True, kw_only=True)
class FrequenciesRequest(ModelQuery):
    """The modes about a state of rest.

    Attributes
    ----------
    about : str or None
        State of rest, see mbcheck list SCENE; the first by default.
    count : int or None
        Only the lowest N modes.
    undamped : bool
        Leave damping out.
    plane : {"chordwise", "flapwise"} or None
        Of a rotating beam: chordwise (in the plane of rotation, the default) or flapwise.
    """

    about: Annotated[str | None, OptionMark("NAME")] = None
    count: Annotated[int | None, OptionMark("N", least=1)] = None
    undamped: Annotated[bool, OptionMark()] = False
    plane: Annotated[str | None, OptionMark("NAME")] = None
