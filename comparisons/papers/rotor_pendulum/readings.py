"""What the rotor_pendulum paper leaves open, and what each way of reading it gives."""

from __future__ import annotations

from ..ledger import LedgerRow, reading

READINGS: tuple[LedgerRow, ...] = (
    reading(
        "motor_constants", "equation (14), table 1",
        "The motors' torque and the friction of their bearings.",
        "case 1, printed 153.8 rad/s and 3.08 N m: only constants read from it give both; the "
        "orbit is then antiphase, -3.1293 rad at 153.79 rad/s, 3.09 N m",
        reference="3.08 N m at 153.8 rad/s; alone it turns at 153.81 rad/s with 3.08 N m",
        candidates="""
        k_e = 0.94, f = 0.02 N m s/rad, from case 1's speed and torque | 3.08 N m at 153.8 rad/s;
            alone it turns at 153.81 rad/s with 3.08 N m
        k_e = 0.94 N m s/rad, no friction | 3.08 N m at 153.8 rad/s; alone it turns at 157.08 rad/s
            with 0 N m
        (14) to the letter, k_e = 1929, f = 0.02 | 6.33e+03 N m at 153.8 rad/s; alone it turns at
            157.08 rad/s with 3.14 N m
        (14) over omega_s once more, k_e = 6.14, f = 0.02 | 20.1 N m at 153.8 rad/s; alone it turns
            at 156.57 rad/s with 3.13 N m
        """,
    ),
    reading(
        "stiffness_or_ratio_1", "5.2, case 1",
        "Stiffnesses or frequency ratios, which do not belong together.",
        "case 1, printed 3.10 rad at 153.8 rad/s",
        reference="antiphase, -3.1293 rad at 153.79 rad/s, 3.09 N m",
        candidates="""
        the printed stiffnesses | antiphase, -3.1293 rad at 153.79 rad/s, 3.09 N m
        the printed ratios at 50 pi, M = 114 kg, 1.08 kg m^2 | antiphase, -2.8806 rad at 153.74
            rad/s, 3.14 N m
        the printed ratios at 50 pi, 100 kg, 9.9 kg m^2 | antiphase, -3.1296 rad at 153.79 rad/s,
            3.09 N m
        """,
    ),
    reading(
        "stiffness_or_ratio_2", "5.2, case 2",
        "Stiffnesses or frequency ratios, which do not belong together.",
        "case 2, printed -0.515 rad at 153.5 rad/s",
        reference="synphase, 0.0636 rad at 153.20 rad/s, 3.65 N m",
        candidates="""
        the printed stiffnesses | synphase, 0.0636 rad at 153.20 rad/s, 3.65 N m
        the printed ratios at 50 pi, M = 114 kg, 1.08 kg m^2 | synphase, 0.0596 rad at 153.20 rad/s,
            3.65 N m
        the printed ratios at 50 pi, 100 kg, 9.9 kg m^2 | not there
        """,
    ),
    reading(
        "hundred_kilograms", "table 1, (15)", "What table 1's 100 kg are, m_0 or M.",
        "printed: 246490000 N/m at n_x = 0.1, 2.46e6 N/m at n_x = 1, n_x = 0.4943 and 5.916, and "
        "7e-4 m in case 1. As M they make the four of these right that the cause masses has wrong, "
        "at speeds of table 1, and case 1's platform wrong, so that they are m_0 in the "
        "simulations; the rod's 9.9 kg m^2 would be (M + m_3) l^2, which is the inertia of nothing",
        reference="280998600 N/m and 2809986 N/m at 157 rad/s; 145.4 and 142.3 rad/s; 6.61e-4 m",
        candidates="""
        m_0, as printed: M = 114 kg | 280998600 N/m and 2809986 N/m at 157 rad/s; 145.4 and 142.3
            rad/s; 6.61e-4 m
        M, so that m_0 = 86 kg | 246490000 N/m and 2464900 N/m at 157 rad/s; 155.2 and 151.9 rad/s;
            6.32e-4 m
        """,
    ),
    reading(
        "motor_placement", "2.2", "Against what the second motor turns.",
        "as in (11) by default; the rotors ask for the same mean torque either way; printed: "
        "3.10 rad at 153.8 rad/s, -0.515 rad at 153.5 rad/s",
        reference="case 1: antiphase, -3.1293 rad at 153.79 rad/s, 3.09 N m; case 2: synphase, "
                  "0.0636 rad at 153.20 rad/s, 3.65 N m",
        candidates="""
        torque on the absolute angle of rotor 2, none on the rod, as in (11) | case 1: antiphase,
            -3.1293 rad at 153.79 rad/s, 3.09 N m; case 2: synphase, 0.0636 rad at 153.20 rad/s,
            3.65 N m
        motor on the rod, which bears the reaction | case 1: antiphase, -3.1293 rad at 153.79 rad/s,
            3.09 N m; case 2: synphase, 0.0735 rad at 153.19 rad/s, 3.65 N m
        """,
    ),
    reading(
        "equations", "5.2", "Exact or reduced equations.",
        "the paper integrates (11); engines have the exact equations, and so have we by "
        "default; printed: 3.10 rad at 153.8 rad/s, -0.515 rad at 153.5 rad/s",
        reference="case 1: antiphase, -3.1293 rad at 153.79 rad/s, 3.09 N m; case 2: synphase, "
                  "0.0636 rad at 153.20 rad/s, 3.65 N m",
        candidates="""
        Lagrange's equations of (7)-(9) | case 1: antiphase, -3.1293 rad at 153.79 rad/s, 3.09 N m;
            case 2: synphase, 0.0636 rad at 153.20 rad/s, 3.65 N m
        (11), its sign corrected | case 1: antiphase, -3.1293 rad at 153.79 rad/s, 3.09 N m; case 2:
            synphase, 0.0639 rad at 153.20 rad/s, 3.65 N m
        """,
    ),
    reading(
        "rod_damper", "table 1", "Damper of the rod, which decides case 2.",
        "case 2, printed -0.515 rad, 153.5 rad/s, 3.23 N m: no value of f_phi gives all three, "
        "nor does one line of torque over speed go through both cases: k_e from case 1 makes "
        "3.36 N m of 153.5 rad/s",
        reference="synphase, 0.0636 rad at 153.20 rad/s, 3.65 N m",
        candidates="""
        f_phi = 15 N m s/rad, table 1 | synphase, 0.0636 rad at 153.20 rad/s, 3.65 N m
        f_phi = 3 N m s/rad | synphase, -0.3949 rad at 153.64 rad/s, 3.23 N m
        f_phi = 0.3 N m s/rad | synphase, -0.4907 rad at 153.73 rad/s, 3.14 N m
        no damper, as in (16) | synphase, -0.5012 rad at 153.74 rad/s, 3.13 N m
        """,
    ),
    reading(
        "motor_curve", "equation (14), figures 4-6", "The motors' torque far from working speed.",
        "(14) is linearised at working speed; an induction motor's curve after Kloss has the same "
        "slope there, and its largest torque is not given. Largest difference of the speeds before "
        "both rotors are at speed, over it, and when they are, in cases 1, 2 and 3",
        reference="2.7%, 5.9%, 3.5%; 0.013, 0.013, 0.013 s",
        candidates="""
        the tangent (14), from rest on | 2.7%, 5.9%, 3.5%; 0.013, 0.013, 0.013 s
        at most 8 N m | 0.6%, 45.5%, 47.0%; 0.362, 0.507, 0.509 s
        at most 12 N m | 0.5%, 4.8%, 7.0%; 0.133, 0.137, 0.134 s
        at most 20 N m | 0.4%, 8.5%, 6.2%; 0.052, 0.052, 0.052 s
        """,
    ),
    reading(
        "inductances", "table 1, (14)", "Which inductance is the stator's.",
        "the stator's own flux contains the mutual one, so that L_s is larger than L_m; table 1 "
        "has them the other way round, if they are referred to the stator. By the corrected (14), "
        "at 153.8 rad/s, where 3.08 N m are printed; neither has it",
        reference="20.1 N m",
        candidates="""
        as printed, L_m = 0.13 H, L_s = 0.1 H | 20.1 N m
        exchanged, L_m = 0.1 H, L_s = 0.13 H | 7.05 N m
        """,
    ),
    *(
        reading(
            f"limit_3{panel}", f"5.1, figure 3({panel})",
            "Whether figure 3 has the dampers of table 1.",
            f"at beta = {angle} and n_x > 1 the text has synphase {text}. (30) and (36), which it "
            "is drawn by, leave the dampers out; with them synchronous orbits end before n_phi = "
            "1, and begin again at a fold",
            reference=by_theory,
            candidates=f"""
            no dampers, as in (30), (36) | {by_theory}
            the dampers of table 1 | {folds}
            """,
        )
        for panel, angle, text, by_theory, folds in (
            (
                "b", "pi/6", "for n_phi from 0.1 to 7",
                "synphase but for n_phi from resonance, 1.014 to 1.018 for n_x = 7 to 2, to 1.1547",
                "the fold is at n_phi = 1.6435, 1.7954, 1.9112 for n_x = 2, 3, 7",
            ),
            (
                "c", "pi/3", "for n_phi from 1 to 7",
                "synphase but for n_phi from resonance, 1.043 to 1.057 for n_x = 7 to 2, to 2.0000",
                "the fold is at n_phi = 2.0096, 2.6219, 3.3230 for n_x = 2, 3, 7",
            ),
        )
    ),
    reading(
        "duration", "5.2, case 1", "How long the simulation of case 1 is.",
        "phase of the run from rest, which starts beside the unstable one; printed 3.10 rad",
        candidates="""
        8 s | 2.34 rad
        10 s | 2.97 rad
        12 s | 3.10 rad
        14 s | 3.12 rad
        16 s | 3.13 rad
        """,
    ),
)  # fmt: skip
