"""The paper on `rotating_beam`, row by row: what it prints and claims, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh
from scipy.optimize import brentq

from ....reference.linear import linearise
from ....reference.rotating_beam.cases import FIGURE_4, FIGURE_5
from ....reference.rotating_beam.frequencies.assumed_modes import (
    best_mass_position,
    crossover,
    rest_roots,
)
from ....reference.rotating_beam.frequencies.continua import frequencies
from ....reference.rotating_beam.frequencies.numbers import Numbers
from ....reference.rotating_beam.frequencies.ritz import ritz
from ....reference.rotating_beam.frequencies.stretching import stretching
from ....reference.rotating_beam.parameters import RotatingBeam
from ....reference.rotating_beam.scene import SCENE, beam_scene
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...queries.frequencies import frequencies as find_modes
from ..ledger import NOT_TESTABLE, Finding, Row, claimed, number, shown
from .figures import FIGURES
from .misprints import MISPRINTS
from .readings import READINGS
from .results import (
    BEAM,
    FIRST_VARIABLE,
    LOADS,
    MASSES,
    PRINTED_MAXIMA,
    SPEED,
    UNIT,
    Run,
    by_engine,
    by_place,
    by_ratio,
    by_speed,
    crossed,
    curves_of_figure_3,
    free,
    free_amplitude,
    furthest,
    listed,
    loaded,
    matched,
    maximum,
    peak,
    run,
    segments,
    told_by_mass,
    top_speed,
    yes,
)

if TYPE_CHECKING:
    from ..session import Session

__all__ = ["FIGURES", "ROWS"]


# Modes at rest, section 2.2 -----------------------------------------------------------------


def engine_roots(session: Session, engine: str) -> Array:
    """Return beta_i L, i = 1, 2, 3, from an engine's frequencies at rest."""
    found = session.once(
        ("rotating_beam", "roots", engine),
        lambda: find_modes(
            SCENE.name,
            engine=engine,
            parameters={"angular_speed": 0.0, "segments": segments(session)},
            count=3,
        ),
    )
    return np.sqrt([mode.omega * UNIT for mode in found.modes])


def root(session: Session, i: int, printed: str) -> Finding:
    """Compare a root of the frequency equation."""
    found = ritz(Numbers(), count=3).omega
    words = by_engine(session, lambda name: shown(float(engine_roots(session, name)[i - 1])))
    because = "of cos cosh = -1; (11) as printed vanishes at multiples of pi instead"
    finding = number(printed, float(np.sqrt(found[i - 1])), because=because, corrected=True)
    return Finding(finding.verdict, finding.reason, finding.reference, words)


def asymptote(session: Session) -> Finding:
    """Compare (2 i - 1) pi/2 with the roots from the third on."""
    i = np.arange(3, 9)
    off = np.abs((2 * i - 1) * np.pi / 2 / rest_roots(8)[2:] - 1)
    reason = f"off by {off[0]:.1e} for i = 3, by {off[1]:.1e} for i = 4, falling"
    return claimed(bool(np.all(off < 1e-3) and np.all(np.diff(off) <= 0)), reason)


def axial_frequencies(session: Session) -> Finding:
    """Compare the first form of the axial frequencies with an extensible beam's at rest."""
    scene = beam_scene("extensible", 2, 12)
    mass, _, stiffness = linearise(scene, BEAM, np.zeros(2 * len(scene.coordinates)))
    along = slice(3, None)
    found = np.sqrt(eigh(stiffness[along, along], mass[along, along], eigvals_only=True)[:3])
    wave = np.sqrt(BEAM.youngs_modulus / BEAM.density)
    printed = (2 * np.arange(1, 4) - 1) / 2 * np.pi / BEAM.length * wave
    off = float(np.max(np.abs(printed / found - 1)))
    reason = f"largest relative difference {off:.1e} of three"
    return claimed(off < 1e-6, reason, reference=f"{listed(found, 5)} rad/s")


# Frequencies of the turning beam, section 3.1 -----------------------------------------------


