"""What the hula_hoop paper leaves open, and what each way of reading it gives."""

from __future__ import annotations

from ..ledger import LedgerRow, reading

READINGS: tuple[LedgerRow, ...] = (
    reading(
        "damping_units", "table 1", "Units of the damping entries 0.1 and 0.01.",
        "the motion from rest at 3 Hz and 60 N; the first reading is ours, since the table "
        "calls both entries ratios (its C_m, and s_m, xi_m and zeta_m elsewhere, are one symbol)",
        reference="locks in, turning forwards; last slip 0.33 s, last reversal 1.60 s",
        candidates="""
        rho = 0.1 and zeta_m = 0.01 of (7), (8) | locks in, turning forwards; last slip 0.33 s, last
            reversal 1.60 s
        c = 0.1 N s/m, c_m = 0.01 N m s/rad | no lock-in, no turns in the end
        c = 0.1 N s/m, zeta_m = 0.01 | no lock-in, irregular turns
        rho = 0.1, c_m = 0.01 N m s/rad | no lock-in, no turns in the end
        c = 0.1 N s/m, c_m/R_m^2 = 0.01 N s/m | no lock-in, irregular turns
        2 rho = 0.1, zeta_m = 0.01 | locks in, turning backwards; last slip 2.33 s, last reversal
            3.11 s
        rho = 0.1, zeta_m/2 = 0.01 | locks in, turning forwards; last slip 0.33 s, last reversal
            1.10 s
        """,
    ),
    reading(
        "start", "table 1, figures 3, 5, 7",
        "Start exactly at rest; how far the motion depends on it.",
        "fig. 3 by starts near rest: direction and transient depend on them. In fig. 5 93% of "
        "the points keep their class when the start is off by 1e-6 and the step is doubled; "
        "only these are compared",
        reference="locks in, turning forwards; last slip 0.33 s, last reversal 1.60 s",
        candidates="""
        theta(0) = 0 rad | locks in, turning forwards; last slip 0.33 s, last reversal 1.60 s
        theta(0) = 1e-06 rad | locks in, turning forwards; last slip 0.33 s, last reversal 1.60 s
        theta(0) = -1e-06 rad | locks in, turning forwards; last slip 0.33 s, last reversal 1.60 s
        theta(0) = 0.001 rad | locks in, turning forwards; last slip 0.33 s, last reversal 1.60 s
        theta(0) = -0.001 rad | locks in, turning forwards; last slip 0.33 s, last reversal 1.60 s
        theta(0) = 0.01 rad | locks in, turning forwards; last slip 0.33 s, last reversal 1.59 s
        theta(0) = -0.01 rad | locks in, turning forwards; last slip 0.33 s, last reversal 1.59 s
        theta(0) = 0.1 rad | locks in, turning backwards; last slip 0.00 s, last reversal 1.09 s
        theta(0) = -0.1 rad | locks in, turning backwards; last slip 0.33 s, last reversal 1.09 s
        """,
    ),
    reading(
        "axes_of_maps", "figures 4-7", "Ranges of frequency and amplitude.",
        "the text gives no axes; the first are ours. The paper has 4 unstable regions in fig. "
        "4, 3 in fig. 6",
        reference="fig. 4 41% stable, 2 unstable regions; fig. 6 70% stable, 3 unstable regions",
        candidates="""
        1-10 Hz, 5-150 N | fig. 4 41% stable, 2 unstable regions; fig. 6 70% stable, 3 unstable
            regions
        1-10 Hz, 5-100 N | fig. 4 52% stable, 3 unstable regions; fig. 6 75% stable, 3 unstable
            regions
        1-20 Hz, 5-150 N | fig. 4 54% stable, 2 unstable regions; fig. 6 68% stable, 3 unstable
            regions
        2-8 Hz, 5-150 N | fig. 4 34% stable, 1 unstable regions; fig. 6 73% stable, 3 unstable
            regions
        """,
    ),
    reading(
        "drawn_solution", "figures 4, 6",
        "Solution and equation (55) that the figures were drawn with.",
        "the text counts 4 unstable regions in fig. 4 and 3 in fig. 6; as axes and grid are not "
        "given, their number does not tell which form was drawn",
        reference="fig. 4 2 unstable regions, 70% like fig. 5; fig. 6 3 unstable regions, 64% "
                  "like fig. 7",
        candidates="""
        paper's solution, (55) as printed | fig. 4 1 unstable regions, 72% like fig. 5; fig. 6 2
            unstable regions, 61% like fig. 7
        paper's solution, (55) corrected | fig. 4 2 unstable regions, 70% like fig. 5; fig. 6 3
            unstable regions, 64% like fig. 7
        with its phase, (55) corrected | fig. 4 3 unstable regions, 93% like fig. 5; fig. 6 3
            unstable regions, 76% like fig. 7
        true rotation | fig. 4 3 unstable regions, 87% like fig. 5; fig. 6 4 unstable regions, 71%
            like fig. 7
        """,
    ),
    reading(
        "definition", "5, figures 5, 7", "What hula-hoop motion is.",
        "section 5 calls it ideal if it turns one way without oscillation; the tables of figs. 5 "
        "and 7 have an oscillation at twice the frequency, without reversals. Points of fig. 5 "
        "with such motion from rest, and the least u_1 of a stable true rotation",
        candidates="""
        one way, no oscillation: the ideal | 0.0%; the least u_1 is 0.0051 rad
        one way, f_u = 2 omega (blue o) | 20%
        at the force's frequency, f_u = 2 omega, reversals allowed (blue o, blue +) | 22%
        at the force's frequency (blue, cyan) | 28%
        """,
    ),
    reading(
        "class_definitions", "figures 5, 7", "Limits between the classes.",
        "the paper writes 'about equal' in its table; shares of fig. 5 by each reading",
        reference="blue o 20%, blue + 2%, cyan o 2%, cyan + 4%, red x 72%",
        candidates="""
        ours: half a turn in 120 periods, f_u within 1 % | blue o 20%, blue + 2%, cyan o 2%, cyan +
            4%, red x 72%
        a quarter of a turn | blue o 20%, blue + 2%, cyan o 2%, cyan + 4%, red x 72%
        5 % of the turns | blue o 20%, blue + 2%, cyan o 2%, cyan + 4%, red x 72%
        f_u within 5 % | blue o 20%, blue + 2%, cyan o 2%, cyan + 4%, red x 72%
        reversals slower than 5 % of omega do not count | blue o 20%, blue + 2%, cyan o 2%, cyan +
            4%, red x 72%
        """,
    ),
)  # fmt: skip
