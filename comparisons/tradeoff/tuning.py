"""Options of the trade-off: which steps are tried, how often, and which errors count."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SweepOptions:
    """Options of runs of scenes.

    Attributes
    ----------
    coarsest : int
        Steps in the shortest period with which a sweep begins.
    levels : int
        Largest number of halvings of the step.
    max_steps, max_first_steps : int
        Largest number of steps of a run; the second counts until a run has not failed.
    longest_run : float
        Time [s] of a run after which a sweep ends.
    samples, min_samples : int
        Samples at which runs are compared, and samples at the longest step.
    repeats, brief : int, float
        Runs whose median time counts, if they are shorter than this [s].
    gain : float
        An error above this share of that with a longer step is no gain.
    asymptotic_error : float
        Relative error up to which an order describes errors.
    periods : int
        Periods of the scene over which a stable step bounds free vibrations; runs may be shorter.
    segments : tuple of float
        Numbers of segments of a continuum.
    series_time : float
        Time limit of a series [s].
    pair_repeats : int
        Pairs of runs, of a model with a part and without it, whose times are compared.
    equal_times : float
        Share by which equal times differ.
    steps_in_period : tuple of int
        Numbers of steps in a period by which boundaries of stability are computed.
    clear_shift : float
        Shift of a boundary, in its bounds, from which on it shows the order.
    """

    coarsest: int = 4
    levels: int = 20
    max_steps: int = 1 << 15
    max_first_steps: int = 1 << 17
    longest_run: float = 4.0
    samples: int = 64
    min_samples: int = 8
    repeats: int = 3
    brief: float = 1.0
    gain: float = 0.9
    asymptotic_error: float = 0.1
    periods: int = 100
    segments: tuple[float, ...] = (6.0, 12.0, 24.0, 48.0, 64.0)
    series_time: float = 300.0
    pair_repeats: int = 7
    equal_times: float = 0.03
    steps_in_period: tuple[int, ...] = (40, 80, 160, 320, 640)
    clear_shift: float = 10.0


@dataclass(frozen=True)
class BenchOptions:
    """Options of runs of an MJCF file.

    Attributes
    ----------
    longest, finest : int
        Steps range from ``longest`` times the file's step to its ``finest``-th part.
    converged : int
        Part of the file's step with which the converged run is made.
    finer : tuple of int
        Factors by which its step is refined where it is too long; the first is a trial.
    sharpest : tuple of str
        Integrators of the converged run: the second where the first loses the state, as it does
        where joints are so strongly damped that only an implicit method is stable.
    control_share : float
        Share of half the range of a control that moving controls use.
    frequencies : tuple of float
        Range of the frequencies of moving controls [Hz].
    tried_draws, proof_draws : tuple of int
        Draws of controls by which settings are chosen, and by which a choice is proved.
    limit_distance : float
        Distance from its limits that a joint keeps in further starts, as a share of its range.
    strain, start_draws : float, int
        Opening of loops and depth of contacts [m, rad] that such starts may have; draws of each.
    closure_steps : float
        Time constant in steps of a closure as hard as `refsafe` permits.
    hard_closure : int
        Part of the file's time constants that closures have which count as exact.
    steps_at_once : int
        Steps between two checks of the state: a lost one takes long to step.
    known_share : float
        Uncertainty of the converged run, as a share of the target, up to which runs are compared.
    departure : float
        Departure of a second start, relative to the observed motion, as a share of the target: it
        shows how small errors grow.
    still : float
        Motion (m, rad) below which joints and sites count as at rest.
    min_periods : int
        Number of periods from which on a comparison makes sense.
    refinement_work : float
        Factor of time that runs with a quarter of the step take.
    margin : float
        Share of the target that a recommended setting may use, since other controls change it.
    enough : float
        Share of the target below which shorter steps of an integrator are not tried.
    repeats, brief : int, float
        Runs whose median time counts, if they are shorter than this [s].
    iterations : tuple of int
        Iterations of the solver that are tried where no setting meets the target.
    softness_share : float
        Share of the target from which on the softness of closures is reported.
    """

    longest: int = 8
    finest: int = 8
    converged: int = 8
    finer: tuple[int, ...] = (1, 4, 16, 64)
    sharpest: tuple[str, ...] = ("RK4", "implicitfast")
    control_share: float = 0.25
    frequencies: tuple[float, float] = (0.3, 1.5)
    tried_draws: tuple[int, ...] = (0, 1, 2)
    proof_draws: tuple[int, ...] = (3, 4, 5)
    limit_distance: float = 0.1
    strain: float = 1e-6
    start_draws: int = 20
    closure_steps: float = 2.5
    hard_closure: int = 16
    steps_at_once: int = 16
    known_share: float = 0.25
    departure: float = 1e-4
    still: float = 1e-6
    min_periods: int = 5
    refinement_work: float = 5.0
    margin: float = 0.5
    enough: float = 0.1
    repeats: int = 3
    brief: float = 0.02
    iterations: tuple[int, ...] = (8, 32, 128)
    softness_share: float = 0.1


SWEEP, BENCH = SweepOptions(), BenchOptions()
