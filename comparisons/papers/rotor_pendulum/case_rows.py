"""The ledger of the rotor_pendulum paper: the three cases of section 5.2."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from ..ledger import (
    CORRECTED,
    DEPENDS,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    PRINTED,
    REPRODUCED,
    ROUNDS,
    Condition,
    Erratum,
    LedgerRow,
    above,
    below,
    corrected,
    depends,
    equal,
    holds,
    number,
    statement,
)
from . import cases, derivation, starts
from .cases import WAVE
from .results import HORIZONS
from .starts import LARGEST

AGREE = 0.1
"""Distance [rad] below which two phase differences are said to agree; the paper's own two
pairs, which it calls so, are 0.09 and 0.03 apart."""
ALIKE = 0.01
"""Difference of speeds, of the working speed, up to which they count as equal."""
SMALL = 0.1
"""Share of another torque that may be called none."""
STEADY = 0.02
"""Relative change of amplitudes that are called steady."""

RATIO_ROWS: tuple[LedgerRow, ...] = tuple(
    number(
        f"case_{case}_{name}", f"5.2, case {case}",
        f"Frequency ratio {name} of the printed stiffness.",
        REPRODUCED if (case, name) == (2, "n_phi") else NOT_REPRODUCED,
        "ours at {speed:.1f} rad/s, the nearest of table 1's; it takes {takes[0]:.1f} rad/s with "
        + (
            "(m + m_3) l^2 = {inertias[0]:.4g} kg m^2 or {takes[1]:.1f} rad/s with (m_0 + m_3) "
            "l^2 = {inertias[1]:.4g} kg m^2"
            if name == "n_phi"
            else "M = {inertias[0]:.4g} kg or {takes[1]:.1f} rad/s with m_0 = {inertias[1]:.4g} kg"
        )
        + (", the lower end of table 1's range" if (case, name) == (2, "n_x") else ""),
        partial(derivation.frequency_ratio, case=case, rod=name == "n_phi", printed=printed),
        printed=printed,
    )
    for case, name, printed in (
        (1, "n_x", "0.4943"),
        (1, "n_phi", "0.4943"),
        (2, "n_x", "5.916"),
        (2, "n_phi", "5.029"),
    )
)  # fmt: skip


def orbit_rows(case: int, *rows: tuple[str, str, str, str, str, str, Any]) -> tuple[LedgerRow, ...]:
    """Return rows that compare quantities of a case's synchronous orbit with printed numbers.

    Each of name, summary, printed number, quantity, verdict, reason and the measure of its numbers.
    """
    return tuple(
        number(
            f"case_{case}_{name}", f"5.2, case {case}", summary, verdict, reason, numbers,
            partial(
                cases.orbit_quantity, case=case, quantity=quantity, sign=-1 if case_1_phase else 1
            ),
            printed=printed, slow=True,
            judgement={**holds(ROUNDS), **DEPENDENT.get((case, name), {})},
        )
        for name, summary, printed, quantity, verdict, reason, numbers in rows
        for case_1_phase in [(case, name) == (1, "phase")]
    )  # fmt: skip


PASSES = below("begin", HORIZONS[1])
"""The run from rest passes the printed phase."""
DEPENDENT = {
    (1, "phase"): depends(PASSES),
    (1, "rod_amplitude"): depends(Condition("by_print", "rounds to", PRINTED)),
}
"""What else a printed number of an orbit may come by, by case and name."""

LESS_DAMPED = (
    "f_phi = 15 takes {power:.0f} W, which the paper's theory leaves out; with f_phi = 0: {free}; "
    "with 3: {light}"
)
AMPLITUDES = "with f_phi = 0 the platform has {platform:.3g} m and the rod {rod:.3g} rad"
NO_COUPLING = (
    "on what is meant: by coupling torques the text names the curves of figures 4 (b) to 6 (b), "
    "which are the motors' torques, and these are there. The torque by which vibration couples "
    "the rotors is {share:.0%} of case 2's, by (34) {undamped:.3f} of {case_2:.2f} N m, with the "
    "dampers {first:.3f} N m: small, not absent. The damper of the rod drives the rotors apart "
    "with {mean:.2f} N m, and that ends synchronism; without f_phi the orbit is {free}"
)
ABSENT = {**holds(equal("undamped", 0)), **depends(below("share", SMALL, ours=True))}
"""Judgement of a coupling torque that is said to be absent."""

CALIBRATION = (
    "used for calibration, and so no test of the paper: k_e = 0.9391 and f = 0.0199 N m s/rad are "
    "what the printed speed and torque make"
)

ORBITS_1 = orbit_rows(
    1,
    (
        "speed", "Synchronous speed.", "153.8 rad/s", "mean_speed", REPRODUCED,
        CALIBRATION, None,
    ),
    (
        "phase", "Phase difference that the simulation settles at.", "3.10 rad",
        "phase_difference", DEPENDS,
        "modulus compared, as the paper's theory has lost its sign; the orbit has {phase:.4f} rad, "
        "{circle:.3f} rad from 3.10 on the circle. From rest the rotors pass 3.10 rad from "
        "{begin:.1f} to {end:.1f} s, on their way there: how long the simulation is, the text does "
        "not say",
        cases.phase_of_case_1,
    ),
    (
        "torque", "Torque of the motors.", "3.08 N m", "motor_torque_1", REPRODUCED,
        CALIBRATION, None,
    ),
    (
        "rod_amplitude", "Amplitude of the rod.", "7e-4 rad", "rod_amplitude", DEPENDS,
        "on how the simulation has the sign of (11), and on how the digits end: with the sign as "
        "printed it is {by_print:.3g} rad by the linear response (16), with the dampers, where the "
        "right sign gives {linear:.3g} rad; that, cut off and not rounded, is 7e-4 too",
        cases.orbit_of_case_1,
    ),
    (
        "platform_amplitude", "Amplitude of the platform.", "7e-4 m", "platform_amplitude",
        REPRODUCED, "", None,
    ),
)  # fmt: skip

ORBITS_2 = orbit_rows(
    2,
    (
        "speed", "Mean synchronous speed.", "153.5 rad/s", "mean_speed", NOT_REPRODUCED,
        LESS_DAMPED, cases.rod_damper_of_case_2,
    ),
    (
        "phase", "Phase difference that the simulation settles at.", "-0.515 rad",
        "phase_difference", NOT_REPRODUCED, LESS_DAMPED, cases.rod_damper_of_case_2,
    ),
    (
        "torque", "Torque of the motors.", "3.23 N m", "motor_torque_1", NOT_REPRODUCED,
        LESS_DAMPED, cases.rod_damper_of_case_2,
    ),
    (
        "rod_amplitude", "Amplitude of the rod.", "0.02 rad", "rod_amplitude", NOT_REPRODUCED,
        "0.02 if ours is cut off to one digit; with f_phi = 0 it is {rod:.3g} rad. Neither that "
        "damper nor the phase, nor the sign of (11), makes 0.02 rad of it",
        cases.rod_damper_of_case_2,
    ),
    (
        "platform_amplitude", "Amplitude of the platform.", "2.5e-4 m", "platform_amplitude",
        NOT_REPRODUCED, AMPLITUDES, cases.rod_damper_of_case_2,
    ),
)  # fmt: skip


def theory_rows(
    case: int, printed: str, sign: float, type_: str, span: Any
) -> tuple[LedgerRow, ...]:
    """Return the rows on a case's theoretical phase, its agreement with the orbit, and its type."""
    low, high = span
    return (
        number(
            f"case_{case}_theory", f"5.2, case {case}", "Stable phase difference by theory.",
            CORRECTED,
            ("the root is negative, the sign lost; " if sign < 0 else "")
            + "mu_1 as printed gives {as_printed:.4f} rad; at the ratios that belong to the "
            "printed stiffnesses it is {ours:.4f} rad",
            partial(cases.theoretical, case=case, sign=sign),
            judgement=corrected(ROUNDS), printed=printed, slow=True,
        ),
        statement(
            f"case_{case}_agreement", f"5.2, case {case}",
            "Simulation and theory agree in the phase difference.",
            CORRECTED if case == 1 else NOT_REPRODUCED,
            "the orbit is {value:.3f} rad from the theory's {alpha:.4f} rad at the printed "
            "stiffnesses; without f_phi {free:.3f} rad",
            partial(cases.from_theory, case=case), partial(cases.gap_to_theory, case=case),
            "{value:.3f} rad apart", judgement=corrected(below("value", AGREE, ours=True)),
            slow=True,
        ),
        statement(
            f"case_{case}_type", f"5.2, case {case}", type_, REPRODUCED,
            "n_x and n_phi of the printed stiffnesses {ratios[0]:.3g}, {ratios[1]:.3g}; as printed "
            "{ratios[2]:.4g}, {ratios[3]:.4g}",
            partial(cases.coupling_type, case=case),
            judgement=holds(above("ratios", low), below("ratios", high)), slow=True,
        ),
    )  # fmt: skip


