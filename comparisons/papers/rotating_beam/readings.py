"""What the rotating_beam paper leaves open, and what each way of reading it gives."""

from __future__ import annotations

from ..ledger import LedgerRow, reading

READINGS: tuple[LedgerRow, ...] = (
    reading(
        "speed_of_figure_3", "3.1", "angular speed of figure 3",
        "no one speed gives all three maxima: two assumed modes have them at 7.757, 7, 6.766 "
        "rad/s; taken here: 7 rad/s",
        reference="7 rad/s",
        candidates="""
        4 rad/s | maxima 0.398, 0.392, 0.386 with two assumed modes, 0.374, 0.366, 0.36 converged;
            crossover of 0.4 kg 0.575 and 0.556
        6.766 rad/s | maxima 0.438, 0.428, 0.42 with two assumed modes, 0.397, 0.385, 0.377
            converged; crossover of 0.4 kg 0.658 and 0.632
        7 rad/s | maxima 0.439, 0.429, 0.421 with two assumed modes, 0.397, 0.385, 0.377 converged;
            crossover of 0.4 kg 0.662 and 0.635
        7.757 rad/s | maxima 0.442, 0.432, 0.424 with two assumed modes, 0.396, 0.385, 0.376
            converged; crossover of 0.4 kg 0.671 and 0.642
        10 rad/s | maxima 0.447, 0.436, 0.428 with two assumed modes, 0.393, 0.382, 0.373 converged;
            crossover of 0.4 kg 0.688 and 0.657
        15 rad/s | maxima 0.45, 0.44, 0.431 with two assumed modes, 0.386, 0.375, 0.368 converged;
            crossover of 0.4 kg 0.703 and 0.670
        """,
    ),
    reading(
        "modes_of_figure_3", "3.1", "number n of assumed modes",
        "the text only says n; at 7 rad/s 2 assumed modes come nearest to the printed maxima, "
        "within 0.0031, and are not converged",
        reference="2 assumed modes",
        candidates="""
        1 assumed mode | 0.4808, 0.4663, 0.4543: off by up to 0.0388
        2 assumed modes | 0.4389, 0.429, 0.421: off by up to 0.0031
        3 assumed modes | 0.4019, 0.392, 0.3842: off by up to 0.0401
        4 assumed modes | 0.389, 0.3772, 0.3682: off by up to 0.0530
        converged | 0.3967, 0.3854, 0.3766: off by up to 0.0453
        """,
    ),
    reading(
        "axis_of_figure_2", "figure 2", "what figure 2 is drawn over",
        "the text names neither the axis nor its range; both are drawn",
        candidates="""
        speed, curves by mass | lowered by each further 0.4 kg: yes
        mass ratio, curves by speed | lowered, and less and less: yes
        """,
    ),
    reading(
        "masses_of_responses", "3.2", "masses of figures 4 and 5",
        "the text names none; taken here: those of section 3.1, and none",
        candidates="""
        0 kg | largest deflection 1.083 m in figure 4, 0.0266 m in figure 5
        0.4 kg | largest deflection 1.864 m in figure 4, 0.0328 m in figure 5
        0.8 kg | largest deflection 2.456 m in figure 4, 0.0358 m in figure 5
        1.2 kg | largest deflection 3.332 m in figure 4, 0.0377 m in figure 5
        """,
    ),
    reading(
        "model_of_figure_4", "3.2", "equations behind figure 4",
        "the second-order equations overshoot the largest deflection by 1.5, 6.3 % with 0.4 and "
        "1.2 kg; the text prints no value that would tell; taken here: the exact ones",
        reference="1.864, 3.332 m",
        candidates="""
        exact, any deflection | 1.864, 3.332 m with 0.4 and 1.2 kg
        (14) to (16) corrected, converged | 1.893, 3.543 m with 0.4 and 1.2 kg
        (14) to (16) corrected, two modes | 1.883, 3.526 m with 0.4 and 1.2 kg
        without the second-order coupling | none: it diverges above 2.06 rad/s with 0.4 kg, and the
            hub gets to 10
        """,
    ),
    reading(
        "hub_of_figure_5", "3.2", "hub inertia of figure 5",
        "the text gives none, and prints no value that would tell. (14) to (16) as printed have "
        "none, so that 0 is the most literal reading: the largest deflection is then more than "
        "without mass by 9, 14, 16 %, and with 10 kg m^2, taken here, by 23, 35, 42 %. With all "
        "of them the angle falls and the deflection grows with the mass",
        reference="10 kg m^2",
        candidates="""
        J_h = 0 kg m^2 | angle after 10 s 0.462, 0.265, 0.186, 0.143 rad, largest deflection 0.0321,
            0.0351, 0.0365, 0.0372 m, left after the pulse 0.0016, 0.00063, 0.00065, 0.0031 m
        J_h = 10 kg m^2 | angle after 10 s 0.358, 0.227, 0.167, 0.131 rad, largest deflection
            0.0266, 0.0328, 0.0358, 0.0376 m, left after the pulse 0.0041, 0.001, 0.0079, 0.0082 m
        J_h = 100 kg m^2 | angle after 10 s 0.118, 0.0993, 0.0859, 0.075 rad, largest deflection
            0.00952, 0.0164, 0.0219, 0.0266 m, left after the pulse 0.0027, 0.0022, 0.0092, 0.011 m
        """,
    ),
    reading(
        "hub_radius_of_figures", "3", "hub radius of each figure",
        "8 m in section 3.1, 0 for figure 4, none for figure 5; taken here: 8 m for "
        "frequencies, 0 for both responses",
        reference="8 m and 0",
        candidates="""
        a = 0 m | at 7 rad/s: crossover of 0.4 kg nowhere with two assumed modes, nowhere converged;
            no maxima; figure 5: angle after 10 s 0.358, 0.227, 0.167, 0.131 rad, largest deflection
            0.0266, 0.0328, 0.0358, 0.0376 m, left after the pulse 0.0041, 0.001, 0.0079, 0.0082 m
        a = 8 m | at 7 rad/s: crossover of 0.4 kg 0.662 with two assumed modes, 0.635 converged; two
            assumed modes' maxima 0.439, 0.429, 0.421, converged maxima 0.397, 0.385, 0.377; figure
            5: angle after 10 s 0.0633, 0.045, 0.0349, 0.0284 rad, largest deflection 0.0109,
            0.0146, 0.0164, 0.0174 m, left after the pulse 0.00086, 0.0017, 0.0043, 0.0022 m
        """,
    ),
    reading(
        "damping", "3.2", "damping of figures 4 and 5",
        "the text names none and (14) to (16) have none; taken here: none. First mode with a "
        "free hub and 0.4 kg: 5.05 rad/s",
        reference="none",
        candidates="""
        0 % of critical | 1 of the amplitude is left after 10 s more
        0.1 % of critical | 0.951 of the amplitude is left after 10 s more
        1 % of critical | 0.603 of the amplitude is left after 10 s more
        """,
    ),
    reading(
        "angle_of_figure_5", "figure 5", "whose angle figure 5 (a) shows",
        "the text speaks of the free end's angular displacement: drawn and judged; after "
        "10 s both fall with the mass",
        candidates="""
        of the hub, theta | 0.3578, 0.2271, 0.1666, 0.1309 rad
        of the free end from the axis | 0.3581, 0.2272, 0.1663, 0.1313 rad
        """,
    ),
)  # fmt: skip