def slender(session: Session) -> Finding:
    """Compare stretching with bending frequencies, and the beam that stretches with the other."""
    p = BEAM.replace(mass=LOADS[-1])
    wave = np.pi / 2 / p.length * np.sqrt(p.youngs_modulus / p.density)
    first = frequencies(BEAM.replace(angular_speed=0.0), count=1).omega[0]
    stiff, soft = (
        frequencies(p, count=1, continuum=c).omega[0] for c in ("inextensible", "extensible")
    )
    gap = 1 - soft / stiff
    reason = (
        f"first axial frequency {wave / first:.3g} times the first of bending; stretching lowers "
        f"the latter by {gap:.1e} of itself, with {LOADS[-1]} kg at the tip at {SPEED:g} rad/s"
    )
    words = by_engine(
        session,
        lambda name: (
            shown(1 - float(engine_first(session, name)) / float(stiff), digits=2)
            + " (its own error included)"
        ),
    )
    return claimed(
        bool(wave > 100 * first and 0 <= gap < 1e-3),
        reason,
        engines=words,
        reference=f"gap {gap:.2g}",
    )


def engine_first(session: Session, engine: str) -> float:
    """Return an engine's first frequency [rad/s] with the largest mass at the tip, at `SPEED`."""
    found = by_place(session, engine)
    return float(found.variables["frequency_1"][-1, -1])


def extension(session: Session) -> Finding:
    """Compare a beam that stretches much with one that does not."""
    gaps = []
    for slenderness in (100.0, BEAM.area * BEAM.length**2 / BEAM.second_moment):
        n = Numbers(0.0, 5.0)
        flapwise = stretching(n, slenderness, "flapwise", 1).omega[0]
        stretched = flapwise / ritz(n, "flapwise", 1).omega[0] - 1
        coupled = stretching(n, slenderness, count=1).omega[0]
        coriolis = coupled / np.sqrt(flapwise**2 - n.gamma**2) - 1
        gaps.append((n.gamma / np.sqrt(slenderness), stretched, coriolis))
    (large, much, turned), (small, little, _) = gaps
    reason = (
        f"at an extension parameter of {large:.2g} the first frequency changes by {much:+.2g} for "
        f"the stretch and {turned:+.2g} for the Coriolis force; at {small:.2g}, this beam's at the "
        f"same speed, by {little:+.1g} for the stretch"
    )
    return claimed(min(abs(much), abs(turned)) > 0.01 > 100 * abs(little), reason)


def lowered(frequency: Array) -> Any:
    """Return whether frequencies (masses, speeds) fall with the mass."""
    return np.all(np.diff(frequency, axis=0) < 0)


def lowered_at_tip(session: Session) -> Finding:
    """Look at the curves of figure 2."""
    found = by_speed(session).variables[FIRST_VARIABLE]
    ratio = np.mean(found, axis=1) / np.mean(found[0])
    reason = f"means over gamma 0 to 12, of the beam without mass: {listed(ratio, 3)}"
    words = by_engine(
        session, lambda name: yes(lowered(by_speed(session, name).variables[FIRST_VARIABLE]))
    )
    return claimed(bool(lowered(found)), reason, reference=yes(lowered(found)), engines=words)


def attenuated(session: Session) -> Finding:
    """Look at how far equal additions of mass lower the frequency."""

    def holds(engine: str) -> bool:
        found = by_ratio(session, engine).variables[FIRST_VARIABLE]
        return bool(np.all(np.diff(found, 2, axis=1) > 0))

    drops = -np.diff(by_speed(session).variables[FIRST_VARIABLE][:, 14])
    reason = (
        f"each further 0.4 kg lowers it by {listed(drops, 3)} at gamma = 7; convex at all speeds"
    )
    words = by_engine(session, lambda name: yes(holds(name)))
    return claimed(holds(REFERENCE), reason, reference=yes(holds(REFERENCE)), engines=words)


