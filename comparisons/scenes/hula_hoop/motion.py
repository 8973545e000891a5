"""Motions of `hula_hoop` from rest (figs. 5, 7), classified as in the paper's table.

With W the turns that theta makes in a period of the force, sign folded away by the mirror
theta -> pi - theta, and f_u the frequency at which theta' oscillates most:

============  ==========  =============  ===========
class         W           reversal       f_u
============  ==========  =============  ===========
``blue_o``    1           no             2 omega
``blue_plus`` 1           yes            2 omega
``cyan_o``    1           no             other
``cyan_plus`` 1           yes            other
``red_x``     not 1
============  ==========  =============  ===========
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....reference.hula_hoop.equations import HulaHoop, coefficients
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..bounds import SAFETY, difference, last_harmonics, with_bounds
from ..orbit_map import Ints
from ..quantity import (
    LONG_STEP_COUNTS,
    NO_VALUE,
    STEP_COUNTS,
    Flow,
    Points,
    QuantityValues,
    Variable,
    engine_setup,
)
from .floquet import EXACT, STABILITY, approximate_floquet, least
from .steps import step_counts

MOTIONS = ("blue_o", "blue_plus", "cyan_o", "cyan_plus", "red_x")
LABELS = (
    "rotator",
    "rest",
    "libration",
    "other_lock",
    "not_periodic",
    "unstable_rotation",
    "no_rotation",
)


NUMBERS = ("turns", "f_u", "min_speed")

MOTION_VARIABLES = with_bounds(
    {
        "motion": Variable(
            "1",
            "from rest, in the end; figs. 5, 7: one turn in a period of the force without (o) or "
            "with (plus) reversal, theta' oscillating at 2 omega (blue) or not (cyan); else red_x",
            MOTIONS,
        ),
        "label": Variable("1", "kind of motion", LABELS),
        "turns": Variable("1", "|W|, turns of theta in a period of the force"),
        "f_u": Variable("1", "frequency at which theta' oscillates most, by that of the force"),
        "min_speed": Variable("1", "least theta' in the sense of the turning, by omega"),
        "periods": Variable("1", "of the force after which the motion repeats; 0: it does not"),
        "robust": Variable("1", "1 where twice the step and a start off by 1e-6 give the same"),
    },
    *NUMBERS,
)


class MotionOptions(NamedTuple):
    """How motions from rest are followed, and classified.

    Attributes
    ----------
    steps : int
        Steps of the reference in the shortest period; a class needs few digits.
    engine_steps : tuple of int
        Of an engine, by the order of its method from 1 on: fewer than `STEPS_PER_PERIOD`.
    settling : float
        Time constants of the slower damper that motions are given to settle. They may take twice as
        long as it would: at 3 Hz, 60 N the rotation's own rate is half of that damper's.
    settling_periods : tuple[int, int]
        Least and most of it, in periods of the force.
    samples : int
        In a period of the force.
    window : int
        Periods of the force that are then watched.
    off : float
        Angle [rad] by which the start of the check is off.
    finer : int
        Samples of a sum of harmonics for each that it is made from.
    settles : float
        Largest share of the change from cycle to cycle that a quarter of the window may leave.
    still : float
        The change, by omega, below which it is rounding.
    slack : float
        Turns by which a rotation may miss one turn per period over the window.
    near : float
        How close f_u / omega must be to 2.
    repeats : float
        How closely a motion repeats, in the size of each state.
    max_cycle : int
        Most periods of the force after which it may.
    stands : float
        A theta' that never leaves its mean by more, by omega, is no oscillation.
    """

    steps: int = 12
    engine_steps: tuple[int, ...] = (200, 96, 48, 32, 24, 24)
    settling: float = 12.0
    settling_periods: tuple[int, int] = (20, 2000)
    samples: int = 24
    window: int = 120
    off: float = 1e-6
    finer: int = 8
    settles: float = 0.9
    still: float = 1e-10
    slack: float = 0.5
    near: float = 0.02
    repeats: float = 0.02
    max_cycle: int = 20
    stands: float = 1e-3


OPTIONS = MotionOptions()


def motion(points: Points, window: int = OPTIONS.window) -> QuantityValues:
    """Return the long-term motion of the scene from rest, rod across.

    It is watched for `window` periods of the force.
    ``robust`` compares it with a run of twice the step whose start is off.
    """
    if points.engine == REFERENCE and points.model != EXACT:
        return approximate_motion(points)
    flow = Flow(points, points.scene)
    per_period = OPTIONS.steps
    if points.engine != REFERENCE:
        order = engine_setup(points).integrator.order
        per_period = OPTIONS.engine_steps[min(order, len(OPTIONS.engine_steps)) - 1]
    values, check = runs_from_rest(flow, ((0.0, 1), (OPTIONS.off, 2)), per_period, window)
    same = (values["motion"] == check["motion"]) & (values["label"] == check["label"])
    known = same & (values["periods"] > 0) & (points.engine == REFERENCE)
    cut = np.where(window % np.maximum(values["periods"], 1) == 0, 0.0, 1 / window)
    turning = window * values["turns"] > OPTIONS.slack  # else the least speed is of either sense
    off = {name: values.pop(f"{name}_off") for name in ("turns", "min_speed")}
    rest = {
        "turns": off["turns"],
        "f_u": cut,
        "min_speed": np.where(turning, off["min_speed"], np.nan),
    }
    bounds = {
        f"{name}_bound": np.where(known, difference(values[name], check[name]) + rest[name], np.nan)
        for name in NUMBERS
    }
    return flow.values(values | {"robust": same.astype(int)} | bounds)


def runs_from_rest(
    flow: Flow,
    starts: Sequence[tuple[float, int]],
    per_period: float,
    window: int,
    per_force: int = OPTIONS.samples,
) -> list[dict[str, Array]]:
    """Return the variables of motions from rest, robust left out, which go on together.

    Each start is an angle [rad], and by how much longer its steps are; ``per_force`` is the number
    of samples in a period of the force.
    """
    points, number = flow.points, len(starts)
    every = np.tile(np.arange(len(points)), number)
    period = np.broadcast_to(points.scene.period(points.parameters), len(points))
    settling = settling_time(points.parameters, period)
    begin = np.zeros((4, len(every)))
    begin[1] = np.repeat([theta for theta, _ in starts], len(points))
    spacing = period / per_force

    def steps(spans: Array, counts: Ints) -> Ints:
        """Return the number of steps of each start in spans (k,)."""
        return np.concatenate(
            [step_counts(points, spans, per_period, coarser, counts) for _, coarser in starts]
        )

    settled = flow(
        every, begin, 0.0, np.tile(settling, number), 1, steps(settling, LONG_STEP_COUNTS)
    )
    watched = flow(
        every,
        settled[..., 0],
        np.tile(settling, number),
        np.tile(spacing, number),
        window * per_force,
        steps(spacing, STEP_COUNTS),
    )
    samples = np.concatenate([settled, watched], axis=2)
    parts = np.split(samples, number, axis=1)
    return [described(part, 2 * np.pi / period, per_force) for part in parts]


def settling_time(p: HulaHoop, period: Array) -> Array:
    """Return the time for transients [s], by the slower damper's time constant."""
    c = coefficients(p)
    rate = np.minimum(c.hinge_damping / c.inertia, c.damping / c.mass) / 2
    with np.errstate(divide="ignore"):
        return np.clip(
            OPTIONS.settling / rate,
            OPTIONS.settling_periods[0] * period,
            OPTIONS.settling_periods[1] * period,
        )


