"""The paper on hula_hoop reproduced: its figures and its ledger; here section 5.1.

C. X. Lu, C. C. Wang, C. K. Sung, P. C. P. Chao, J. Vib. Acoust. 133, 014501 (2011).
"""

from __future__ import annotations

import numpy as np

from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import nondimensional, paper_solution
from ...queries.simulate import Simulation
from ..ledger import CORRECTED, NOT_REPRODUCED, REPRODUCED, Finding, Row, claimed, number
from ..session import Session
from . import (
    derivation as hula_hoop_derivation,
)
from . import (
    readings as hula_hoop_readings,
)
from . import (
    regions as hula_hoop_regions,
)
from .figures import FIGURES
from .results import (
    APPROXIMATIONS,
    EXAMPLE,
    LOCKED,
    LONG_RUN,
    SAMPLES,
    LockIn,
    approximation_errors,
    everyone,
    example_from_rest,
    example_orbit,
    lock_in,
    second_harmonic,
    told,
)

__all__ = ["FIGURES", "ROWS"]

OMEGA = 2 * np.pi * float(EXAMPLE.force_frequency)


def main_mass_harmonic(session: Session) -> Finding:
    """Motion of the main mass, figs. 2(a), 3(a)."""

    def shares(name: str) -> tuple[float, float]:
        terms = example_orbit(session, name).harmonics["y"][1]
        return terms[0].amplitude, max(term.amplitude for term in terms[1:])

    first, rest = shares("reference")
    paper = abs(float(paper_solution(EXAMPLE).q_1)) * float(EXAMPLE.rod_length)
    return claimed(
        rest < 0.05 * first,
        f"at the frequency of the force; all other harmonics are below {rest / first:.1%} of it. "
        f"The printed solution gives {1e3 * paper:.2f} mm",
        **told(session, lambda name: f"{1e3 * shares(name)[0]:.4f} mm"),
    )


def mean_slope(session: Session) -> Finding:
    """Slope of theta, figs. 2(b), 3(b)."""
    speeds = {name: example_orbit(session, name).mean_speed or 0.0 for name in everyone(session)}
    return claimed(
        max(abs(speed / OMEGA - 1) for speed in speeds.values()) < 1e-9,
        f"mean slope omega = {OMEGA:.5f} rad/s",
        **told(session, lambda name: f"{speeds[name]:.5f} rad/s"),
    )


def speed_varies(session: Session) -> Finding:
    """Angular velocity, figs. 2(c), 3(c)."""

    def extremes(run: Simulation) -> tuple[float, float]:
        last = run.observables["theta_dot"][-1 - SAMPLES :]
        return float(np.abs(last).min()), float(np.abs(last).max())

    found = {name: extremes(example_from_rest(session, name)) for name in everyone(session)}
    least, most = found["reference"]
    swing = 2 * abs(float(paper_solution(EXAMPLE).u_1))
    return claimed(
        most - least > 0.1 * OMEGA and least > 0,
        f"in the last period of {LONG_RUN:.0f} s from rest; by the printed solution "
        f"{(1 - swing) * OMEGA:.1f} to {(1 + swing) * OMEGA:.1f} rad/s",
        **told(session, lambda name: "{:.2f} to {:.2f} rad/s".format(*found[name])),
    )


def doubled_frequency(session: Session) -> Finding:
    """Frequency of the oscillation of theta'."""

    def peak(name: str) -> float:
        periods = 12
        speed = example_from_rest(session, name).observables["theta_dot"][-periods * SAMPLES :]
        spectrum = np.abs(np.fft.rfft((speed - speed.mean()) * np.hanning(len(speed))))
        return float(np.argmax(spectrum)) / periods

    ratios = {name: peak(name) for name in everyone(session)}
    amplitude = second_harmonic(example_orbit(session))
    paper = abs(float(paper_solution(EXAMPLE).u_1))
    return claimed(
        all(abs(ratio - 2) < 0.02 for ratio in ratios.values()),
        "largest peak of the spectrum of theta' over the last 12 periods from rest; u_1 is "
        f"{amplitude:.4f} rad, by the printed solution {paper:.4f} rad",
        **told(session, lambda name: f"{ratios[name]:.3f} omega"),
    )


def locks(session: Session) -> dict[str, LockIn]:
    """Return how the reference and the engines lock in."""
    runs = {name: example_from_rest(session, name) for name in everyone(session)}
    return {
        name: lock_in(run.times, run.observables["theta"], run.observables["theta_dot"])
        for name, run in runs.items()
    }


def transient_end(session: Session) -> Finding:
    """End of the transient: the free mass turns backwards for the last time."""
    found = {name: item.last_reversal for name, item in locks(session).items()}
    truth = found.pop("reference")
    settled = locks(session)["reference"].settled
    return number(
        "1.5",
        truth,
        "s",
        found,
        "the last reversal is taken for the end; the phase stays within 0.5 rad of its end only "
        f"from {settled:.2f} s on",
    )