def rises_then_falls(session: Session) -> Finding:
    """Look at the curves of figure 3."""

    def holds(engine: str) -> bool:
        _, found = curves_of_figure_3(session, engine)
        signs = np.sign(np.diff(found[1:], axis=1))
        return bool(
            np.all(signs[:, 0] > 0) and np.all(np.count_nonzero(np.diff(signs), axis=1) == 1)
        )

    still = [best_mass_position(loaded(mass, 0.0)) for mass in LOADS]
    reason = (
        f"one rise and one fall at {SPEED:g} rad/s; without rotation only a fall (maximum at "
        f"beta = {max(still):.2g}, the first looked at)"
    )
    words = by_engine(session, lambda name: yes(holds(name)))
    return claimed(holds(REFERENCE), reason, reference=yes(holds(REFERENCE)), engines=words)


def variation(session: Session) -> Finding:
    """Look at how much the place of the mass changes the frequency."""

    def ranges(engine: str) -> Array:
        _, found = curves_of_figure_3(session, engine)
        return np.ptp(found[1:], axis=1)

    words = by_engine(session, lambda name: listed(ranges(name)))
    found = ranges(REFERENCE)
    reason = "largest less smallest dimensionless frequency, by mass"
    return claimed(bool(np.all(np.diff(found) > 0)), reason, reference=listed(found), engines=words)


def crossover_speed(session: Session, place: float) -> float:
    """Return the speed [rad/s] at which 0.4 kg cross the beam without mass at this place."""
    return session.once(
        ("rotating_beam", "crossover speed", place),
        lambda: float(brentq(lambda w: crossover(loaded(LOADS[0], w)) - place, 5, 40, rtol=1e-4)),
    )


def engine_crossover(session: Session, engine: str) -> float:
    """Return where an engine's curve of 0.4 kg crosses that without mass."""
    place, found = curves_of_figure_3(session, engine)
    roots = CubicSpline(place, found[1] - found[0]).roots(extrapolate=False)
    return float(roots[-1])


def crossover_point(session: Session) -> Finding:
    """Compare the crossover with the converged one at the speed of figure 3."""
    mine = [crossover(loaded(mass)) for mass in LOADS]
    two = [crossover(loaded(mass), modes=2) for mass in LOADS]
    because = (
        f"0.4 kg at {SPEED:g} rad/s; no one point: {listed(mine)} for 0.4, 0.8, 1.2 kg, two "
        f"assumed modes {listed(two)}; it moves with the speed and is at 0.67 for "
        f"{crossover_speed(session, 0.67):.3g} rad/s"
    )
    finding = number("0.67", mine[0], because=because)
    words = by_engine(session, lambda name: shown(engine_crossover(session, name), digits=4))
    return Finding(finding.verdict, finding.reason, finding.reference, words)


def engine_maximum(session: Session, engine: str, mass: float) -> float:
    """Return where an engine's curve of figure 3 is largest."""
    place, found = curves_of_figure_3(session, engine)
    return maximum(place, found[MASSES.index(mass)])


def best_place(session: Session, mass: float, printed: str) -> Finding:
    """Compare the best place of a mass with the converged one at the speed of figure 3."""
    top, at = furthest(session, mass)
    because = (
        f"converged, at {SPEED:g} rad/s; at no speed beyond {top:.4f} (at {at:.2g} rad/s). Two "
        f"assumed modes have the printed one, at {matched(session, mass):.4g} rad/s"
    )
    finding = number(printed, best_mass_position(loaded(mass)), because=because, digits=4)
    words = by_engine(session, lambda name: shown(engine_maximum(session, name, mass), digits=4))
    return Finding(finding.verdict, finding.reason, finding.reference, words)


def maxima_move_in(session: Session) -> Finding:
    """Look at the best places by mass."""
    two, mine = ([best_mass_position(loaded(m), modes) for m in LOADS] for modes in (2, None))
    words = by_engine(
        session, lambda name: listed(engine_maximum(session, name, mass) for mass in LOADS)
    )
    reason = f"at {SPEED:g} rad/s; with two assumed modes {listed(two)}"
    holds = all(np.all(np.diff(item) < 0) for item in (two, mine))
    return claimed(holds, reason, reference=listed(mine), engines=words)