def run_up(case: int, summary: str, verdict: str, relation: str) -> LedgerRow:
    """Return the row on the speeds of a case's rotors while they speed up."""
    either = "least" if relation == "<" else "largest"
    return statement(
        f"case_{case}_accelerations", f"5.2, case {case}", summary, verdict,
        "largest difference of the speeds before both are at the working speed, over it: by the "
        "tangent (14) from rest on {laws[0]:.1%}, by a motor's curve of the same slope and at "
        f"most {LARGEST:g} N m {{laws[1]:.1%}}; {ALIKE:.0%} would be alike",
        partial(starts.gaps, case=case), partial(cases.run_up_gap, case=case), "{value:.2%}",
        judgement={
            **holds(Condition("laws", relation, ALIKE, ours=True)),
            **depends(Condition(either, relation, ALIKE, ours=True)),
        },
        slow=True,
    )  # fmt: skip


def settles(case: int, name: str, kind: str) -> LedgerRow:
    """Return the row on how a case synchronises from rest."""
    return statement(
        f"case_{case}_{name}", f"5.2, case {case}", f"It settles in {kind} from rest.", REPRODUCED,
        kind + "; phase of the last turn from rest, the stable orbit has {target:.4f} rad",
        each=partial(cases.last_phase, case=case), reference="{end:.4f} rad",
        judgement=holds(
            below("off", 0.01, everyone=True), equal("kind", kind), equal("stable", True)
        ),
        slow=True,
    )  # fmt: skip


