"""Parts that a model may leave out: the change of its runs, and the saving."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...reference import get_scene
from ...reference.equations import scene_equations
from ..checks.kinds.order import relative_error
from ..checks.truth import roundoff_reference
from ..engines.registry import REFERENCE
from ..engines.setup import Setup, power_of_two, run
from ..queries.query import choose_method
from ..scenes.data import scene_data
from ..scenes.left_out import Pair, PairedModel
from .sweep import sample_times
from .table import MeasuredCase
from .tuning import SWEEP


@dataclass(frozen=True)
class LeftOut(MeasuredCase):
    """Comparison of a model with a part and one without it.

    Attributes
    ----------
    left_out : str
        Part that the second model lacks.
    whole : str
        Model with the part, and its method.
    without : str
        Model without the part, and its method.
    error : float
        Largest error of the observables with the part, relative to the size of each, against the
        scene's reference; for theories against the one with the part.
    error_without : float
        Largest error without the part.
    ratios : tuple of float
        Cost with the part over cost without it: quartiles of repeated pairs of runs.
    cost : str
        Measure of the cost: ``wall time``, or ``right-hand sides`` for theories.
    """

    left_out: str
    whole: str
    without: str
    error: float
    error_without: float
    ratios: tuple[float, float, float]
    cost: str

    @property
    def saving(self) -> str:
        """Saving in words; none within the scatter of times."""
        low, ratio, high = self.ratios
        if low <= 1 <= high or abs(ratio - 1) < SWEEP.equal_times:
            return f"no {self.cost} above the scatter"
        change = f"saves a factor of {ratio:.2g}" if ratio > 1 else f"costs {1 / ratio:.2g} times"
        return f"{change} in {self.cost}"


def pairs_of(scenes: Sequence[str], engines: Sequence[str]) -> Iterator[tuple[str, Pair]]:
    """Yield the pairs of these scenes and engines, and the theories, with their names."""
    for scene in scenes:
        for pair in scene_data(scene, "left_out", "LEFT_OUT", tuple[Pair, ...]()):
            engine = pair.whole.engine.engine
            if engine in (*engines, REFERENCE):
                yield f"{scene} {engine} without {pair.left_out}, {pair.without.words}", pair


def compare(pair: Pair) -> LeftOut:
    """Run both models of a pair in turns, and compare results and times.

    Raises
    ------
    MbcheckError
        If one cannot be run.
    """
    case, names = pair.case, get_scene(pair.case.scene).observables
    span = case.horizon if pair.span is None else pair.span
    spacing = max(pair.step, power_of_two(span / SWEEP.samples))
    times = sample_times(case.start_time, spacing, span)
    setups = [paired_setup(pair, one) for one in (pair.whole, pair.without)]
    engine = setups[0].engine.name
    is_theory = engine == REFERENCE
    equations = setups[0].bound.equations if is_theory else scene_equations(case)
    right = roundoff_reference(equations, case, times, names)
    repeats = 1 if is_theory else SWEEP.pair_repeats
    runs = [[run(setup, times) for setup in setups] for _ in range(repeats)]
    error, error_without = (relative_error(one.matrix(names), right) for one in runs[0])
    costs = [
        [one.rhs_evaluations or 1 if is_theory else one.seconds for one in two] for two in runs
    ]
    low, ratio, high = np.quantile([a / b for a, b in costs], (0.25, 0.5, 0.75)).tolist()
    return LeftOut(
        case.scene, case.name, engine, pair.left_out, pair.whole.words, pair.without.words,
        error, error_without, (low, ratio, high),
        "right-hand sides" if is_theory else "wall time",
    )  # fmt: skip


def paired_setup(pair: Pair, one: PairedModel) -> Setup:
    """Return the setup of one model of a pair."""
    engine = one.engine.make()
    case = replace(pair.case, parameters=pair.case.parameters.replace(**one.changes))
    method = choose_method(engine, case, one.model, one.method)
    return Setup(engine, case, one.model, method, pair.step)