# What is concluded of frequencies -----------------------------------------------------------

THRESHOLD = 0.67


def falls_beyond(session: Session) -> Finding:
    """Look at the curves of figure 3 beyond the threshold."""

    def holds(engine: str) -> bool:
        place, found = curves_of_figure_3(session, engine)
        return bool(np.all(np.diff(found[:, place > THRESHOLD], axis=0) < 0))

    reason = (
        f"at {SPEED:g} rad/s, and up to {crossover_speed(session, THRESHOLD):.3g} rad/s, beyond "
        f"which 0.4 kg at {THRESHOLD} raise it"
    )
    words = by_engine(session, lambda name: yes(holds(name)))
    return claimed(holds(REFERENCE), reason, reference=yes(holds(REFERENCE)), engines=words)


def rises_inside(session: Session) -> Finding:
    """Look at the curves of figure 3 inside the threshold."""

    def outer(engine: str) -> float:
        """Return the innermost place at which more mass does not raise the frequency."""
        place, found = curves_of_figure_3(session, engine)
        inside = place < THRESHOLD
        wrong = np.any(np.diff(found[:, inside], axis=0) <= 0, axis=0)
        return float(np.min(place[inside][wrong], initial=np.inf))

    def told(place: float) -> str:
        return f"not at beta = {place:.3f}" if np.isfinite(place) else "yes"

    last = min(crossover(loaded(b), loaded(a).alpha) for a, b in pairwise(LOADS))
    slowly, two = crossover(loaded(LOADS[0], 4.0)), crossover(loaded(LOADS[0]), modes=2)
    still = {a: crossover(loaded(LOADS[0], w)._replace(delta=a)) for a, w in ((1, 0.0), (0, SPEED))}
    reason = (
        f"at {SPEED:g} rad/s it holds up to {last:.3f} only, where 0.8 and 1.2 kg cross. 0.4 kg "
        f"cross the beam without mass at {crossed(slowly)} at 4 rad/s, {crossed(still[1])} at "
        f"rest, {crossed(still[0])} with a = 0; with two assumed modes at {crossed(two)}"
    )
    words = by_engine(session, lambda name: told(outer(name)))
    found = outer(REFERENCE)
    return claimed(not np.isfinite(found), reason, reference=told(found), engines=words)


def better_prediction(session: Session) -> Finding:
    """Say what is missing."""
    at = {w: crossover(loaded(LOADS[0], w)) for w in (4.0, SPEED, 15.0)}
    listing = ", ".join(f"{place:.3f} at {w:g} rad/s" for w, place in at.items())
    return Finding(
        NOT_TESTABLE,
        "the text gives no other value to be better than, and no measured one; without the "
        f"coupling a mass lowers the frequency wherever it sits; converged: {listing}",
        reference=shown(at[SPEED], digits=3),
    )


def near_0_42(session: Session) -> Finding:
    """Compare all best places with the one that is concluded."""
    mine = [best_mass_position(loaded(mass)) for mass in LOADS]
    top = [furthest(session, mass)[0] for mass in LOADS]
    words = by_engine(
        session, lambda name: listed(engine_maximum(session, name, mass) for mass in LOADS)
    )
    reason = (
        f"by mass, at {SPEED:g} rad/s; at no speed beyond {listed(top)}: 0.42 is an artefact of "
        "two assumed modes"
    )
    holds = min(abs(place - 0.42) for place in mine) <= 0.005
    return claimed(holds, reason, reference=listed(mine), engines=words)


def value_of_6(session: Session) -> Finding:
    """Compare the value of reference [6] with the converged ones."""
    mine = [best_mass_position(loaded(mass)) for mass in LOADS]
    because = f"0.4, 0.8, 1.2 kg at {SPEED:g} rad/s: {listed(mine)}, nearer to [6] than to 0.42"
    finding = number("0.4", mine[1], because=because, digits=4)
    words = by_engine(session, lambda name: shown(engine_maximum(session, name, 0.8), digits=4))
    return Finding(finding.verdict, finding.reason, finding.reference, words)


