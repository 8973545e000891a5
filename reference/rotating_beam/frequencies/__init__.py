r"""Natural frequencies of `rotating_beam` about steady rotation, by several routes.

With lengths in L and times in T of (19), and the shape w(xi) of a bending vibration, the
beam that does not stretch has

    w'''' - gamma^2 (tau w')' = lambda (1 + alpha Dirac(xi - beta)) w,
    tau(xi) = delta (1 - xi) + (1 - xi^2)/2 + alpha (delta + beta) [xi < beta],

clamped at 0 and free at 1. ``lambda = omega^2`` flapwise, out of the plane of rotation;
``lambda = omega^2 + gamma^2`` chordwise, in it. These are (17), (18) with (21) put right (its
K^C has lost the bending stiffness) and any number of modes.

- `ritz`: polynomials of high degree on either side of the mass (spectral). Values from above.
- `assumed_modes`: the paper's n bending modes of the beam at rest without mass, (12) with its
  xi_i put right: ``(sin - sinh)(1) / (cos + cosh)(1)``. Two of them make figure 3.

Engines model other continua, about a state that rotation has stretched:

- *extensible*: stiffness EA, ``1/2 EA (|r'| - 1)^2 + 1/2 EI (angle of r')'^2`` per reference
  length (absolute nodal coordinates), chordwise with the gyroscopic coupling of u and v;
- *shear_flexible*: the cross-section has an angle of its own, shear stiffness k G A and, if
  wanted, rotary inertia (geometrically exact beam).

Figure 3 names no speed (a = L). Its largest first frequencies, at beta = 0.442, 0.429 and 0.42
for 0.4, 0.8 and 1.2 kg, are what two assumed modes give at 7.76, 7.00 and 6.77 rad/s, at no
one speed all three; with three modes, or four, or converged, no speed gives any of them:
converged, none lies beyond 0.4. With two modes the crossover with the massless beam is at 0.67
near 7.5 rad/s; it is another point for each speed and each pair of masses. See
`best_mass_position`, `crossover`, `matching_speed`.
"""