def locked_by_then(session: Session) -> Finding:
    """After 1.5 s the free mass turns with the force."""
    found = locks(session)
    return claimed(
        all(item.last_slip < 1.5 and abs(item.turns - 1) < LOCKED for item in found.values()),
        "the last slip by half a turn; from then on one turn per period",
        **told(session, lambda name: f"{found[name].last_slip:.2f} s"),
    )


def transient_reverses(session: Session) -> Finding:
    """The angular velocity oscillates in the transient, then keeps its sign."""
    found = locks(session)
    return claimed(
        all(item.last_reversal > 0 and item.least_speed > 0 for item in found.values()),
        "least angular velocity of the last period, by omega, after reversals before",
        **told(session, lambda name: f"{found[name].least_speed:.4f}"),
    )


def figures_2_and_3(session: Session) -> Finding:
    """Figs. 2 and 3 confirm model, equations and solution."""
    errors = approximation_errors(session)
    y, theta = ({name: float(error[i]) for name, error in errors.items()} for i in (0, 1))
    size = example_orbit(session).harmonics["y"][1][0].amplitude
    fits = {name: y[name] < 0.05 * size and theta[name] < 0.1 for name in errors}
    verdict = REPRODUCED if fits["paper"] else CORRECTED if fits["corrected"] else NOT_REPRODUCED
    return Finding(
        verdict,
        f"the printed solution misses the true rotation by up to {1e3 * y['paper']:.1f} mm and "
        f"{theta['paper']:.2f} rad: the amplitudes are fair, the phase is not. With the phase "
        f"theta_0 it is {1e3 * y['corrected']:.1f} mm and {theta['corrected']:.3f} rad",
        f"{theta['paper']:.3f} rad",
    )


def example_is_stable(session: Session) -> Finding:
    """The rotation of fig. 2 is stable by the analysis of section 4."""
    largest = {
        name: float(abs(floquet_multipliers(solve(EXAMPLE), EXAMPLE)[0]))
        for name, solve in APPROXIMATIONS.items()
    }
    printed = float(abs(floquet_multipliers(paper_solution(EXAMPLE), EXAMPLE, True)[0]))
    orbits = {name: example_orbit(session, name) for name in everyone(session)}
    right = all(o.stable for o in orbits.values()) and largest["corrected"] < 1
    verdict = REPRODUCED if right and largest["paper"] < 1 else CORRECTED
    return Finding(
        verdict if right else NOT_REPRODUCED,
        f"true, but not by the printed solution: its multiplier is {largest['paper']:.3f} (with "
        f"the misprint of (55) {printed:.3f}), with the phase theta_0 "
        f"{largest['corrected']:.3f}",
        **told(session, lambda name: f"{abs(orbits[name].floquet_multipliers[0]):.6f}"),
    )


def mass_ratio(session: Session) -> Finding:
    """Mass ratio of table 1."""
    return number("0.09", float(nondimensional(EXAMPLE).epsilon), because="1/11, rounded")


SECTION_5_1 = (
    Row(
        "mass_ratio",
        "number",
        "table 1",
        "Mass ratio m/(M + m).",
        mass_ratio,
        printed="0.09",
    ),
    Row(
        "main_mass_harmonic",
        "claim",
        "5.1, figures 2(a), 3(a)",
        "The main mass moves harmonically at the frequency of the force.",
        main_mass_harmonic,
    ),
    Row(
        "mean_slope",
        "claim",
        "5.1, figures 2(b), 3(b)",
        "The free mass turns on in one sense, on the average at the frequency of the force.",
        mean_slope,
    ),
    Row(
        "speed_varies",
        "claim",
        "5.1, figures 2(c), 3(c)",
        "Its angular velocity is not constant.",
        speed_varies,
    ),
    Row(
        "doubled_frequency",
        "claim",
        "5.1",
        "The oscillation of the rotation has twice the frequency of the main mass.",
        doubled_frequency,
    ),
    Row(
        "transient_end",
        "number",
        "5.1, figure 3",
        "End of the transient from rest.",
        transient_end,
        printed="1.5 s",
    ),
    Row(
        "locked_by_then",
        "claim",
        "5.1, figure 3",
        "After 1.5 s hula-hoop motion has set in.",
        locked_by_then,
    ),
    Row(
        "transient_reverses",
        "claim",
        "5.1, figure 3",
        "The angular velocity oscillates in the transient; in the steady state it keeps its sign.",
        transient_reverses,
    ),
    Row(
        "figures_2_and_3",
        "claim",
        "5.1",
        "Figures 2 and 3 agree and confirm model, equations and solution.",
        figures_2_and_3,
    ),
    Row(
        "example_is_stable",
        "claim",
        "4, 5.1",
        "The rotation of figure 2 is stable, and so seen in the steady state of figure 3.",
        example_is_stable,
    ),
)

ROWS: tuple[Row, ...] = (
    *hula_hoop_derivation.ROWS,
    *SECTION_5_1,
    *hula_hoop_regions.ROWS,
    *hula_hoop_readings.ROWS,
)