def described(samples: Array, omega: Array, per_force: int = OPTIONS.samples) -> dict[str, Array]:
    """Return the variables of motions, robust left out.

    Parameters
    ----------
    samples : array (4, k, periods per_force + 1)
        States over the window, both its ends included.
    omega : array (k,)
        Circular frequency of the force [rad/s].
    per_force : int
        Samples in a period of the force.
    """
    theta, speed = samples[1], samples[3] / omega[:, None]
    window = samples.shape[2] // per_force
    known = np.all(np.isfinite(samples), axis=(0, 2))
    with np.errstate(invalid="ignore"):
        turns = (theta[:, -1] - theta[:, 0]) / (2 * np.pi)
        rotates = np.abs(np.abs(turns) - window) < OPTIONS.slack
        min_speed = least(np.where(turns[:, None] < 0, -speed, speed))
        f_u = strongest(speed[:, :-1], window)
        cycle, advance_per_cycle = repetition(samples[..., ::per_force], omega)
        odd = np.abs(f_u - 2) >= OPTIONS.near
    motions = np.where(rotates, (min_speed < 0) + 2 * odd, MOTIONS.index("red_x"))
    still = np.ptp(speed, axis=1) < OPTIONS.stands
    label = np.select(
        [rotates, still, cycle == 0, advance_per_cycle == 0],
        [LABELS.index(name) for name in ("rotator", "rest", "not_periodic", "libration")],
        LABELS.index("other_lock"),
    )
    return {
        "motion": np.where(known, motions, NO_VALUE),
        "label": np.where(known, label, NO_VALUE),
        "turns": np.where(known, np.abs(turns) / window, np.nan),
        "f_u": np.where(known, f_u, np.nan),
        "min_speed": np.where(known, min_speed, np.nan),
        "periods": np.where(known, cycle, np.nan),
        "turns_off": np.abs(
            np.abs(turns) / window - np.abs(advance_per_cycle) / np.maximum(cycle, 1)
        ),
        "min_speed_off": unsettled(
            np.where(turns[:, None] < 0, -speed, speed), cycle, per_force, min_speed
        ),
    }


