"""The paper on rotor_pendulum reproduced: its figures, and its ledger; here section 5 and 6.

P. Fang, Y. Hou, Y. Nan, L. Yu, Journal of Vibroengineering 17(5), 2015.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from ....reference.rotor_pendulum.phase import coupling_harmonics, forced_response, wrapped
from ...engines.registry import REFERENCE
from ...maps.run import Map
from ...scenes.rotor_pendulum.phase import PHASES
from ..ledger import NOT_REPRODUCED, NOT_TESTABLE, REPRODUCED, Finding, Row, claimed, number
from ..session import Session
from . import derivation as rotor_pendulum_derivation
from .derivation import SMALL, TESTS, motor_slope
from .figures import FIGURES as FIGURES
from .results import (
    BETA_NAMES,
    BETAS,
    CASES,
    PER_SECOND,
    PRINTED_RATIOS,
    REDUCED,
    Run,
    by_engine,
    class_shares,
    everyone,
    find_orbit,
    from_rest,
    inside,
    measured,
    phase_map,
    said,
    settled,
)

ALMOST_ALL = 0.95
"""Share of a region from which on it counts as being of one kind throughout."""
SOME = 1e-3
"""Share from which on a kind counts as appearing in a region."""
FINE = 400
"""Values along each side of a region, at which the theory is asked."""
GOOD = 0.9
"""Share of points from which on two maps are said to agree."""
AGREE = 0.1
"""Distance [rad] below which two phase differences are said to agree; the paper's own two
pairs, which it calls so, are 0.09 and 0.03 apart."""

WAVE = 2 * np.pi

# Section 5.1: figure 3

Region = tuple[tuple[float, float], tuple[float, float]]


def in_region(session: Session, beta: float, region: Region) -> tuple[dict[str, float], str]:
    """Return shares of classes in a region by theory, and what orbits say, in words."""
    n_x, n_phi = np.meshgrid(*(np.linspace(*ends, FINE + 2)[1:-1] for ends in region))
    alpha = theory.stable_phase_difference(theory.Ratios(n_x, n_phi, beta=beta))
    synphase = float(np.mean(np.cos(alpha) > 0))
    true = phase_map(session, beta)
    words = said(class_shares(true, inside(true, *region)))
    return {"synphase": synphase, "antiphase": 1 - synphase}, words


def engine_words(session: Session, beta: float, region: Region) -> dict[str, str]:
    """Return shares of classes in a region by each engine's orbits."""
    words = {}
    for name in session.engines:
        shown = phase_map(session, beta, engine=name)
        where = inside(shown, *region)
        words[name] = said(class_shares(shown, where)) if np.any(where) else "no point there"
    return words


def always(beta: float, kind: str, *regions: Region) -> Callable[[Session], Finding]:
    """Return how to judge that only one kind of synchronism exists in some regions."""

    def find(session: Session) -> Finding:
        found = [in_region(session, beta, region) for region in regions]
        least = min(shares[kind] for shares, _ in found)
        return region_finding(session, beta, regions, found, least >= ALMOST_ALL)

    return find


def both(beta: float, region: Region) -> Callable[[Session], Finding]:
    """Return how to judge that both kinds of synchronism exist in a region."""

    def find(session: Session) -> Finding:
        shares, words = in_region(session, beta, region)
        holds = min(shares["synphase"], shares["antiphase"]) >= SOME
        return region_finding(session, beta, (region,), [(shares, words)], holds)

    return find


def region_finding(
    session: Session,
    beta: float,
    regions: tuple[Region, ...],
    found: list[tuple[dict[str, float], str]],
    holds: bool,
) -> Finding:
    """Judge by theory; tell what true orbits are."""
    theory_words = "; ".join(said(shares) for shares, _ in found)
    orbit_words = "; ".join(words for _, words in found)
    cosine = float(np.cos(beta) ** 2)
    turn = f"the phase passes +-pi/2 at n_phi = {1 / np.sqrt(cosine):.3g} and at resonance"
    engines = [engine_words(session, beta, region) for region in regions]
    return claimed(
        holds,
        f"share of the region by (30), (36): {theory_words}; {turn}. True orbits, with the "
        f"dampers: {orbit_words}",
        corrected=True,
        reference=theory_words,
        engines={name: "; ".join(one[name] for one in engines) for name in session.engines},
    )


BEFORE, AFTER = (0.1, 1.0), (1.0, 7.0)


def level_phases(session: Session) -> Finding:
    """Phase at beta = 0: pi before, 0 after resonance of the platform."""
    shown = phase_map(session, 0.0, "theory")
    before, after = inside(shown, BEFORE, (0.0, 8.0)), inside(shown, AFTER, (0.0, 8.0))
    alpha = shown.variables["phase_difference"]
    off = max(np.max(abs(wrapped(alpha[before] - np.pi))), np.max(abs(alpha[after])))
    n = theory.Ratios(0.5, 2.0, beta=0.0)
    printed = float(theory.stable_phase_difference(n, as_printed=True))

    def tell(name: str) -> str:
        found = phase_map(session, 0.0, engine="" if name == REFERENCE else name)
        return ", ".join(
            f"n_x {sign} 1: {said(class_shares(found, inside(found, x, (0.0, 8.0))))}"
            for sign, x in (("<", BEFORE), (">", AFTER))
        )

    return claimed(
        bool(off < 1e-6),
        f"by (30), (36) pi and 0 to {off:.0e} rad; with mu_1 as printed n_phi would decide, and "
        f"the phase at n_x = 0.5, n_phi = 2 be {printed:.2g}. Values: true orbits",
        corrected=True,
        **everyone(session, tell),
    )


