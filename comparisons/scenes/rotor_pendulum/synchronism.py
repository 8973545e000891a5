"""Whether the rotors of `rotor_pendulum` synchronise when they start from rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ....reference.differences import EPS
from ....reference.rotor_pendulum.equations import RotorPendulum, period
from ....reference.rotor_pendulum.outcome import outcome
from ....reference.rotor_pendulum.phase import mean_phase, phase_rate, wrapped
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..bounds import difference, with_bounds
from ..orbit_map import Ints
from ..quantity import Flow, Points, QuantityValues, Variable
from .steps import NUDGE, columns, step_counts

OUTCOMES = ("synchronised", "not synchronised", "undecided")


SYNC = with_bounds(
    {
        "class": Variable("1", "what the start from rest ends in", OUTCOMES),
        "robust": Variable(
            "1", "1 where a perturbed start with half the step gives the same class"
        ),
        "phase_difference": Variable("rad", "phi_1 - phi_2 at the end, where synchronised"),
        "mean_speed": Variable("rad/s", "of both rotors at the end, where synchronised"),
        "duration": Variable("s", "simulated"),
    },
    "phase_difference",
    "mean_speed",
    "duration",
)


class SyncOptions(NamedTuple):
    """How long runs from rest are followed.

    Attributes
    ----------
    samples : int
        In a turn.
    start_up : int
        Turns that the rotors are given to start; `outcome` must watch 8/rate, 40 turns at least.
    looks : tuple[float, ...]
        Times of judgement, in units of the time that must be watched: from rest the rotors may
        start near the unstable phase. A run still undecided after the last remains so.
    max_turns : int
        Where a run ends, undecided if it is so then: 16 s by default. Where the first look would
        come later, a run of `chunk` turns only tells whether both rotors start.
    chunk : int
        Turns between two questions whether a run may end.
    steps : (int, int)
        Least steps from sample to sample, of an engine and of the reference.
    """

    samples: int = 10
    start_up: int = 10
    looks: tuple[float, ...] = (1.05, 1.6, 2.4, 3.6, 5.4, 8.1)
    max_turns: int = 400
    chunk: int = 40
    steps: tuple[int, int] = (4, 2)


OPTIONS = SyncOptions()


SEEN = ("phi_1", "phi_2", "phi_1_dot", "phi_2_dot")


@dataclass
class RunFromRest:
    """A run from rest.

    Attributes
    ----------
    point : int
    spacing : float
        Between samples [s].
    looks : list of float
        Turns after which it is judged.
    seen : list of array (4, n)
        Samples of `SEEN`.
    ends : str or None
        Its outcome; None while it goes on.
    """

    point: int
    spacing: float
    looks: list[float]
    seen: list[Array]
    ends: str | None = None

    def look(self, p: RotorPendulum, turns: int) -> None:
        """Judge the run; it goes on if it is undecided and another look is due."""
        self.looks = [look for look in self.looks if look > turns]
        seen = np.concatenate(self.seen, axis=1)
        verdict = outcome(
            self.spacing * np.arange(seen.shape[1]), dict(zip(SEEN, seen, strict=True)), p
        )
        if verdict != "undecided" or not self.looks:
            self.ends = verdict

    @property
    def end(self) -> tuple[float, float]:
        """Phase difference [rad] and mean speed [rad/s] over the last turns."""
        last = np.concatenate(self.seen, axis=1)[:, -OPTIONS.samples * OPTIONS.chunk :]
        return mean_phase(last[0] - last[1]), float(np.mean(last[2:]))


def sync(points: Points) -> QuantityValues:
    """Return the outcome of the start from rest: synchronised, not, or undecided.

    A run lasts until `mbcheck.reference.rotor_pendulum.outcome.outcome` decides, up to the last of
    the looks, or the most turns. A second run starts with rotor 1
    `NUDGE` ahead and takes half the steps' length; where it ends otherwise, or the first
    undecided, the class is not robust.
    """
    count = len(points)
    flow = Flow(points, points.scene.variants.get(points.model, points.scene))
    spacing = columns(points, period(points.parameters))[0] / OPTIONS.samples
    starts = np.zeros((8, 2 * count))
    starts[points.scene.coordinates.index("phi_1"), count:] = NUDGE
    steps = step_counts(points, spacing, OPTIONS.steps, 1)
    runs = _run(flow, starts, np.tile(spacing, 2), np.concatenate([steps, 2 * steps]))
    ends = np.array([OUTCOMES.index(run.ends or "undecided") for run in runs])
    kind, other = ends[:count], ends[count:]
    robust = ((kind == other) & (kind != OUTCOMES.index("undecided"))).astype(int)
    (alpha, phases), (speed, speeds) = np.full((2, 2, count), np.nan)
    for i in np.flatnonzero(kind == OUTCOMES.index("synchronised")):
        alpha[i], speed[i] = runs[i].end
        if robust[i] and points.engine == REFERENCE:
            phases[i], speeds[i] = runs[count + i].end
    samples = np.array([sum(part.shape[1] for part in run.seen) - 1 for run in runs[:count]])
    return flow.values(
        {
            "class": kind,
            "robust": robust,
            "phase_difference": alpha,
            "mean_speed": speed,
            "duration": samples * spacing,
            # the perturbed start may cancel a part of what the steps make
            "phase_difference_bound": 2 * difference(0 * alpha, wrapped(phases - alpha)),
            "mean_speed_bound": 2 * difference(speed, speeds),
            "duration_bound": 4 * EPS * samples * spacing,
        }
    )


def _looks(points: Points) -> Array:
    """Return turns (6, k) after which a run is judged."""
    p = points.parameters
    with np.errstate(divide="ignore"):
        (watch,) = columns(points, 8 / phase_rate(p) / period(p))
    watch = np.where(watch > 0, np.maximum(watch, 40), np.inf)
    looks = OPTIONS.start_up + np.outer(OPTIONS.looks, watch)
    return np.where(
        looks[0] > OPTIONS.max_turns, OPTIONS.chunk, np.minimum(looks, OPTIONS.max_turns)
    )


def _run(flow: Flow, states: Array, spacing: Array, steps: Ints) -> list[RunFromRest]:
    """RunFromRest from some states, each until it is decided or given up.

    The first k/2 are those of the points, the others repeat them with twice the steps; they
    end where the first ended undecided. All go on together.

    Parameters
    ----------
    flow : Flow
    states : array (8, k)
    spacing, steps : array (k,)
        Time [s] and steps between two samples.
    """
    count = len(flow.points)
    names = flow.points.scene.state_names
    seen = [names.index(name) for name in SEEN]
    looks = _looks(flow.points)
    runs = [
        RunFromRest(
            row % count, float(spacing[row]), list(looks[:, row % count]), [state[seen, None]]
        )
        for row, state in enumerate(states.T)
    ]
    states, active, turns = states.copy(), np.arange(len(runs)), 0
    while active.size:
        path = flow(
            active % count,
            states[:, active],
            turns * OPTIONS.samples * spacing[active],
            spacing[active],
            OPTIONS.chunk * OPTIONS.samples,
            steps[active],
        )
        turns += OPTIONS.chunk
        states[:, active] = path[..., -1]
        for run, part in zip((runs[row] for row in active), path.swapaxes(0, 1), strict=True):
            run.seen.append(part[seen])
            if not np.all(np.isfinite(part)):
                run.ends = "undecided"
            elif turns >= run.looks[0]:
                run.look(flow.points.one(run.point), turns)
        going = [
            row
            for row in active
            if runs[row].ends is None and runs[row % count].ends != "undecided"
        ]
        active = np.array(going, dtype=int)
    return runs
