"""What starts from rest come to, against their own equations in extended precision."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.maps.request import axis_names
from mbcheck.comparisons.scenes.hula_hoop import motion
from mbcheck.comparisons.scenes.quantity import Points
from mbcheck.comparisons.scenes.rotor_pendulum.steps import fastest_rate
from mbcheck.comparisons.scenes.rotor_pendulum.synchronism import OPTIONS, OUTCOMES, sync
from mbcheck.reference import get_scene
from mbcheck.reference.rotor_pendulum.equations import period
from mbcheck.tests.support.exact import orbits as exact
from mbcheck.tests.support.exact.motions import followed, from_rest

pytestmark = pytest.mark.skipif(
    not exact.EXTENDED, reason="no numbers with more digits than doubles on this platform"
)


def hoops(count: int, spread: float, damping: float) -> Points:
    """Return points of the window of figures 5 and 7, other parameters so many decades off."""
    rng, known = np.random.default_rng(count), get_scene("hula_hoop")
    values = {
        name: value * 10 ** rng.uniform(-spread, spread, count)
        for name, value in known.parameters().as_dict().items()
        if not isinstance(value, str)
    }
    values["hinge_damping_ratio"] *= damping
    values["inertia_ratio"] = rng.choice([0.0, 1.0], count)
    values["force_frequency"] = rng.uniform(1, 10, count)
    values["force_amplitude"] = rng.uniform(5, 150, count)
    places = np.arange(count)[:, None] * np.array([[1000, 0]])
    return Points(known, known.parameters().replace(**values), places, {}, REFERENCE, "exact")


@pytest.mark.parametrize(
    ("count", "spread", "damping", "window"),
    [
        pytest.param(10, 0.05, 4.0, 60, marks=pytest.mark.slow),
        pytest.param(80, 0.15, 1.0, motion.OPTIONS.window, marks=pytest.mark.campaign),
    ],
)
def test_hoops_come_to_what_is_said(count: int, spread: float, damping: float, window: int) -> None:
    points = hoops(count, spread, damping)
    found = motion.motion(points, window).values
    period = np.broadcast_to(points.scene.period(points.parameters), count)
    parameters = exact.stacked([points.one(i) for i in range(count)])
    settling = motion.settling_time(points.parameters, period)
    ends = from_rest(parameters, settling, window)
    robust = [i for i in range(count) if found["robust"][i] and ends[i].periods]
    assert len(robust) > count / 2
    assert [motion.MOTIONS[found["motion"][i]] for i in robust] == [ends[i].motion for i in robust]
    for name in motion.NUMBERS:
        shares = np.array(
            [
                abs(found[name][i] - value) / found[f"{name}_bound"][i]
                for i in robust
                if found["periods"][i] == ends[i].periods
                for value in [
                    abs(ends[i].turns) / ends[i].periods
                    if name == "turns"
                    else getattr(ends[i], name)
                ]
                if np.isfinite(found[f"{name}_bound"][i])
            ]
        )
        known = shares[shares > 0]
        print(
            f"{name}: {len(shares)} of {count} known, largest error/bound {shares.max():.3g}, "
            f"median of bound/error {np.median(1 / known) if known.size else np.inf:.3g}"
        )
        assert shares.size > 0.1 * count
        assert np.max(shares) <= 1


def rotors(count: int) -> Points:
    """Return points of the window of figure 2: where the start is soon decided, or of all of it."""
    rng, known = np.random.default_rng([2, 78]), get_scene("rotor_pendulum")
    axes, drawn = axis_names("rotor_pendulum"), rng.uniform(0.2, 3, (2, WINDOW))
    chosen = np.array(SOON) if count == len(SOON) else np.arange(count)
    parameters = known.parameters()
    for name, values in zip(("n_x", "n_phi"), drawn[:, chosen], strict=True):
        parameters = axes[name].apply(parameters, values)
    places = np.arange(count)[:, None] * np.array([[1000, 0]])
    return Points(known, parameters, places, {}, REFERENCE, "exact")


WINDOW = 32
SOON = 2, 17, 22
"""Points whose class is known after 80 turns: one that does not synchronise, and two that do."""

LAST = 400
"""Samples over which phase and speed are means."""


@pytest.mark.parametrize(
    "count",
    [
        pytest.param(len(SOON), marks=pytest.mark.slow),
        pytest.param(WINDOW, marks=pytest.mark.campaign),
    ],
)
def test_rotors_synchronise_as_is_said(count: int) -> None:
    """An eighth of the time longer than the map watched them, and with its numbers at its end."""
    points = rotors(count)
    found = sync(points).values
    spacing = np.broadcast_to(period(points.parameters), count) / OPTIONS.samples
    ends = np.rint(found["duration"] / spacing).astype(int)
    steps = np.ceil(np.broadcast_to(fastest_rate(points.parameters), count) * spacing).astype(int)
    shares: dict[str, list[float]] = {"phase_difference": [], "mean_speed": []}
    for number in np.unique(steps):
        rows = np.flatnonzero(steps == number)
        p = exact.stacked([points.one(int(i)) for i in rows])
        x = np.zeros((8, len(rows)), dtype=exact.LONG)
        longest = 9 * int(np.max(ends[rows])) // 8
        path = followed(
            exact.rotor_pendulum, x, exact.LONG(0), spacing[rows].astype(exact.LONG) / number, p,
            longest * number,
        )[::number]  # fmt: skip
        for i, states in zip(rows, np.moveaxis(path, -1, 0), strict=True):
            if not found["robust"][i]:
                continue
            phase, mark = states[: 9 * ends[i] // 8 + 1, 1:3] @ [1, -1], ends[i]
            locked = OUTCOMES[found["class"][i]] == "synchronised"
            # one rotor may gain its turns slowly
            strayed = np.ptp(phase[mark if locked else mark // 2 :].astype(float))
            assert strayed < 0.5 if locked else strayed > 2 * np.pi
            if locked:
                last = slice(mark - LAST + 1, mark + 1)
                true = np.angle(np.mean(np.exp(1j * phase[last].astype(complex))))
                apart = abs(found["phase_difference"][i] - true)
                shares["phase_difference"].append(
                    min(apart, abs(2 * np.pi - apart)) / found["phase_difference_bound"][i]
                )
                speed = float(np.mean(states[last, 5:7]))
                apart = abs(found["mean_speed"][i] - speed)
                shares["mean_speed"].append(apart / found["mean_speed_bound"][i])
    for name, values in shares.items():
        print(
            f"{name}: {len(values)} of {count}, largest error/bound {max(values):.3g}, median of "
            f"bound/error {1 / np.median(values):.3g}"
        )
        assert max(values) <= 1