def rod_spring_unimportant(session: Session) -> Finding:
    """At beta = 0 the phase does not depend on n_phi."""

    def spread(shown: Map) -> float:
        """Largest distance along n_phi from the median phase of a column, off resonance."""
        column = abs(shown.x.values - 1) > SMALL
        phase = np.exp(1j * shown.variables["phase_difference"][:, column])
        middle = np.nanmean(phase, axis=0)
        return float(np.nanmax(abs(np.angle(phase / middle))))

    def tell(name: str) -> str:
        shown = phase_map(session, 0.0, engine="" if name == REFERENCE else name)
        lost = np.mean(shown.variables["class"] == PHASES.index("none"))
        return f"by up to {spread(shown):.2g} rad, no orbit on {lost:.0%}"

    by_theory = spread(phase_map(session, 0.0, "theory"))
    return claimed(
        by_theory < 1e-6,
        f"along n_phi the phase of the theory varies by {by_theory:.0e} rad. Values: true orbits, "
        "where the damper f_phi, which the theory leaves out, brings n_phi back in",
        corrected=True,
        **everyone(session, tell),
    )


def theory_against_orbits(session: Session) -> Finding:
    """Theory is verified by simulations: over figure 3."""
    shares, lost, gaps = [], [], []
    for beta in BETAS:
        shown, true = phase_map(session, beta, "theory"), phase_map(session, beta)
        mine, its = shown.variables["class"], true.variables["class"]
        shares.append(float(np.mean(mine == its)))
        lost.append(float(np.mean(its >= PHASES.index("unstable"))))
        phases = (one.variables["phase_difference"] for one in (shown, true))
        apart = abs(wrapped(np.subtract(*phases)))
        gaps.append(float(np.median(apart[its < PHASES.index("unstable")])))
    words = ", ".join(
        f"beta = {name}: {share:.0%} of classes agree, {none:.0%} without a stable orbit, median "
        f"difference {gap:.2g} rad"
        for name, share, none, gap in zip(BETA_NAMES, shares, lost, gaps, strict=True)
    )
    return claimed(
        min(shares) >= GOOD,
        f"{words}; the dampers of table 1, above all f_phi, which (30) leaves out, shift phases "
        "and end synchronism around n_phi = 1 to 2",
        corrected=True,
        engines={name: engine_agreement(session, name) for name in session.engines},
    )


def engine_agreement(session: Session, engine: str) -> str:
    """Return the share of an engine's points whose class is the theory's."""
    shares = []
    for beta in BETAS:
        found = phase_map(session, beta, engine=engine)
        n_x, n_phi = np.meshgrid(found.x.values, found.y.values)
        alpha = theory.stable_phase_difference(theory.Ratios(n_x, n_phi, beta=beta))
        kinds = np.where(np.cos(alpha) > 0, 0, 1)
        shares.append(f"{np.mean(found.variables['class'] == kinds):.0%}")
    return " / ".join(shares)


# Section 5.2: the three cases


def ratio(printed: str, case: int, rod: bool, session: Session) -> Finding:
    """Compare a printed frequency ratio with that of the stiffness printed beside it."""
    p = CASES[case]
    c, n = coefficients(p), theory.ratios(p)
    if rod:
        value, stiffness, unit = n.n_phi, c.rod_stiffness, "kg m^2"
        inertias = {
            "(m + m_3) l^2": c.end_mass * c.length**2,
            "(m_0 + m_3) l^2": (c.platform + c.rod) * c.length**2,
        }
    else:
        value, stiffness, unit = n.n_x, c.stiffness, "kg"
        inertias = {"M": c.mass, "m_0": c.platform}
    takes = " or ".join(
        f"{float(printed) * float(np.sqrt(stiffness / inertia)):.1f} rad/s with {symbol} = "
        f"{float(inertia):.4g} {unit}"
        for symbol, inertia in inertias.items()
    )
    speed = float(operating_speed(p))
    return number(printed, float(value), because=f"ours at {speed:.1f} rad/s; it takes {takes}")


def orbit_number(
    printed: str, case: int, quantity: str, unit: str, sign: float = 1.0, because: Any = None
) -> Callable[[Session], Finding]:
    """Return how to compare a quantity of a case's synchronous orbit."""

    def find(session: Session) -> Finding:
        p = CASES[case]
        engines = {name: sign * value for name, value in by_engine(session, p, quantity).items()}
        value = sign * measured(find_orbit(session, p), quantity)
        words = because(session) if because else ""
        return number(printed, value, unit, engines, words)

    return find


def constants_read_here(session: Session) -> str:
    """Say what case 1 is no test of."""
    p = CASE_1
    slip = float(p.synchronous_speed) - 153.8
    return (
        f"k_e and f are read from case 1's speed and torque (3.08 N m over {slip:.2f} rad/s of "
        f"slip is {3.08 / slip:.3g} N m s/rad), so that this is no test of the paper"
    )