def coupling_of_6(session: Session) -> Finding:
    """Without the coupling there is no maximum at all."""
    p = BEAM.replace(mass=0.4, angular_speed=0.0)
    bare = frequencies(p.replace(mass=0.0), count=1).omega[0]
    inner = frequencies(p.replace(mass_position=0.4), count=1).omega[0]
    return Finding(
        NOT_TESTABLE,
        "[6] would have to be read; but without the coupling omega^2 is that at rest less Omega^2, "
        f"and a mass at 0.4 lowers that at rest, from {bare:.4g} to {inner:.4g} rad/s: there would "
        "be no maximum to find, at 0.4 or elsewhere",
    )


# Responses, section 3.2 ---------------------------------------------------------------------


def ramp(session: Session) -> Finding:
    """Compare the hub's speed at the end of the ramp."""

    def at_end(who: str) -> float:
        found = run(session, 4, who, LOADS[0])
        return float(found.values["theta_dot"][found.times == FIGURE_4.ramp_time][0])

    words = by_engine(session, lambda name: shown(at_end(name), "rad/s"))
    finding = number("10", at_end(REFERENCE), "rad/s", because="at t = 15 s")
    return Finding(finding.verdict, finding.reason, finding.reference, words)


def by_tip_mass(figure: int, measure: Any, unit: str, what: str) -> Callable[[Session], Finding]:
    """Return what finds whether a measure with a mass is larger than without."""

    def find(session: Session) -> Finding:
        mine, words = told_by_mass(session, figure, measure)
        evenly = "evenly" if np.all(np.diff(mine) > 0) else "not evenly"
        reason = f"{what} [{unit}] with 0, 0.4, 0.8, 1.2 kg; it grows {evenly} with the mass"
        return claimed(
            bool(np.all(mine[1:] > mine[0])), reason, reference=listed(mine), engines=words
        )

    return find


def angle_depressed(session: Session) -> Finding:
    """Compare the angles during the pulse."""

    def at_end(found: Run, p: RotatingBeam) -> float:
        return float(found.values["theta"][found.times == p.torque_period][0])

    mine, words = told_by_mass(session, 5, at_end)
    paths = np.array([run(session, 5, REFERENCE, mass).values["theta"] for mass in MASSES])
    times = run(session, 5, REFERENCE, 0.0).times
    wrong = times[np.any(np.diff(paths, axis=0) >= 0, axis=0) & (times <= FIGURE_5.torque_period)]
    start = float(wrong[-1])
    little = 100 * float(np.max(paths[:, times == start])) / mine[0]
    reason = (
        f"hub's angle [rad] after 10 s with 0, 0.4, 0.8, 1.2 kg; it falls with the mass at all "
        f"times from {start:.2g} s on, when it has come to {little:.1g} %"
    )
    holds = bool(np.all(np.diff(mine) < 0) and start < 0.2 * FIGURE_5.torque_period)
    return claimed(holds, reason, reference=listed(mine), engines=words)


def halves(found: Run, p: RotatingBeam) -> tuple[float, float]:
    """Return the amplitudes [m] of the free vibration in its first and in its second half."""
    first, second = np.array_split(np.abs(free(found, p)), 2)
    return float(np.max(first)), float(np.max(second))


def periodic(session: Session) -> Finding:
    """Look at the vibration after the pulse."""

    def kept(found: Run, p: RotatingBeam) -> float:
        first, second = halves(found, p)
        return second / first

    mine, words = told_by_mass(session, 5, kept)
    amplitude, _ = told_by_mass(session, 5, free_amplitude)
    reason = (
        f"amplitude of the second half of the free run over that of the first, by mass; amplitudes "
        f"{listed(amplitude, 3)} m; a sum of modes, nearly periodic"
    )
    holds = bool(np.all(np.abs(mine - 1) < 0.05) and np.all(amplitude > 1e-4))
    return claimed(holds, reason, reference=listed(mine), engines=words)


