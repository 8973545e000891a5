"""Options of inspection: when a rule reports, what counts as round-off, how much is tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Thresholds:
    """Values beyond which rules report a finding, and values that remedies try.

    Attributes
    ----------
    open_loop : float
        Opening of a loop in a state of the file, relative to the size of the model, or in rad.
    gravity_share : float
        Largest share of its weight, at its size, that a joint feels where gravity moves nothing.
    max_gyration, usual_gyration, min_gyration : float
        Radii of gyration that bodies have, relative to the reach of their geoms.
    max_centre_offset : float
        Distance of a centre of mass from the middle of the geoms, relative to their reach.
    max_density, min_density : float
        Densities of bodies [kg/m^3]: osmium has 22,600, air 1.2.
    max_carried_mass : float
        Mass that a body carries beyond a joint, relative to its mass.
    merged_centre : float
        Distance [m] below which MuJoCo puts a centre of mass into the frame of the body.
    centre_roundoff : float
        Share of the model's size by which round-off moves a centre of mass.
    point_gyration : float
        Radius of gyration, relative to the model's size, below which a body counts as a point.
    max_armature : float
        Armature of a joint, relative to the inertia that the joint moves.
    locked_range : float
        Width [rad, m] of a range that leaves a joint no motion.
    idle_acceleration : float
        Share of the largest acceleration up to which another is round-off.
    max_turn : float
        Angle [rad] beyond which a range or a position of a hinge is taken to be in degrees.
    control_excess : float
        Share of a joint's range by which a servo's control may exceed it, as calibration and a firm
        grip need.
    min_damping_ratio : float
        Damping ratio below which a servo rings for tens of periods.
    max_turn_in_step : float
        Rotation [rad] of a joint in the first step under full force.
    servo_drift : float
        Displacement from a keyframe by which a servo carries its load [rad], or relative to the
        size of the model.
    overload : float
        Share by which the load of a keyframe may exceed the largest force of an actuator.
    motor_imbalance : float
        Share of a motor's force that may be missing, or too much, in a keyframe.
    free_fall : float
        Share of gravity from which on a free body is falling.
    undriven_imbalance : float
        Imbalance of joints without a drive, relative to the force that would balance a joint of the
        same tree, from which on that tree is falling.
    quaternion_norm : float
        Difference from 1 of the norm of a quaternion in a keyframe.
    min_growth : float
        Growth rate [1/s] that a run of seconds shows.
    growth_folds : float
        Factors of e by which a mode grows in the run that confirms it; half of them must be seen.
    fed_share : float
        Share of the power fed into a mode from which on an actuator or a damper is the cause.
    named_power : float
        Share of the largest power from which on an actuator is named.
    rest_acceleration : float
        Acceleration of a state of rest, relative to gravity, or in m/s^2 and rad/s^2.
    worse_than_baseline : float
        Factor by which a finding of the baseline must grow to count again.
    near_step_limit, recommended_step : float
        Shares of the largest stable step: above the first a step is close to it; below the second
        it is after a remedy.
    preferred_integrators : tuple of str
        Integrators that remedies try, in order of cost.
    inertia_shares : tuple of float
        Armatures that are tried, relative to the inertia of a joint; the same over the step are
        tried as damping.
    damping_unit : float
        Unit of the damping tried on a growing mode, relative to inertia times frequency.
    gain_shares : tuple of float
        Factors of servo gains that are tried.
    impedances : tuple of float
        Impedances that are tried on a closure.
    closure_steps : tuple of float or None
        Time constants that are tried on a closure, in timesteps; None is the file's own.
    shorter_steps : tuple of float
        Shares of the timestep that are tried where a run fails.
    """

    open_loop: float = 1e-6
    gravity_share: float = 1e-12
    max_gyration: float = 2.0
    usual_gyration: float = 0.5
    min_gyration: float = 0.01
    max_centre_offset: float = 2.0
    max_density: float = 25_000.0
    min_density: float = 0.5
    max_carried_mass: float = 1e4
    merged_centre: float = 1e-6
    centre_roundoff: float = 1e-12
    point_gyration: float = 1e-4
    max_armature: float = 1e3
    locked_range: float = 1e-6
    idle_acceleration: float = 1e-12
    max_turn: float = 4 * np.pi
    control_excess: float = 0.1
    min_damping_ratio: float = 0.02
    max_turn_in_step: float = np.pi
    servo_drift: float = 0.2
    overload: float = 0.01
    motor_imbalance: float = 0.5
    free_fall: float = 0.5
    undriven_imbalance: float = 0.1
    quaternion_norm: float = 0.01
    min_growth: float = 0.2
    growth_folds: float = 4.0
    fed_share: float = 0.5
    named_power: float = 0.3
    rest_acceleration: float = 1e-3
    worse_than_baseline: float = 1.1
    near_step_limit: float = 0.8
    recommended_step: float = 0.79
    preferred_integrators: tuple[str, ...] = ("implicitfast", "implicit", "discrete", "RK4")
    inertia_shares: tuple[float, ...] = tuple(map(float, np.geomspace(0.1, 1000.0, 24)))
    damping_unit: float = 0.1
    gain_shares: tuple[float, ...] = (
        *(0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001),
    )
    impedances: tuple[float, ...] = (0.99, 0.999, 0.9999)
    closure_steps: tuple[float | None, ...] = (None, 10.0, 4.0, 2.5)
    shorter_steps: tuple[float, ...] = (0.5, 0.2, 0.1)


@dataclass(frozen=True)
class Numerics:
    """Steps of differences, shares that are round-off, and lengths of runs.

    Attributes
    ----------
    difference : float
        Step of finite differences [rad], and as a share of the model's size [m].
    difference_roundoff : float
        Share of the values that remains as round-off in a difference of them.
    rank : float
        Share of the largest row below which a row of a scaled Jacobian is dependent.
    free : float
        Share of the stiffest direction below which a direction resists nothing.
    zero_rate : float
        Share of the largest eigenvalue below which another is 0, and growth is none.
    slowest : float
        Rate [1/s] of the fastest mode below which a model has rigid modes only: one in a year.
    full_matrix_dofs : int
        Degrees of freedom up to which the matrix of a step is used, not mode by mode.
    scanned_steps : int
        Steps that are scanned for the stability limit, see `amplification.SCAN`.
    similar_shape : float
        Share of the best match of shapes that counts as equal: a coordinate may have a slow mode
        and a fast one.
    horizon_radians : float
        Horizon over which amplitudes may not grow, in 1 / omega of the fastest mode.
    growth_folds : float
        Factors of e over which an unstable mode is followed: integrators change its growth a
        little.
    short_step : float
        Step [s] too short for MuJoCo to raise a time constant of a constraint.
    long_step : float
        Step [s] at which MuJoCo raises all time constants that can be raised.
    same_damper : float
        Share by which a damper changes without being raised.
    constraint_share : float
        Share of the resistance of a mode from which on constraints set it.
    min_opening : float
        Opening of a loop [m, rad] below which it is round-off.
    balanced, steady : float
        Shares of the forces that may be unbalanced in a steady rotation, and as it goes on.
    steady_angles : tuple of float
        Angles [rad] at which a rotation is checked to be steady.
    max_damping_ratio : float
        Damping ratio below which a mode has a period.
    at_limit : float
        Share of its range within which a joint stands at a limit.
    deep : float
        Penetration of bodies that counts as overlap, relative to the size of the model.
    max_number : float
        Largest number that a file may hold; products of larger ones overflow.
    run_time : float
        Length of a short run [s].
    run_steps : int
        Largest number of steps of a short run.
    energy_samples, energy_parts : int
        Times at which a short run's energy is sampled; parts that are compared with each other.
    energy_gain : float
        Gain from part to part, relative to the kinetic energy, of a run that keeps growing.
    energy_roundoff : float
        Share of an energy below which another is round-off.
    perturbation : float
        Departure [rad, m] of a perturbed start.
    far_starts : tuple of float
        Displacements of one joint [rad], or relative to the model's size, of starts far away.
    far_time : float
        Length of a run from there [s].
    shorter_step : float
        Share of the timestep with which a run shows the motion that lasts.
    lasting_ratio, lasting_energy : float
        Kinetic energy at the end of a run that its step must have caused: relative to that of a run
        with shorter steps, and to the largest in that run.
    steps_per_radian, min_steps_per_radian : float
        Steps of a run that confirms growth of a mode, and the fewest for all other modes: RK4 is
        stable up to 2.78 radians in a step, so it feeds none of these.
    probe_speed : float
        Speed [rad/s, m/s] at which the damping of a joint is measured.
    """

    difference: float = 1e-3
    difference_roundoff: float = 64 * float(np.finfo(float).eps)
    rank: float = 1e-9
    free: float = 1e-9
    zero_rate: float = 1e-6
    slowest: float = 1e-7
    full_matrix_dofs: int = 16
    scanned_steps: int = 80
    similar_shape: float = 0.95
    horizon_radians: float = 1e5
    growth_folds: float = 1.0
    short_step: float = 1e-9
    long_step: float = 1e3
    same_damper: float = 1e-9
    constraint_share: float = 0.5
    min_opening: float = 1e-15
    balanced: float = 1e-12
    steady: float = 1e-6
    steady_angles: tuple[float, ...] = (0.4, 1.1, 2.3)
    max_damping_ratio: float = 1.0
    at_limit: float = 1e-9
    deep: float = 1e-3
    max_number: float = 1e100
    run_time: float = 5.0
    run_steps: int = 20_000
    energy_samples: int = 400
    energy_parts: int = 4
    energy_gain: float = 0.002
    energy_roundoff: float = 1e-12
    perturbation: float = 1e-6
    far_starts: tuple[float, ...] = tuple(map(float, np.linspace(0.1, 1.2, 12)))
    far_time: float = 0.5
    shorter_step: float = 0.25
    lasting_ratio: float = 4.0
    lasting_energy: float = 0.01
    steps_per_radian: float = 40.0
    min_steps_per_radian: float = 2.0
    probe_speed: float = 0.1


@dataclass(frozen=True)
class EffortLimits:
    """How much is computed, tried and printed.

    Attributes
    ----------
    max_states : int
        States whose modes are computed.
    max_dofs : int
        Degrees of freedom up to which modes are computed by default.
    max_overlap_dofs, max_idle_dofs, max_remedy_dofs : int
        Degrees of freedom up to which overlapping geoms and idle joints are searched, and remedies
        of joints and short runs tried.
    draws : int
        Random positions within the ranges of joints.
    idle_draws : int
        Random states in which an idle joint is searched.
    runs : int
        States from which a short run starts.
    run_tries : int
        Values of an edit that are tried in runs, once modes are stable.
    far_starts, fine_runs : int
        Runs with a displaced joint that try a remedy, and those of them, with the longest motions,
        that are compared with a run of a shorter step.
    compiled_bytes : float
        Bytes of text and models that are compiled to find repeated defaults.
    values : int
        Values of an attribute that are tried, the shortest first, since defaults are short.
    single_attributes : int
        Attributes up to which each is tried alone where a group of equal ones matters.
    file_time, min_file_time : float
        Time [s] after which a file is abandoned, and that each file has at least.
    report_interval : float
        Time [s] between two intermediate reports.
    closures, modes, rules, rows, states : int
        Entries of a short report.
    indented_levels : int
        Levels of the tree of bodies that are indented.
    """

    max_states: int = 8
    max_dofs: int = 120
    max_overlap_dofs: int = 200
    max_idle_dofs: int = 400
    max_remedy_dofs: int = 60
    draws: int = 40
    idle_draws: int = 4
    runs: int = 2
    run_tries: int = 6
    far_starts: int = 24
    fine_runs: int = 6
    compiled_bytes: float = 4e7
    values: int = 40
    single_attributes: int = 200
    file_time: float = 600.0
    min_file_time: float = 2.0
    report_interval: float = 0.5
    closures: int = 3
    modes: int = 4
    rules: int = 4
    rows: int = 5
    states: int = 2
    indented_levels: int = 5


THRESHOLDS, NUMERICS, EFFORT = Thresholds(), Numerics(), EffortLimits()