def torque_slip(session: Session) -> str:
    """Say how the torque hangs on the speed."""
    speed = measured(find_orbit(session, CASE_1), "mean_speed")
    return (
        f"k_e times the slip: 153.8 rad/s would make {0.94 * (50 * np.pi - 153.8):.4g} N m, ours "
        f"is {speed:.3f} rad/s"
    )


def lost_sign(session: Session) -> str:
    """Say how far the phases are apart on the circle."""
    phase = measured(find_orbit(session, CASE_1), "phase_difference")
    return (
        f"modulus compared, as the paper's theory has lost its sign; ours is {phase:.4f} rad, "
        f"{abs(float(wrapped(phase - 3.10))):.3f} rad from 3.10 on the circle"
    )


def lost_power(session: Session) -> str:
    """Say what the rod's damper does to case 2."""
    found = find_orbit(session, CASE_2)
    power = np.nan if found is None else -found.power["rod"]
    free, light = settled(
        session, [CASE_2.replace(rod_damping=0.0), CASE_2.replace(rod_damping=3.0)]
    )
    return (
        f"f_phi = 15 takes {power:.0f} W, which the paper's theory leaves out; with f_phi = 0: "
        f"{free.words}; with 3: {light.words}"
    )


def amplitudes_without_damper(session: Session) -> str:
    """Say what the amplitudes of case 2 are without the rod's damper."""
    free = find_orbit(session, CASE_2.replace(rod_damping=0.0))
    x, phi_3 = (measured(free, f"{name}_amplitude") for name in ("platform", "rod"))
    return f"with f_phi = 0 the platform has {x:.3g} m and the rod {phi_3:.3g} rad"


def linear_amplitude(session: Session) -> str:
    """Say what the linear response is in case 1."""
    phase = measured(find_orbit(session, CASE_1), "phase_difference")
    _, swing = forced_response(CASE_1, phase)
    return f"the linear response (16), with the dampers, is {abs(complex(swing)):.3g} rad"


def theoretical(printed: str, case: int, sign: float) -> Finding:
    """Compare the paper's theoretical phase, at its own frequency ratios."""
    n = PRINTED_RATIOS[case]
    value = sign * float(theory.stable_phase_difference(n))
    wrong = sign * float(theory.stable_phase_difference(n, as_printed=True))
    ours = float(theory.stable_phase_difference(theory.ratios(CASES[case])))
    lost = "the root is negative, the sign lost; " if sign < 0 else ""
    return number(
        printed,
        value,
        "rad",
        because=f"{lost}mu_1 as printed gives {wrong:.4f} rad; at the ratios that belong to the "
        f"printed stiffnesses it is {ours:.4f} rad",
        corrected=True,
    )


def phase_sign(session: Session) -> Finding:
    """The theoretical phase of case 1 without its sign."""
    n = PRINTED_RATIOS[1]
    size = abs(float(theory.stability(n, theory.stable_phase_difference(n))))
    residuals = [abs(float(theory.balance(n, alpha))) / size for alpha in (3.013, -3.013)]
    return claimed(
        residuals[1] < 1e-3 < SMALL < residuals[0],
        f"(30) is off by {residuals[0]:.2g} of its amplitude at +3.013 rad, by {residuals[1]:.1g} "
        "at -3.013 rad",
        corrected=True,
    )


def near_theory(case: int) -> Callable[[Session], Finding]:
    """Return how to judge that simulation and theory agree in a case."""

    def find(session: Session) -> Finding:
        p = CASES[case]
        alpha = float(theory.stable_phase_difference(theory.ratios(p)))

        def gap(name: str) -> float:
            phase = measured(find_orbit(session, p, name), "phase_difference")
            return float(abs(wrapped(phase - alpha)))

        free = settled(session, [p.replace(rod_damping=0.0)])[0]
        return claimed(
            gap(REFERENCE) < AGREE,
            f"the orbit is {gap(REFERENCE):.3f} rad from the theory's {alpha:.4f} rad at the "
            f"printed stiffnesses; without f_phi {abs(float(wrapped(free.phase - alpha))):.3f} rad",
            corrected=True,
            **everyone(session, lambda name: f"{gap(name):.3f} rad apart"),
        )

    return find


def turn_means(run: Run, values: Any) -> Any:
    """Return means over turns, about 42 samples each."""
    turn = round(PER_SECOND * WAVE / float(operating_speed(run.parameters)))
    count = len(values) // turn
    return values[: count * turn].reshape(count, turn).mean(axis=1)


RUN_UP = 0.02
"""Time [s] in which the motors speed up: four time constants m r^2 / (k_e + f)."""


def run_up_gap(run: Run) -> float:
    """Largest difference of the rotors' speeds while they speed up, over the working speed."""
    early = run.times <= RUN_UP
    gap = np.max(abs(run.states[5] - run.states[6])[early])
    return float(gap / operating_speed(run.parameters))


ALIKE = 0.01
"""Difference of speeds, of the working speed, up to which they count as equal."""


def acceleration_claim(case: int) -> Callable[[Session], Finding]:
    """Return how to judge whether the rotors speed up alike: in case 1, not in case 2."""

    def find(session: Session) -> Finding:
        gaps = {name: run_up_gap(from_rest(session, case, name)) for name in names(session)}
        alike = gaps[REFERENCE] < ALIKE
        return claimed(
            alike == (case == 1),
            f"largest difference of the speeds within {RUN_UP:g} s of the start, of the working "
            "speed",
            **everyone(session, lambda name: f"{gaps[name]:.2%}"),
        )

    return find


