"""Misprints of the rotating_beam paper: what a formula gives as printed, and put right.

Each is proved by one number that the reference, which has its equations from Lagrange's, gives by
another route.
"""

from __future__ import annotations

from ..ledger import CORRECTED, Erratum, LedgerRow, misprint

TESTS = "tests/comparisons/papers/rotating_beam/test_misprints.py::test_misprints_of_the_"
ENERGIES, MODES, MOTION, FREQUENCY = (
    TESTS + part for part in ("energies", "modes", "equations_of_motion", "frequency_equation")
)
STIFFNESS = (
    "tests/reference/rotating_beam/test_frequencies.py"
    "::test_figure_3_without_bending_stiffness_has_no_speed"
)

MISPRINTS: tuple[LedgerRow, ...] = tuple(
    misprint(
        name, section, summary, CORRECTED,
        f"{what}: as printed {printed}, corrected {right} {unit}".strip(),
        reference=f"{right} {unit}".strip(), erratum=Erratum(test),
    )
    for name, section, summary, what, printed, right, unit, test in (
        (
            "strain_energy", "equation (2)",
            "stretching stores energy by u_xx: it is u_x",
            "strain energy of a beam stretched by 1e-4",
            "0", "0.20125", "J", ENERGIES,
        ),
        (
            "hub_radius", "equation (3)",
            "the velocity has no hub radius a in it",
            "kinetic energy at 1 rad/s on a hub of 8 m without inertia",
            "17.227", "120.59", "J", ENERGIES,
        ),
        (
            "coupling_energy", "equation (4)",
            "turning and bending couple by theta'^2: it is theta'",
            "kinetic energy of a beam that turns and bends",
            "523.57", "513", "J", ENERGIES,
        ),
        (
            "gravity", "equations (4), (5)",
            "a beam in a horizontal plane has weight",
            "torque on the hub at rest",
            "-126.71", "0", "N m", ENERGIES,
        ),
        (
            "hub_energy", "equation (5)",
            "the hub has no kinetic energy",
            "kinetic energy at 1 rad/s",
            "17.227", "22.227", "J", ENERGIES,
        ),
        (
            "hub_alone", "equation (7)",
            "the hub feels the torque only, not the beam",
            "hub's angle after the pulse",
            "1.5915", "0.35781", "rad", MOTION,
        ),
        (
            "axial_frequency", "section 2.2",
            "axial frequencies for i = 1, 3, 5 do not depend on i",
            "second axial frequency, i = 3",
            "980.22", "2940.7", "rad/s", MODES,
        ),
        (
            "free_end", "equation (10)",
            "the shear force at the free end has cos - cosh",
            "shear force of the first mode at the free end",
            "4.9", "0", "", MODES,
        ),
        (
            "determinant", "equation (11)",
            "the determinant has these signs",
            "determinant at 1.8751; as printed it is 2 sin^2",
            "1.8204", "0", "", MODES,
        ),
        (
            "frequency_formula", "section 2.2",
            "bending frequencies are proportional to beta_i L, not to its square",
            "first frequency at rest",
            "1.5523", "2.9107", "rad/s", MODES,
        ),
        (
            "mode_sign", "equation (12)",
            "xi_i is positive",
            "bending moment of the first mode at the free end",
            "-6.0756", "0", "", MODES,
        ),
        (
            "mode_argument", "equation (12)",
            "xi_i depends on x",
            "deflection of the first mode in the middle over that of the end",
            "0.29006", "0.33952", "", MODES,
        ),
        (
            "normalisation", "equation (13)",
            "modes (12) have the integral 1 of rho A phi^2",
            "integral of rho A phi_1^2",
            "1", "1.615", "kg", MODES,
        ),
        (
            "orthogonality", "equation (13)",
            "the modes are orthogonal, which (16) needs of the beam with its mass",
            "M_22 between modes 1 and 2 with 0.4 kg at the tip, over the beam's mass",
            "0", "-0.99068", "", MODES,
        ),
        (
            "equation_14_axial", "equation (14), row 1",
            "the axial stiffness is the integral of EA phi' phi",
            "stiffness of the first axial mode",
            "3.1446e+05", "7.7589e+05", "N/m", MOTION,
        ),
        (
            "equation_14_driving", "equation (14), row 2",
            "theta'' stands with a minus in the row of B_2",
            "what theta'' does to the first bending mode, over rho A L^2",
            "-1.6041", "1.6041", "", MOTION,
        ),
        (
            "equation_14_centrifugal", "equation (14), row 2",
            "a mass softens the beam by its pull, and stiffens it by its inertia",
            "stiffness that the mass has from theta'^2, over rho A L",
            "-0.31318", "0.31318", "", MOTION,
        ),
        (
            "equation_14_hub", "equation (14), row 3",
            "neither hub nor mass resist theta''",
            "what stands with theta'' of the straight beam",
            "241.18", "308.78", "kg m^2", MOTION,
        ),
        (
            "hub_inertia", "equation (16)",
            "M_theta_theta has no J_h",
            "M_theta_theta, straight",
            "298.78", "308.78", "kg m^2", MOTION,
        ),
        (
            "torque", "equation (16)",
            "Q_theta has no torque tau",
            "Q_theta at rest under 1 N m",
            "0", "1", "N m", MOTION,
        ),
        (
            "axial_pull", "equation (16)",
            "U_10 has no concentrated mass",
            "U_11 + a U_10, over rho A L^2",
            "1.1295", "1.3046", "", MOTION,
        ),
        (
            "hub_twice", "equations (17), (18)",
            "D_1 has the hub radius in it, and a D_0 is added",
            "first dimensionless frequency at 7 rad/s, a = L",
            "15.411", "11.422", "", FREQUENCY,
        ),
        (
            "driving_vector", "equation (18)",
            "U_12 has the mass without its distance from the axis",
            "U_12 of the first mode",
            "1.52", "1.6041", "", FREQUENCY,
        ),
        (
            "bending_stiffness", "equation (21)",
            "K^C has no bending stiffness K_2",
            "first dimensionless frequency at 7 rad/s, 0.4 kg in the middle",
            "10.601", "11.619", "", STIFFNESS,
        ),
    )
)  # fmt: skip