def deformation_increased(session: Session) -> Finding:
    """Compare the largest deformations of figure 5."""
    mine, words = told_by_mass(session, 5, peak)
    more = 100 * (mine[1:] / mine[0] - 1)
    reason = f"largest deflection [m]; more than without mass by {listed(more, 2)} %, hardly slight"
    return claimed(bool(np.all(np.diff(mine) > 0)), reason, reference=listed(mine), engines=words)


def stabilises(session: Session) -> Finding:
    """Compare the free vibrations after the pulse."""
    mine, words = told_by_mass(session, 5, free_amplitude)
    reason = (
        f"amplitude [m] after the pulse: {mine[1] / mine[0]:.2g} of that without mass for 0.4 kg, "
        f"but {mine[2] / mine[0]:.2g} and {mine[3] / mine[0]:.2g} for 0.8 and 1.2 kg; the phase at "
        "which the torque ends decides"
    )
    return claimed(bool(np.all(np.diff(mine) < 0)), reason, reference=listed(mine), engines=words)


def suppresses(session: Session) -> Finding:
    """Compare all that the mass might suppress."""
    spin_up, words = told_by_mass(session, 4, free_amplitude)
    largest = [told_by_mass(session, figure, peak)[0] for figure in (4, 5)]
    reason = (
        f"vibration left after the spin-up [m], by mass; largest deflections grow too: "
        f"{listed(largest[0])} m in figure 4, {listed(largest[1])} m in figure 5. Section 3.2 "
        "itself says so of figure 4"
    )
    holds = bool(np.all(spin_up[1:] < spin_up[0]) or np.all(largest[1][1:] < largest[1][0]))
    return claimed(holds, reason, reference=listed(spin_up), engines=words)


def damps(session: Session) -> Finding:
    """Look for anything that falls after the pulse."""
    drifts = []
    for mass in MASSES:
        found = run(session, 5, REFERENCE, mass)
        late = found.values["energy"][found.times >= FIGURE_5.torque_period]
        drifts.append(float(np.ptp(late) / np.max(found.values["energy"])))
    _, words = told_by_mass(session, 5, lambda found, p: halves(found, p)[1] / halves(found, p)[0])
    reason = (
        f"nothing damps in (1) to (16): after the pulse the energy stays, to {max(drifts):.0e} of "
        "its largest; engines: amplitude of the second half of the free run over the first, by mass"
    )
    return claimed(
        max(drifts) > 1e-3, reason, engines=words, reference=f"energy changes by {max(drifts):.0e}"
    )


# Rows ---------------------------------------------------------------------------------------

Find = Callable[["Session"], Finding]


def claim(
    name: str, where: str, words: str, find: Find, printed: str = "", slow: bool = True
) -> Row:
    """Return the row of a claim in words, or of a number that is printed."""
    return Row(name, "number" if printed else "claim", where, words, find, printed, slow=slow)


def best_place_of(mass: float) -> Row:
    """Return the row of a printed maximum of figure 3."""
    printed = f"{PRINTED_MAXIMA[mass]:g}"
    words = f"the first frequency is largest with {mass:g} kg at this share of the length"
    name = f"maximum_{mass:g}".replace(".", "_")
    find = partial(best_place, mass=mass, printed=printed)
    return claim(name, "figure 3", words, find, printed)


