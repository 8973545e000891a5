"""What the speed_regulator paper leaves open, and what each way of reading it gives."""

from __future__ import annotations

from ..ledger import LedgerRow, reading

READINGS: tuple[LedgerRow, ...] = (
    reading(
        "missing_parameters", "3", "Masses, lengths, spring and torque are not given.",
        "0.000204, hence lambda = 0.2, and 5.07 rad/s fix M_m/(c l^2) between 0.10233 and "
        "0.10254 1/s by (21), ours is 0.10240 1/s; J, masses, spring and the size of l do not "
        "enter (21). The limit cycle feels them in the third digit, and they decide where the "
        "rotation begins",
        reference="0.10240 1/s",
        candidates="""
        ours: J = 2, m_b = 0.5, m = 1 kg, k = 32 N/m, l = 1.25 m | 5.0712 rad/s; least torque of a
            rotation 0.0526 N m
        J = 8 kg m^2 | 5.0690 rad/s; least torque of a rotation 0.0267 N m
        J = 0.5 kg m^2 | 5.0793 rad/s; least torque of a rotation 0.0997 N m
        m_b = 2, m = 4 kg | 5.1469 rad/s; least torque of a rotation 0.0499 N m
        k = 8 N/m | 5.0895 rad/s; least torque of a rotation 0.0263 N m
        k = 128 N/m | 4.9938 rad/s; least torque of a rotation 0.1053 N m
        l = 0.5, r = 0.1 m, M_m = 0.0512 N m | 5.0688 rad/s; least torque of a rotation 0.0034 N m
        the same with k = 200 N/m | 5.0474 rad/s; least torque of a rotation 0.0086 N m
        """,
    ),
    reading(
        "damper_of_figure_4", "figure 4", "To which damper 5.07 rad/s belongs.",
        "figure 4 has no damper in its text: we take the first of figure 5. Any of them has "
        "5.07 rad/s with its own torque, and settles in its own time",
        reference="c = 2 N s/m",
        printed="5.07 rad/s",
        candidates="""
        c = 2 N s/m, so M_m = 0.32 N m | 5.0712 rad/s, multiplier 0.9630, half of a deviation gone
            in 18 turns
        c = 3 N s/m, so M_m = 0.48 N m | 5.0712 rad/s, multiplier 0.9450, half of a deviation gone
            in 12 turns
        c = 4 N s/m, so M_m = 0.64 N m | 5.0712 rad/s, multiplier 0.9273, half of a deviation gone
            in 9 turns
        """,
    ),
    reading(
        "spring_reference", "2, 3", "Where the spring is at rest.",
        "F_e above (13), and (19), say -l; the averages have r + l, with the other sign, where "
        "(19) has -l. Each averages to 0, so that (21) does not depend on it; the positions of "
        "rest and the least torque do",
        reference="-1.25 m",
        candidates="""
        -l, as in F_e and (19) (ours) | 5.0712 rad/s; least torque of a rotation 0.0526 N m;
            equilibria [rad]: right 0.06, top 1.37, left 3.40, bottom 4.58
        -(r + l), as in the averages | 5.0521 rad/s; least torque of a rotation 0.1013 N m;
            equilibria [rad]: top 1.47, bottom 5.35
        -sqrt(l^2 - r^2), the slider at phi = 0 | 5.0726 rad/s; least torque of a rotation 0.0594 N
            m; equilibria [rad]: right 0.17, top 1.34, left 3.30, bottom 4.59
        0, at the crank's axle | 5.0226 rad/s; least torque of a rotation 0.1936 N m; equilibria
            [rad]: top 1.62, bottom 4.69
        """,
    ),
    reading(
        "axes_of_figure_3", "figure 3", "Dampers and range of torques.",
        "the text names neither: we take the dampers of figure 5 and 0.04 to 1 N m. How "
        "straight the curves look depends on how near the least torque the axis begins",
        reference="c = 2, 3, 4 N s/m",
        candidates="""
        c = 1 N s/m | begins at 0.0263 N m; (21) off by +4.7% at twice that, -0.52% at 1 N m
        c = 2 N s/m | begins at 0.0526 N m; (21) off by +4.7% at twice that, -0.49% at 1 N m
        c = 3 N s/m | begins at 0.0789 N m; (21) off by +4.7% at twice that, -0.43% at 1 N m
        c = 4 N s/m | begins at 0.1052 N m; (21) off by +4.7% at twice that, -0.34% at 1 N m
        c = 8 N s/m | begins at 0.2098 N m; (21) off by +4.7% at twice that, +0.26% at 1 N m
        """,
    ),
    reading(
        "tolerance_of_the_solver", "3", "Solver and tolerance of the numerical integration.",
        "the paper names Matlab's Runge-Kutta solvers, and no tolerance: mean speed from 200 to "
        "240 s after a start at 6 rad/s, by pairs of the same orders and their relative "
        "tolerance. With 1e-3, where Matlab starts, the third digit would be the solver's, and its "
        "rounding's",
        reference="5.0725 rad/s",
        printed="5.07 rad/s",
        candidates="""
        RK45, 0.001 | 5.0186 rad/s
        RK45, 0.0001 | 5.1046 rad/s
        RK45, 1e-06 | 5.0725 rad/s
        RK23, 0.001 | 4.9517 rad/s
        RK23, 0.0001 | 5.0758 rad/s
        RK23, 1e-06 | 5.0724 rad/s
        """,
    ),
    reading(
        "starts_of_figure_4", "figure 4", "Initial conditions.",
        "the text has none: we start at phi = 0 with speeds on both sides of 5.07 rad/s",
        reference="2, 4, 6, 8 rad/s at phi = 0",
        candidates="""
        phi = 0.00 rad, 0 rad/s | rest
        phi = 3.14 rad, 0 rad/s | rest
        phi = 0.00 rad, 0.6 rad/s | rest
        phi = 3.14 rad, 0.6 rad/s | rest
        phi = 0.00 rad, 0.8 rad/s | rotation
        phi = 3.14 rad, 0.8 rad/s | rotation
        phi = 0.00 rad, 2 rad/s | rotation
        phi = 3.14 rad, 2 rad/s | rotation
        phi = 0.00 rad, 8 rad/s | rotation
        phi = 3.14 rad, 8 rad/s | rotation
        """,
    ),
    reading(
        "braking_of_figure_6", "figure 6", "How the motion is braked.",
        "the text has no values. That the damper takes more than the motor gives is so in every "
        "run that slows down; it comes to rest only below the least torque of a rotation",
        reference="no rotation; least torque of a rotation 0.1052 N m",
        candidates="""
        less torque: 0.04 N m with c = 4 (ours) | no rotation; least torque of a rotation 0.1052 N m
        no motor, c = 2 | no rotation; least torque of a rotation 0.0526 N m
        a stronger damper: c = 14 at 0.32 N m | no rotation; least torque of a rotation 0.3649 N m
        a stronger damper: c = 8 at 0.32 N m | 1.1502 rad/s; least torque of a rotation 0.2098 N m
        c = 4 at 0.32 N m, as in figure 5 | 2.4969 rad/s; least torque of a rotation 0.1052 N m
        """,
    ),
)  # fmt: skip