def displacements(case: int, relation: str, verb: str = "become") -> LedgerRow:
    """Return the row on how steady the displacements of a case become."""
    return statement(
        f"case_{case}_displacements", f"5.2, case {case}", f"The displacements {verb} steady.",
        REPRODUCED,
        "largest change of the amplitudes of x and phi_3, taken over three turns each, in the "
        "last quarter of the run",
        each=partial(cases.change_of_amplitudes, case=case), reference="{value:.1%}",
        judgement=holds(Condition("value", relation, STEADY, ours=True)), slow=True,
    )  # fmt: skip


def case_row(case: int, name: str, summary: str, *more: Any, **keywords: Any) -> LedgerRow:
    """Return the row of a claim on one case."""
    where = f"5.2, case {case}"
    return replace(statement(f"case_{case}_{name}", where, summary, *more, **keywords), slow=True)


CASE_ROWS: tuple[LedgerRow, ...] = (
    *ORBITS_1,
    *theory_rows(1, "3.013 rad", -1.0, "It is of type 1: both before resonance.", (0.1, 0.9)),
    run_up(1, "Both rotors speed up alike.", DEPENDS, "<"),
    case_row(
        1, "stiff_springs", "They do so because their inertias are the same and the springs stiff.",
        REPRODUCED,
        "difference of the speeds in case 1, and in case 2, with the same rotors and soft springs: "
        "by (14) {first[0]:.1%} and {second[0]:.1%}, by a motor's curve {first[1]:.1%} and "
        "{second[1]:.0%}",
        starts.stiffer_is_calmer, judgement=holds(above("ratios", 1)),
    ),
    statement(
        "start_differs", "5.2, cases 1, 2",
        "While the rotors speed up their speeds differ, and the phase difference is not constant.",
        DEPENDS,
        "on how long a start is. Speeds differ by up to {gaps:.1%}; the phase moves by "
        "{early:.2f} rad in the first second, by {moves:.2f} rad on the whole, and by "
        "{rests:.0e} rad in the last half second: case 1 leaves its first phase long after the "
        "rotors are at speed",
        starts.differences,
        judgement={
            **holds(above("gaps", 0), above("early", 0.1, ours=True)),
            **depends(above("gaps", 0), above("slows", 10, ours=True)),
        },
        slow=True,
    ),
    settles(1, "antiphase", "antiphase"),
    displacements(1, "<"),
    statement(
        "one_motor", "5.2", "Cases 1 and 2 have the same motors.", DEPENDS,
        "on the motors' curve and their speed without load, for which 157.08 rad/s is our choice. "
        "With it torque over slip, as rounding allows it, is {first[0]:.3f} to {first[1]:.3f} "
        "N m s/rad in case 1 and {second[0]:.3f} to {second[1]:.3f} in case 2: no line as (14) "
        "goes through both, as lines do from {onset:.2f} rad/s on; curves of an induction motor "
        "do, with a largest torque of {curves[0]:.1f} to {curves[1]:.1f} N m",
        starts.one_motor,
        judgement={**holds(above("overlap", 0)), **depends(above("curves", 3.23))},
    ),
    *ORBITS_2,
    *theory_rows(2, "-0.5474 rad", 1.0, "It is of type 3: both after resonance.", (1.1, 7.0)),
    run_up(2, "The rotors speed up differently.", REPRODUCED, ">="),
    case_row(
        2, "larger_swing", "The reason is that the rod swings more than in case 1.", REPRODUCED,
        "largest swing of the rod until both rotors are at speed, in cases 1 and 2: by (14) "
        "{first[0]:.2g} and {second[0]:.2g} rad, by a motor's curve {first[1]:.2g} and "
        "{second[1]:.2g} rad; the speeds differ more as well",
        starts.larger_swing, judgement=holds(above("ratios", 1), above("differ", 1)),
    ),
    case_row(
        2, "synphase", "The stable orbit is in synphase.", REPRODUCED, "within pi/2 of 0",
        each=partial(cases.orbit_quantity, case=2, quantity="phase_difference"),
        reference="{value:.4f} rad",
        judgement=holds(above("value", -WAVE / 4), below("value", WAVE / 4)),
    ),
    settles(2, "settles", "synphase"),
    case_row(
        2, "fluctuation", "The speed of the rotor on the rod fluctuates more than the other's.",
        REPRODUCED,
        "half the range of the speeds of rotors 1 and 2 in the last second",
        each=cases.fluctuations, reference="{first:.3f} and {second:.3f} rad/s",
        judgement=holds(above("ratio", 2)),
        erratum=Erratum(
            "tests/comparisons/papers/rotor_pendulum/test_measures.py"
            "::test_rotor_on_the_rod_fluctuates_more",
            "... of rotor 2, on the rod, is stronger than that of rotor 1",
            "the text names rotor 2 twice",
            "none",
        ),
    ),
    case_row(
        2, "amplitude_fluctuation",
        "The larger the rod swings, the more the speed of its rotor fluctuates.",
        REPRODUCED,
        "of cases 1 and 2: swing {small:.2g} and {large:.2g} rad; values: fluctuation of rotor 2",
        cases.swings, cases.fluctuations_of_rotor_2, "{first:.3f} and {second:.3f} rad/s",
        judgement=holds(above("swings", 2), above("ratio", 2)),
    ),
    case_row(
        2, "resonance_passage", "Speeding up through resonance shows in x and phi_3.",
        DEPENDS,
        "largest x and phi_3 at the start over those at the end: by the tangent (14) from rest on "
        "{linear[0]:.2f} and {linear[1]:.2f}, since the rotors are at speed after {times[0]:.3f} "
        "s, less than a turn; by a motor's curve of the same slope and at most "
        f"{LARGEST:g} N m, after {{times[1]:.2f}} s, {{curve[0]:.2f}} and {{curve[1]:.2f}}",
        starts.passages, cases.overshoot, "{ratios[0]:.2f} and {ratios[1]:.2f}",
        judgement={
            **holds(above("ratios", 2, ours=True)), **depends(above("largest", 2, ours=True)),
        },
    ),
    displacements(2, "<"),
    case_row(
        3, "unstable_phase", "The phase difference is not stable.", REPRODUCED,
        "what rotor 1 gains on rotor 2 in {duration:.3g} s, more than a turn; a synchronous orbit "
        "is {words}",
        cases.orbit_of_case_3, cases.slip, "{gain:.3f} rad",
        judgement=holds(above("size", WAVE, everyone=True), equal("kind", "none")),
    ),
    case_row(
        3, "no_coupling", "The reason is that coupling torques are absent at beta = pi/2.",
        DEPENDS, NO_COUPLING, cases.coupling_of_case_3, judgement=ABSENT,
    ),
    case_row(
        3, "torques", "The torques of the motors differ at all times.", REPRODUCED,
        "least and largest of what motor 2 gives more than motor 1, averaged over turns",
        each=cases.slip, reference="{least:.2f} to {largest:.2f} N m",
        judgement=holds(above("least", 0)),
    ),
    case_row(
        3, "rotor_1_faster", "Rotor 1 is faster during the start.", REPRODUCED,
        "mean difference of the speeds over the first 12 turns; {first:.2f} rad/s in the first "
        "turn, in which rotor 2 is ahead. By a motor's curve of the same slope and at most "
        f"{LARGEST:g} N m, {{curve:.1f}} rad/s until both are at speed",
        starts.lead_of_rotor_1, cases.slip, "{mean:.3f} rad/s",
        judgement=holds(above("mean", 0), above("curve", 0), above("ahead", 0.8)),
    ),
    displacements(3, ">=", "do not become"),
    statement(
        "case_3_unsuitable", "5.2, case 3", "Such parameters are not for use.", NOT_TESTABLE,
        "an advice, which follows from the rows above",
    ),
)  # fmt: skip