def names(session: Session) -> tuple[str, ...]:
    """Return the reference and the engines."""
    return (REFERENCE, *session.engines)


def settles(case: int, kind: str) -> Callable[[Session], Finding]:
    """Return how to judge that a case synchronises from rest."""

    def find(session: Session) -> Finding:
        orbit = find_orbit(session, CASES[case])
        target = measured(orbit, "phase_difference")

        def end(name: str) -> float:
            return float(turn_means(run := from_rest(session, case, name), run.phase)[-1])

        ends = {name: end(name) for name in names(session)}
        antiphase = np.cos(ends[REFERENCE]) < 0
        holds = all(abs(wrapped(value - target)) < 0.01 for value in ends.values())
        return claimed(
            holds and antiphase == (kind == "antiphase") and bool(orbit and orbit.stable),
            f"{kind}; phase of the last turn from rest, the stable orbit has {target:.4f} rad",
            **everyone(session, lambda name: f"{ends[name]:.4f} rad"),
        )

    return find


STEADY = 0.02
"""Relative change of amplitudes that are called steady."""


def steady(case: int) -> Callable[[Session], Finding]:
    """Return how to judge whether displacements end with constant amplitudes."""

    def find(session: Session) -> Finding:
        def change(name: str) -> float:
            run = from_rest(session, case, name)
            parts = run.states[:, 3 * len(run.times) // 4 :]
            turn = 3 * round(PER_SECOND * WAVE / float(operating_speed(run.parameters)))
            count = parts.shape[1] // turn
            spans = np.ptp(parts[[0, 3], : count * turn].reshape(2, count, turn), axis=2)
            return float(np.max(np.ptp(spans, axis=1) / np.mean(spans, axis=1)))

        found = {name: change(name) for name in names(session)}
        return claimed(
            (found[REFERENCE] < STEADY) == (case != 3),
            "largest change of the amplitudes of x and phi_3, taken over three turns each, in the "
            "last quarter of the run",
            **everyone(session, lambda name: f"{found[name]:.1%}"),
        )

    return find


def ripple(run: Run) -> Any:
    """Half the range of both speeds in the last second [rad/s]."""
    return np.ptp(run.states[5:7, run.last], axis=1) / 2


def rotor_2_fluctuates(session: Session) -> Finding:
    """Speed of the rotor on the rod fluctuates more."""
    found = {name: ripple(from_rest(session, 2, name)) for name in names(session)}
    return claimed(
        bool(found[REFERENCE][1] > 2 * found[REFERENCE][0]),
        "half the range of the speeds of rotors 1 and 2 in the last second; the text names rotor 2 "
        "twice, and means more than rotor 1",
        **everyone(session, lambda name: "{:.3f} and {:.3f} rad/s".format(*found[name])),
    )


def amplitude_and_fluctuation(session: Session) -> Finding:
    """A larger swing of the rod means larger fluctuation of the speed."""

    def both_cases(name: str) -> tuple[float, ...]:
        runs = [from_rest(session, case, name) for case in (1, 2)]
        swings = [float(np.ptp(run.states[3, run.last]) / 2) for run in runs]
        return (*swings, *(float(ripple(run)[1]) for run in runs))

    found = {name: both_cases(name) for name in names(session)}
    swing_1, swing_2, first, second = found[REFERENCE]
    return claimed(
        swing_2 > 2 * swing_1 and second > 2 * first,
        f"of cases 1 and 2: swing {swing_1:.2g} and {swing_2:.2g} rad; values: fluctuation of "
        "rotor 2",
        **everyone(session, lambda name: "{2:.3f} and {3:.3f} rad/s".format(*found[name])),
    )


def resonance_passage(session: Session) -> Finding:
    """Resonant responses while the rotors speed up in case 2."""

    def overshoot(name: str) -> Any:
        run = from_rest(session, 2, name)
        early = run.times < 0.5
        settled_size = np.max(abs(run.states[[0, 3], run.last]), axis=1)
        return np.max(abs(run.states[[0, 3]][:, early]), axis=1) / settled_size

    found = {name: overshoot(name) for name in names(session)}
    run = from_rest(session, 2)
    fast = run.times[np.argmax(run.states[5] > 0.9 * float(operating_speed(CASE_2)))]
    return claimed(
        bool(np.min(found[REFERENCE]) > 2),
        "largest x and phi_3 in the first 0.5 s over those at the end. With motors as strong as "
        f"case 1 has them, a rotor is at 90 % of its speed after {1e3 * fast:.0f} ms, less than a "
        "turn: there is no time for resonance. The paper's motors, of which (14) tells too little, "
        "may be slower",
        **everyone(session, lambda name: "{:.2f} and {:.2f}".format(*found[name])),
    )


def synphase_case_2(session: Session) -> Finding:
    """Case 2 is in synphase."""

    def tell(name: str) -> float:
        return measured(find_orbit(session, CASE_2, name), "phase_difference")

    return claimed(
        abs(tell(REFERENCE)) < np.pi / 2,
        "within pi/2 of 0",
        **everyone(session, lambda name: f"{tell(name):.4f} rad"),
    )


def coupling_type(case: int, low: float, high: float) -> Finding:
    """Both ratios of a case lie in a range."""
    n = theory.ratios(CASES[case])
    printed = PRINTED_RATIOS[case]
    values = [float(value) for value in (n.n_x, n.n_phi, printed.n_x, printed.n_phi)]
    return claimed(
        low < min(values) and max(values) < high,
        "n_x and n_phi of the printed stiffnesses {:.3g}, {:.3g}; as printed {:.4g}, {:.4g}".format(
            *values
        ),
    )


def no_phase(session: Session) -> Finding:
    """No constant phase difference in case 3."""
    runs = {name: from_rest(session, 3, name) for name in names(session)}
    gains = {
        name: float(run.phase[-1] - run.phase[run.after(1.0)][0]) for name, run in runs.items()
    }
    duration = float(runs[REFERENCE].times[-1]) - 1
    orbit = settled(session, [CASE_3])[0]
    return claimed(
        min(abs(gain) for gain in gains.values()) > WAVE and orbit.kind == "none",
        f"what rotor 1 gains on rotor 2 in {duration:.3g} s, more than a turn; a synchronous orbit "
        f"is {orbit.words}",
        **everyone(session, lambda name: f"{gains[name]:.3f} rad"),
    )


def no_coupling(session: Session) -> Finding:
    """The reason given for case 3: no coupling torque at beta = pi/2."""
    mean, first = (complex(value) for value in coupling_harmonics(CASE_3))
    free = settled(session, [CASE_3.replace(rod_damping=0.0)])[0]
    undamped = float(
        theory.coupling_amplitude(CASE_3.replace(platform_damping=0.0, rod_damping=0.0))
    )
    return claimed(
        undamped < 1e-6,
        f"the coupling torque is small, {abs(first):.3f} N m at most (by (34) {undamped:.3f} N m), "
        f"not absent; the damper of the rod drives the rotors apart with {abs(mean):.2f} N m, and "
        f"that ends synchronism. Without f_phi the orbit is {free.words}",
    )


def unequal_torques(session: Session) -> Finding:
    """Torques of the motors differ at all times in case 3."""

    def gap(name: str) -> Any:
        run = from_rest(session, 3, name)
        first, second = (turn_means(run, torque) for torque in run.torques)
        return (second - first)[8:]

    found = {name: gap(name) for name in names(session)}
    return claimed(
        bool(np.min(found[REFERENCE]) > 0),
        "least and largest of what motor 2 gives more than motor 1, averaged over turns",
        **everyone(session, lambda name: f"{found[name].min():.2f} to {found[name].max():.2f} N m"),
    )


def rotor_1_faster(session: Session) -> Finding:
    """In case 3 rotor 1 is faster while the rotors start."""

    def gap(name: str) -> Any:
        run = from_rest(session, 3, name)
        return turn_means(run, run.states[5] - run.states[6])[:12]

    found = {name: gap(name) for name in names(session)}
    first = found[REFERENCE][0]
    return claimed(
        bool(np.mean(found[REFERENCE]) > 0 and np.mean(found[REFERENCE] > 0) > 0.8),
        f"mean difference of the speeds over the first 12 turns; {first:.2f} rad/s in the first "
        "turn, in which rotor 2 is ahead",
        **everyone(session, lambda name: f"{np.mean(found[name]):.3f} rad/s"),
    )


# Section 6


def springs_and_angle(session: Session) -> Finding:
    """Existence and stability depend on springs and installation angle."""
    words = []
    kinds = set()
    for name, beta in zip(BETA_NAMES, BETAS, strict=True):
        shares = class_shares(phase_map(session, beta), Ellipsis)
        kinds |= {kind for kind, share in shares.items() if share > SOME}
        words.append(f"beta = {name}: {said(shares)}")

    def tell(engine: str) -> str:
        found = [class_shares(phase_map(session, beta, engine=engine), Ellipsis) for beta in BETAS]
        return "; ".join(said(shares) for shares in found)

    return claimed(
        {"synphase", "antiphase", "none"} <= kinds,
        f"true orbits over n_x and n_phi, with the dampers: {'; '.join(words)}",
        engines={name: tell(name) for name in session.engines},
    )


def screens(session: Session) -> Finding:
    """Vibrating screens may be designed with it."""
    return Finding(NOT_TESTABLE, "an outlook on use, of which the paper gives no numbers")


# Readings


def reading(
    session: Session,
    candidates: dict[str, RotorPendulum],
    goal: Callable[[Any], bool],
    reason: str,
    model: str = "exact",
) -> Finding:
    """Tell what each reading gives; the first is ours, and is judged by a printed value."""
    found = settled(session, list(candidates.values()), model)
    words = [one.words for one in found]
    return Finding(
        REPRODUCED if goal(found[0]) else NOT_REPRODUCED,
        reason,
        words[0],
        candidates=tuple(zip(candidates, words, strict=True)),
    )


def printed_speed(found: Any) -> bool:
    """Whether an orbit has the printed speed of case 1."""
    return bool(abs(found.speed - 153.8) < 0.05)


def motor_constants(session: Session) -> Finding:
    """How (14) and friction are read."""
    readings = {
        "k_e = 0.94, f = 0.02 N m s/rad, from case 1's speed and torque": CASE_1,
        "k_e = 0.94 N m s/rad, no friction": CASE_1.replace(friction=0.0),
        f"(14) to the letter, k_e = {motor_slope(1):.4g}, f = 0.02": CASE_1.replace(
            motor_slope=motor_slope(1)
        ),
        f"(14) over omega_s once more, k_e = {motor_slope(2):.3g}, f = 0.02": CASE_1.replace(
            motor_slope=motor_slope(2)
        ),
    }
    words = []
    for p in readings.values():
        slope, speed = float(p.motor_slope), float(operating_speed(p))
        words.append(
            f"{slope * (50 * np.pi - 153.8):.3g} N m at 153.8 rad/s; alone it turns at "
            f"{speed:.2f} rad/s with {slope * (50 * np.pi - speed):.3g} N m"
        )
    orbit = settled(session, [CASE_1])[0]
    return Finding(
        REPRODUCED if printed_speed(orbit) else NOT_REPRODUCED,
        "case 1, printed 153.8 rad/s and 3.08 N m: only constants read from it give both; the "
        f"orbit is then {orbit.words}",
        words[0],
        candidates=tuple(zip(readings, words, strict=True)),
    )


def stiffness_or_ratio(case: int) -> Callable[[Session], Finding]:
    """Return how to judge whether stiffnesses or frequency ratios of a case are meant."""

    def find(session: Session) -> Finding:
        p, n = CASES[case], PRINTED_RATIOS[case]
        c, w = coefficients(p), float(p.synchronous_speed)
        inertia = c.end_mass * c.length**2
        mistaken = (c.platform + c.rod) * c.length**2

        def with_ratios(mass: float, turned: float) -> RotorPendulum:
            return p.replace(
                platform_stiffness=mass * (w / n.n_x) ** 2,
                rod_stiffness=turned * (w / n.n_phi) ** 2,
            )

        candidates = {
            "the printed stiffnesses": p,
            f"the printed ratios at 50 pi, M = {c.mass:g} kg, {inertia:.3g} kg m^2": with_ratios(
                c.mass, inertia
            ),
            f"the printed ratios at 50 pi, {c.platform:g} kg, {mistaken:.3g} kg m^2": with_ratios(
                c.platform, mistaken
            ),
        }
        printed, speed = {1: ("3.10", 153.8), 2: ("-0.515", 153.5)}[case]
        return reading(
            session,
            candidates,
            lambda found: bool(abs(found.speed - speed) < 0.05),
            f"case {case}, printed {printed} rad at {speed} rad/s",
        )

    return find


def placement(session: Session) -> Finding:
    """What the second motor turns against."""
    return by_choice(
        session,
        lambda case, choice: (
            settled(session, [CASES[case].replace(motor_placement=choice)])[0].words
        ),
        {
            "absolute": "torque on the absolute angle of rotor 2, none on the rod, as in (11)",
            "relative": "motor on the rod, which bears the reaction",
        },
        "as in (11) by default; the rotors ask for the same mean torque either way",
    )


def equations(session: Session) -> Finding:
    """Which equations are simulated."""
    return by_choice(
        session,
        lambda case, choice: settled(session, [CASES[case]], choice)[0].words,
        {"exact": "Lagrange's equations of (7)-(9)", REDUCED: "(11), its sign corrected"},
        "the paper integrates (11); engines have the exact equations, and so have we by default",
    )


def by_choice(
    session: Session,
    words: Callable[[int, str], str],
    choices: dict[str, str],
    reason: str,
) -> Finding:
    """Tell what choices give in cases 1 and 2; judged by the printed speed of case 1."""
    found = {
        about: f"case 1: {words(1, choice)}; case 2: {words(2, choice)}"
        for choice, about in choices.items()
    }
    ours = settled(session, [CASE_1])[0]
    return Finding(
        REPRODUCED if printed_speed(ours) else NOT_REPRODUCED,
        f"{reason}; printed: 3.10 rad at 153.8 rad/s, -0.515 rad at 153.5 rad/s",
        next(iter(found.values())),
        candidates=tuple(found.items()),
    )


def rod_damper(session: Session) -> Finding:
    """Damper of the rod in case 2."""
    return reading(
        session,
        {
            "f_phi = 15 N m s/rad, table 1": CASE_2,
            "f_phi = 3 N m s/rad": CASE_2.replace(rod_damping=3.0),
            "f_phi = 0.3 N m s/rad": CASE_2.replace(rod_damping=0.3),
            "no damper, as in (16)": CASE_2.replace(rod_damping=0.0),
        },
        lambda found: bool(abs(wrapped(found.phase + 0.515)) < 0.0005),
        "case 2, printed -0.515 rad, 153.5 rad/s, 3.23 N m: no value of f_phi gives all three, nor "
        f"does one line of torque over speed go through both cases: k_e from case 1 makes "
        f"{float(CASE_2.motor_slope) * (50 * np.pi - 153.5):.2f} N m of 153.5 rad/s",
    )


# The ledger

CLAIM, NUMBER, READING = "claim", "number", "reading"


def _case_rows(case: int, name: str, *rows: tuple[str, str, str, Any, str]) -> tuple[Row, ...]:
    """Return rows (name, kind, claim, find, printed) of a case; all of them take a while."""
    return tuple(
        Row(f"{name}_{own}", kind, f"5.2, case {case}", claim, find, printed, slow=True)
        for own, kind, claim, find, printed in rows
    )


FIG_3_ROWS = (
    Row(
        "level_phase",
        CLAIM,
        "5.1, figure 3(a)",
        "Without installation angle the phase is pi for n_x < 1 and 0 for n_x > 1.",
        level_phases,
        slow=True,
    ),
    Row(
        "level_rod_spring",
        CLAIM,
        "5.1, figure 3(a)",
        "Without installation angle the rod's spring has little influence on the phase.",
        rod_spring_unimportant,
        slow=True,
    ),
    Row(
        "fig_3b_antiphase",
        CLAIM,
        "5.1, figure 3(b)",
        "beta = pi/6, n_x < 1, n_phi > 1: antiphase.",
        always(np.pi / 6, "antiphase", (BEFORE, AFTER)),
        slow=True,
    ),
    Row(
        "fig_3b_both",
        CLAIM,
        "5.1, figure 3(b)",
        "beta = pi/6, n_x < 1, n_phi < 1: both antiphase and synphase appear.",
        both(np.pi / 6, (BEFORE, BEFORE)),
        slow=True,
    ),
    Row(
        "fig_3b_synphase",
        CLAIM,
        "5.1, figure 3(b)",
        "beta = pi/6, n_x > 1: always synphase.",
        always(np.pi / 6, "synphase", (AFTER, (0.1, 7.0))),
        slow=True,
    ),
    Row(
        "fig_3c_antiphase",
        CLAIM,
        "5.1, figure 3(c)",
        "beta = pi/3, n_x < 1, n_phi < 1: antiphase.",
        always(np.pi / 3, "antiphase", (BEFORE, BEFORE)),
        slow=True,
    ),
    Row(
        "fig_3c_both",
        CLAIM,
        "5.1, figure 3(c)",
        "beta = pi/3, n_x < 1, n_phi > 1: both appear.",
        both(np.pi / 3, (BEFORE, AFTER)),
        slow=True,
    ),
    Row(
        "fig_3c_synphase",
        CLAIM,
        "5.1, figure 3(c)",
        "beta = pi/3, n_x > 1, n_phi > 1: synphase.",
        always(np.pi / 3, "synphase", (AFTER, AFTER)),
        slow=True,
    ),
    Row(
        "fig_3d_antiphase",
        CLAIM,
        "5.1, figure 3(d)",
        "beta = 5 pi/12, n_x < 1, n_phi < 1: antiphase.",
        always(5 * np.pi / 12, "antiphase", (BEFORE, BEFORE)),
        slow=True,
    ),
    Row(
        "fig_3d_both",
        CLAIM,
        "5.1, figure 3(d)",
        "beta = 5 pi/12, n_x > 1, n_phi < 2.7: both appear.",
        both(5 * np.pi / 12, (AFTER, (0.1, 2.7))),
        slow=True,
    ),
    Row(
        "fig_3d_synphase",
        CLAIM,
        "5.1, figure 3(d)",
        "beta = 5 pi/12, elsewhere: synphase.",
        always(5 * np.pi / 12, "synphase", (BEFORE, AFTER), (AFTER, (2.7, 7.0))),
        slow=True,
    ),
    Row(
        "theory_against_orbits",
        CLAIM,
        "abstract, 6",
        "Simulations verify the theory.",
        theory_against_orbits,
        slow=True,
    ),
)

CASE_ROWS = (
    *_case_rows(
        1,
        "case_1",
        (
            "speed",
            NUMBER,
            "Synchronous speed.",
            orbit_number("153.8", 1, "mean_speed", "rad/s", because=constants_read_here),
            "153.8 rad/s",
        ),
        (
            "phase",
            NUMBER,
            "Phase difference that the simulation settles at.",
            orbit_number("3.10", 1, "phase_difference", "rad", -1.0, lost_sign),
            "3.10 rad",
        ),
        (
            "torque",
            NUMBER,
            "Torque of the motors.",
            orbit_number("3.08", 1, "motor_torque_1", "N m", because=torque_slip),
            "3.08 N m",
        ),
        (
            "rod_amplitude",
            NUMBER,
            "Amplitude of the rod.",
            orbit_number("7e-4", 1, "rod_amplitude", "rad", because=linear_amplitude),
            "7e-4 rad",
        ),
        (
            "platform_amplitude",
            NUMBER,
            "Amplitude of the platform.",
            orbit_number("7e-4", 1, "platform_amplitude", "m"),
            "7e-4 m",
        ),
        (
            "theory",
            NUMBER,
            "Stable phase difference by theory.",
            lambda session: theoretical("3.013", 1, -1.0),
            "3.013 rad",
        ),
        (
            "agreement",
            CLAIM,
            "Simulation and theory agree in the phase difference.",
            near_theory(1),
            "",
        ),
        (
            "type",
            CLAIM,
            "It is of type 1: both before resonance.",
            lambda session: coupling_type(1, 0.1, 0.9),
            "",
        ),
        ("accelerations", CLAIM, "Both rotors speed up alike.", acceleration_claim(1), ""),
        ("antiphase", CLAIM, "It settles in antiphase from rest.", settles(1, "antiphase"), ""),
        ("displacements", CLAIM, "The displacements become steady.", steady(1), ""),
    ),
    *_case_rows(
        2,
        "case_2",
        (
            "speed",
            NUMBER,
            "Mean synchronous speed.",
            orbit_number("153.5", 2, "mean_speed", "rad/s", because=lost_power),
            "153.5 rad/s",
        ),
        (
            "phase",
            NUMBER,
            "Phase difference that the simulation settles at.",
            orbit_number("-0.515", 2, "phase_difference", "rad", because=lost_power),
            "-0.515 rad",
        ),
        (
            "torque",
            NUMBER,
            "Torque of the motors.",
            orbit_number("3.23", 2, "motor_torque_1", "N m", because=lost_power),
            "3.23 N m",
        ),
        (
            "rod_amplitude",
            NUMBER,
            "Amplitude of the rod.",
            orbit_number("0.02", 2, "rod_amplitude", "rad", because=amplitudes_without_damper),
            "0.02 rad",
        ),
        (
            "platform_amplitude",
            NUMBER,
            "Amplitude of the platform.",
            orbit_number("2.5e-4", 2, "platform_amplitude", "m", because=amplitudes_without_damper),
            "2.5e-4 m",
        ),
        (
            "theory",
            NUMBER,
            "Stable phase difference by theory.",
            lambda session: theoretical("-0.5474", 2, 1.0),
            "-0.5474 rad",
        ),
        (
            "agreement",
            CLAIM,
            "Simulation and theory agree in the phase difference.",
            near_theory(2),
            "",
        ),
        (
            "type",
            CLAIM,
            "It is of type 3: both after resonance.",
            lambda session: coupling_type(2, 1.1, 7.0),
            "",
        ),
        ("accelerations", CLAIM, "The rotors speed up differently.", acceleration_claim(2), ""),
        ("synphase", CLAIM, "The stable orbit is in synphase.", synphase_case_2, ""),
        ("settles", CLAIM, "It settles in synphase from rest.", settles(2, "synphase"), ""),
        (
            "fluctuation",
            CLAIM,
            "The speed of the rotor on the rod fluctuates more than the other's.",
            rotor_2_fluctuates,
            "",
        ),
        (
            "amplitude_fluctuation",
            CLAIM,
            "The larger the rod swings, the more the speed of its rotor fluctuates.",
            amplitude_and_fluctuation,
            "",
        ),
        (
            "resonance_passage",
            CLAIM,
            "Speeding up through resonance shows in x and phi_3.",
            resonance_passage,
            "",
        ),
        ("displacements", CLAIM, "The displacements become steady.", steady(2), ""),
    ),
    *_case_rows(
        3,
        "case_3",
        ("unstable_phase", CLAIM, "The phase difference is not stable.", no_phase, ""),
        (
            "no_coupling",
            CLAIM,
            "The reason is that coupling torques are absent at beta = pi/2.",
            no_coupling,
            "",
        ),
        ("torques", CLAIM, "The torques of the motors differ at all times.", unequal_torques, ""),
        ("rotor_1_faster", CLAIM, "Rotor 1 is faster during the start.", rotor_1_faster, ""),
        ("displacements", CLAIM, "The displacements do not become steady.", steady(3), ""),
    ),
)

RATIOS = (
    (1, "n_x", "0.4943"),
    (1, "n_phi", "0.4943"),
    (2, "n_x", "5.916"),
    (2, "n_phi", "5.029"),
)
RATIO_ROWS = tuple(
    Row(
        f"case_{case}_{name}",
        NUMBER,
        f"5.2, case {case}",
        f"Frequency ratio {name} of the printed stiffness.",
        partial(ratio, printed, case, name == "n_phi"),
        printed,
    )
    for case, name, printed in RATIOS
)

OTHER_ROWS = (
    Row(
        "phase_sign",
        "misprint",
        "5.2, case 1",
        "Sign of the theoretical phase difference.",
        phase_sign,
        "3.013 rad",
        TESTS + "test_the_papers_phases_need_the_corrected_coefficient",
    ),
    Row(
        "springs_and_angle",
        CLAIM,
        "abstract, 6",
        "Springs and installation angle decide on existence and stability of synchronism.",
        springs_and_angle,
        slow=True,
    ),
    Row(
        "critical_conclusion",
        CLAIM,
        "6",
        "At beta = pi/2 there is no coupling torque, and so no stable phase.",
        no_coupling,
        slow=True,
    ),
    Row("screens", CLAIM, "6", "Elliptical vibrating screens may be designed with it.", screens),
    Row(
        "motor_constants",
        READING,
        "equation (14), table 1",
        "The motors' torque and the friction of their bearings.",
        motor_constants,
        slow=True,
    ),
    Row(
        "stiffness_or_ratio_1",
        READING,
        "5.2, case 1",
        "Stiffnesses or frequency ratios, which do not belong together.",
        stiffness_or_ratio(1),
        slow=True,
    ),
    Row(
        "stiffness_or_ratio_2",
        READING,
        "5.2, case 2",
        "Stiffnesses or frequency ratios, which do not belong together.",
        stiffness_or_ratio(2),
        slow=True,
    ),
    Row(
        "motor_placement",
        READING,
        "2.2",
        "Against what the second motor turns.",
        placement,
        slow=True,
    ),
    Row(
        "equations",
        READING,
        "5.2",
        "Exact or reduced equations.",
        equations,
        slow=True,
    ),
    Row(
        "rod_damper",
        READING,
        "table 1",
        "Damper of the rod, which decides case 2.",
        rod_damper,
        slow=True,
    ),
)

ROWS: tuple[Row, ...] = (
    *rotor_pendulum_derivation.ROWS,
    *FIG_3_ROWS,
    *RATIO_ROWS,
    *CASE_ROWS,
    *OTHER_ROWS,
)