def unsettled(speed: Array, cycle: Array, per_force: int, lowest: Array) -> Array:
    """Return bounds (k,) on the error of the least theta', of periodic motions.

    In the end a motion is a sum of harmonics: that of the last cycle tells what lies between the
    samples, up to the harmonics that are left out; how cycles still change, and how much less they
    do so than before, shows the rest of the transient.

    Parameters
    ----------
    speed : array (k, n)
        In the sense of the turning, at samples whose last is a cycle's end.
    cycle : array (k,)
        Periods of the force after which a motion repeats; 0: it does not.
    per_force : int
        Samples in a period of the force.
    lowest : array (k,)
        The least of the samples and the parabolas through them.
    """
    off = np.full(len(lowest), np.nan)
    for periods in np.unique(cycle[cycle > 0]).astype(int):
        rows, size = np.flatnonzero(cycle == periods), periods * per_force
        count = (speed.shape[1] - 1) // size
        cycles = speed[rows, -1 - count * size : -1].reshape(len(rows), count, size)
        spectra = np.fft.rfft(cycles[:, -1], axis=1)
        fine = np.tile(OPTIONS.finer * np.fft.irfft(spectra, OPTIONS.finer * size, axis=1), 2)
        last, ratio = last_harmonics(2 / size * np.abs(spectra))
        changes = np.max(np.abs(np.diff(cycles, axis=1)), axis=2)
        part = max(1, (count - 1) // 4)
        late, before = (
            np.max(changes[:, end - part : end], axis=1) for end in (count - 1, count - 1 - part)
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(before > OPTIONS.still, late / before, 0.0)
        left = np.where(
            share < OPTIONS.settles,
            late * (1 + part / (1 - np.minimum(share, OPTIONS.settles))),
            np.nan,
        )
        at, near = least(fine), least(fine, 4)
        off[rows] = (
            np.abs(lowest[rows] - at) + np.abs(at - near) + SAFETY * last / (1 - ratio) + left
        )
    return off


def strongest(speed: Array, window: int) -> Array:
    """Return at which frequency, by that of the force, theta' (k, n) oscillates most.

    The largest peak of its spectrum over the window (Hann), its mean removed; NaN where it
    stands.
    """
    swing = speed - np.mean(speed, axis=1, keepdims=True)
    spectrum = np.abs(np.fft.rfft(swing * np.hanning(speed.shape[1] + 1)[:-1], axis=1))
    return np.where(
        np.ptp(speed, axis=1) < OPTIONS.stands, np.nan, np.argmax(spectrum, axis=1) / window
    )


def repetition(strobe: Array, omega: Array) -> tuple[Array, Array]:
    """Return after how many periods a motion repeats, 0 if not, and its turns in that time.

    Parameters
    ----------
    strobe : array (4, k, n)
        States at the same phase of the force; the later half counts.
    omega : array (k,)
    """
    later = strobe[..., strobe.shape[2] // 2 :]
    amplitude = np.max(np.hypot(later[0], later[2] / omega[:, None]), axis=1)
    amplitude = np.where(amplitude > 0, amplitude, 1.0)
    size = np.stack([amplitude, np.ones_like(omega), omega * amplitude, omega])
    cycle, turns = np.zeros((2, len(omega)))
    for periods in range(min(OPTIONS.max_cycle, (later.shape[2] - 1) // 2), 0, -1):
        cycles = (later.shape[2] - 1) // periods
        end = cycles * periods
        own = np.rint((later[1, :, end] - later[1, :, 0]) / (2 * np.pi * cycles))
        folded = later[..., :end].reshape(4, len(omega), cycles, periods).copy()
        folded[1] -= 2 * np.pi * own[:, None, None] * np.arange(cycles)[:, None]
        spread = np.max(np.ptp(folded, axis=2), axis=2) / size
        repeats = np.all(spread < OPTIONS.repeats, axis=0)
        cycle, turns = np.where(repeats, periods, cycle), np.where(repeats, own, turns)
    return cycle, turns


def approximate_motion(points: Points) -> QuantityValues:
    """Return the motion by an approximate rotation: it turns, if it is stable."""
    rotation = approximate_floquet(points).values
    stability, min_speed = rotation["stability"], rotation["min_speed"]
    stable = stability == STABILITY.index("stable")
    labels = np.array([LABELS.index(n) for n in ("rotator", "unstable_rotation", "no_rotation")])
    return QuantityValues(
        {
            "motion": np.where(stable, (min_speed < 0) * 1, MOTIONS.index("red_x")),
            "label": labels[stability],
            "turns": np.where(stable, 1.0, np.nan),
            "f_u": np.where(stable, 2.0, np.nan),
            "min_speed": np.where(stable, min_speed, np.nan),
            "periods": np.where(stable, 1.0, np.nan),
            "robust": rotation["robust"],
            "turns_bound": np.where(stable, 0.0, np.nan),
            "f_u_bound": np.where(stable, 0.0, np.nan),
            "min_speed_bound": np.where(stable, rotation["min_speed_bound"], np.nan),
        }
    )