ROWS: tuple[Row, ...] = (
    claim(
        "extension_and_coriolis",
        "1",
        "stretch and Coriolis force matter where the extension parameter is large",
        extension,
        slow=False,
    ),
    *(
        claim(
            f"root_{i}",
            "2.2, after (11)",
            f"beta_{i} L of the cantilever at rest",
            partial(root, i=i, printed=printed),
            printed,
            slow=False,
        )
        for i, printed in enumerate(("1.875", "4.694", "7.855"), start=1)
    ),
    claim(
        "asymptote",
        "2.2, after (11)",
        "from the third on, beta_i L is nearly (2 i - 1) pi/2",
        asymptote,
        slow=False,
    ),
    claim(
        "axial_frequencies",
        "2.2",
        "axial frequencies at rest are (2 i - 1)/2 pi/L sqrt(E/rho)",
        axial_frequencies,
        slow=False,
    ),
    claim(
        "slender",
        "3.1",
        "stretching is so much faster than bending that their coupling may be left out",
        slender,
    ),
    claim(
        "lowered_at_tip", "figure 2", "a mass at the tip lowers the first frequency", lowered_at_tip
    ),
    claim(
        "attenuated",
        "figure 2",
        "the more mass there is, the less more of it lowers the frequency",
        attenuated,
    ),
    claim(
        "rises_then_falls",
        "figure 3",
        "as the mass moves out, the first frequency rises and then falls",
        rises_then_falls,
    ),
    claim(
        "variation",
        "figure 3",
        "the place changes the frequency the more, the larger the mass",
        variation,
    ),
    claim(
        "crossover",
        "figure 3",
        "the curves of all masses cross near this share of the length",
        crossover_point,
        "0.67",
    ),
    *(best_place_of(mass) for mass in LOADS),
    claim(
        "maxima_move_in",
        "figure 3",
        "the larger the mass, the farther in its best place",
        maxima_move_in,
    ),
    claim(
        "falls_beyond",
        "abstract, conclusion 1",
        "with the mass beyond 0.67 of the length, more mass lowers the first frequency",
        falls_beyond,
    ),
    claim(
        "rises_inside",
        "abstract, conclusion 1",
        "with the mass inside 0.67 of the length, more mass raises the first frequency",
        rises_inside,
    ),
    claim(
        "better_prediction",
        "conclusion 1",
        "with the second-order coupling, 0.67 is a better prediction",
        better_prediction,
        slow=False,
    ),
    claim(
        "near_0_42",
        "abstract, conclusion 2",
        "there is a best place of the mass, near 0.42 of the length",
        near_0_42,
    ),
    claim(
        "value_of_6",
        "conclusion 2",
        "reference [6] has the best place at this share of the length",
        value_of_6,
        "0.4",
    ),
    claim(
        "coupling_of_6",
        "conclusion 2",
        "reference [6] leaves out the second-order coupling, hence the difference",
        coupling_of_6,
        slow=False,
    ),
    claim("ramp", "3.2, (22)", "after the ramp the hub turns at this speed", ramp, "10 rad/s"),
    claim(
        "deformation_larger",
        "figure 4 (a)",
        "the free end deforms more with the mass than without",
        by_tip_mass(4, peak, "m", "largest deflection"),
    ),
    claim(
        "velocity_larger",
        "figure 4 (b)",
        "the free end is faster with the mass than without",
        by_tip_mass(4, top_speed, "m/s", "largest velocity"),
    ),
    claim(
        "vibration_larger",
        "figure 4",
        "a mass at the free end increases its vibration",
        by_tip_mass(4, free_amplitude, "m", "vibration left after the ramp"),
    ),
    claim(
        "angle_depressed",
        "figure 5 (a)",
        "during the pulse, the angle is smaller the larger the mass",
        angle_depressed,
    ),
    claim("periodic", "figure 5", "after the pulse a periodic vibration is left", periodic),
    claim(
        "deformation_increased",
        "figure 5 (c)",
        "under the pulse, the mass increases the deformation slightly",
        deformation_increased,
    ),
    claim("stabilises", "3.2", "the mass calms the vibration of the free end", stabilises),
    claim(
        "suppresses",
        "abstract, 3.2, conclusion 3",
        "the mass mainly suppresses the vibration",
        suppresses,
    ),
    claim("damps", "abstract, 3.2, conclusion 3", "the mass acts as a damper", damps),
    *MISPRINTS,
    *READINGS,
)
