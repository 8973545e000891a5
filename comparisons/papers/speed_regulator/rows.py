"""The ledger of the speed_regulator paper, and its figures.

S. Vlase, M. Mihalcica, M. L. Scutaru, "Determining the Functional Parameters of a Simple Speed
Regulator" (2018).
"""

from __future__ import annotations

from ..ledger import (
    CORRECTED,
    NOT_TESTABLE,
    REPRODUCED,
    Cause,
    LedgerRow,
    above,
    below,
    equal,
    holds,
    misprint,
    statement,
)
from . import motions
from .derivation_rows import DERIVATION, TESTS
from .figures import FIGURES as FIGURES
from .limit import BRAKING
from .motions import AWAY, CLOSE, INERTIAS
from .readings import READINGS
from .results import STARTS, TORQUE

PRINTED_SPEED = "5.07 rad/s"

MOTIONS: tuple[LedgerRow, ...] = (
    statement(
        "formula_21", "equation (21)",
        "Stabilised speed from torque, damper and lengths.",
        REPRODUCED,
        "(21) over the limit cycle's speed, less 1, for c = 2, 3, 4; its exact average would "
        "change that by {change:.0e} only. The rest is the speed's variation in a turn, which "
        "averaging leaves out, and grows as the speed falls",
        each=motions.own_rotations, reference="{errors:+.2%}",
        judgement=holds(below("largest", CLOSE)), slow=True,
    ),
    statement(
        "asymptote", "1, 4",
        "Averaging in van der Pol's manner gives the speed.",
        REPRODUCED,
        f"with J = {', '.join(f'{value:g}' for value in INERTIAS)} kg m^2 the limit cycle is "
        "faster than the exact average by {errors:.1e}: an asymptote, its error going as "
        "J^{slope:.2f}",
        motions.asymptote, reference="{errors:.1e}", judgement=holds(below("off", 0.05)), slow=True,
    ),
    statement(
        "linear_law", "3, figure 3",
        "The stabilised speed grows linearly with the torque, for several dampers.",
        REPRODUCED,
        f"from {AWAY:g} times the least torque of a rotation to {TORQUE[1]:g} N m each curve lies "
        "within {bend:.1%} of its height of a straight line for c = 2, 3, 4, and (21) within "
        "{apart:.1%}; from the least torque itself ({least:.4f} N m) within {near:.1%}. Where the "
        "axis of figure 3 begins is not in the text",
        motions.linear_law, motions.speeds_of_figure_3, "{bend:.1%}",
        "within {gap:.1e} of the reference",
        holds(below("bend", CLOSE, ours=True)), slow=True,
    ),
    statement(
        "energy_balance", "3, 4",
        "At the operating speed the damper takes what the motor gives.",
        REPRODUCED,
        "the damper's work over the motor's in the last turn of the run from 6 rad/s with c = 4, "
        "which is {faster:.1%} faster than the limit cycle yet",
        each=motions.work_ratio, reference="{ratio:.3f}",
        judgement=holds(below("error", CLOSE, everyone=True)), slow=True,
    ),
    statement(
        "stabilised_speed", "3, figure 4", "Speed at which the motion stabilises.", NOT_TESTABLE,
        "used for calibration, and so no test of the paper: M_m/(c l^2) is chosen to have it. "
        "(21) then gives 5.0683 rad/s, and the limit cycle has 5.0712 rad/s",
        reference="5.0712 rad/s", printed=PRINTED_SPEED,
    ),
    misprint(
        "unit_of_the_speed", "caption of figure 4",
        "Unit of the stabilised angular speed.",
        CORRECTED,
        "M_m/(c l^2) is a rate: (21) gives 5.07 in any unit of length, and the text below says "
        "rad/s; a speed in m/s, that of the crank pin, would be 1.27 with r = 0.25 m",
        printed="m/s",
        test=TESTS + "test_the_stabilised_speed_is_no_length_per_time",
        corrected="omega_st = 5.07 rad/s",
        why="(21) gives a rate; the text below the figure has rad/s",
        effect="none",
    ),
    statement(
        "stabilises", "2, 3",
        "Under a constant torque the speed becomes constant on average.",
        REPRODUCED,
        "change of the mean speed over the last ten turns of 200 s from 8 rad/s; a deviation "
        "falls by {multipliers[0]:.4f} in each turn",
        motions.limit_cycles, motions.last_speeds, "{drift:.1e}",
        judgement=holds(below("drift", 1e-2, everyone=True)), slow=True,
    ),
    statement(
        "independent_of_start", "3, figure 4",
        "Different initial conditions end at the same speed.",
        REPRODUCED,
        f"from {', '.join(f'{v:g}' for v in STARTS)} rad/s, a spread of "
        f"{STARTS[-1] - STARTS[0]:g} rad/s; after 200 s it is {{spread:.3f}} rad/s, and falls by "
        "{lost[0]:.1%} in each turn",
        motions.limit_cycles, motions.last_speeds, "{speeds:.4f} rad/s",
        judgement=holds(below("spread", 0.01 * (STARTS[-1] - STARTS[0]), everyone=True)), slow=True,
    ),
    statement(
        "damping_slows", "3, figure 5",
        "A stronger damper stabilises at a lower speed, from the same start.",
        REPRODUCED,
        "for c = 2, 3, 4; by (21) in inverse proportion: c times the speed is {products:.2f} N/m",
        each=motions.own_rotations, reference="{speeds:.4f} rad/s",
        judgement=holds(below("changes", 0, everyone=True)), printed="c = 2, 3, 4", slow=True,
    ),
    statement(
        "quasi_uniform", "abstract, 4",
        "The stabilised rotation is nearly uniform.",
        REPRODUCED,
        "the speed varies in a turn by {variation:.1%} of its mean for c = 2, 3, 4; below, in the "
        "last turn of the runs of figure 5",
        motions.limit_cycles, motions.variation_of_runs, "{last:.1%}",
        judgement=holds(below("variation", 0.1)), slow=True,
    ),
    statement(
        "braked", "3, figure 6",
        "Where the damper takes more than the motor gives, a damped vibration results.",
        REPRODUCED,
        "with {torque:g} N m and c = {damping:g} N s/m, below the least torque of a rotation, "
        "{least:.4f} N m: turns get slower, the last one does not come over the spring, and a "
        "damped vibration about a position of rest is left",
        motions.braked, motions.end_of_braking, "{end} after {reversals} reversals",
        judgement=holds(equal("end", "rest", everyone=True), below("gain", 1e-9)), slow=True,
    ),
    BRAKING,
    statement(
        "phase_space", "3, figure 7",
        "Trajectories of the slider in its phase plane go to a limit cycle.",
        REPRODUCED,
        "trajectories of the slider from 6 and 1.5 rad/s close in on one curve, c = 4: gap of "
        "their mean speeds in the first and last turn of 100 s (multiplier {multipliers[2]:.4f})",
        motions.limit_cycles, motions.closing_in, "{first:.3f} to {last:.3f} rad/s",
        judgement=holds(below("left", 0.02, everyone=True)), slow=True,
    ),
    statement(
        "limit_cycle_stable", "abstract, 4",
        "Limit cycles and their stability are established.",
        REPRODUCED,
        "Floquet multipliers for c = 2, 3, 4; they are exp(-integral of c y_phi^2/(J omega)) < 1 "
        "for every damper. The paper shows trajectories and no criterion; the engines' factors "
        "are from their runs",
        motions.limit_cycles, motions.decay, "{multipliers:.5f}",
        "c = 4: a deviation falls by {value:.3f} in each turn",
        holds(above("multipliers", 0), below("multipliers", 1)), slow=True,
    ),
    statement(
        "conditions", "abstract, 3, 4",
        "What a nearly uniform rotation takes is derived: the balance (20).",
        REPRODUCED,
        "as a balance: (20) asks for the torque that the limit cycle has to within {errors:+.2%} "
        "for c = 2, 3, 4. That there is a rotation is a condition of its own: from {least:.4f} "
        "N m on, which depends on the spring and is not in the paper",
        motions.least_torques_of_rotation, motions.own_rotations, "{errors:+.2%}",
        judgement=holds(below("largest", CLOSE, ours=True)), slow=True,
    ),
    statement(
        "design", "4",
        "A damper for an imposed speed can be chosen by the formula.",
        REPRODUCED,
        "the damper that (21) asks for, tried on the equation of motion: off by {errors[0]} at "
        "5.07 rad/s; {errors[1]} at 2.5 rad/s; {errors[2]} at 1.5 rad/s; {errors[3]} at 1 rad/s. "
        "Good while a turn is much shorter than the crank's swing on the spring",
        motions.designs, reference="{errors}", judgement=holds(below("second", CLOSE)),
    ),
    statement(
        "resonance", "4", "Resonance conditions are studied.", NOT_TESTABLE,
        "named in the conclusions; no equation, number or figure is about it. The crank's own "
        "vibrations about its positions of rest, without torque and damper: right 0.942 rad/s, "
        "left 0.988 rad/s",
        reference="right 0.942 rad/s, left 0.988 rad/s",
    ),
)  # fmt: skip

ROWS: tuple[LedgerRow, ...] = (*DERIVATION, *MOTIONS, *READINGS)

CLOSING_SECTION = "4"

CAUSES: tuple[Cause, ...] = (
    Cause(
        "signs_of_14",
        "The matrix of (14) has lost the minus signs of (13) in its fourth row",
        ("row_4_of_14", "reactions_do_no_work"),
    ),
    Cause(
        "half_slope",
        "The derivative of the moment of inertia in (18) is half of what (17) needs",
        ("equation_17", "factor_of_18"),
    ),
)
