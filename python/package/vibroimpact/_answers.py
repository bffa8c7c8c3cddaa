"""The answers, with the type of each field: for editors and type checkers."""

from __future__ import annotations

from typing import Optional

import numpy as np

from ._records import Record, Table

Pair = tuple[float, float]


class Run(Record):
    """What :func:`vibroimpact.simulate` returns."""

    rig: str; cart: str; regime: str; engine: str
    stepper: Optional[str]; precision: str; tick_us: Optional[float]
    gap_mm: float; frequency_hz: float; frequency_ratio: float
    impacts: int; periods: Optional[int]; contacts_recorded: int; cycles: int; transient: int
    force_n: float; force_ratio: float; approach_speed_m_per_s: Optional[float]; rebound_speed_m_per_s: Optional[float]
    contact_time_ms: Optional[float]; energy_per_blow_j: Optional[float]; impulse_n_s: Optional[float]
    settling_cycles: Optional[int]; settling_s: Optional[float]
    history: Table; section: Table; contacts: Table


class Pick(Record):
    """What :func:`vibroimpact.pick` returns."""

    rig: str; gap_mm: float; cart: str; regime: str; regime_from_rest: str; why: str
    operating_frequency_hz: float; frequency_ratio: float; force_n: float; force_ratio: float
    force_ratio_worst: float; force_ratio_largest: float
    approach_speed_m_per_s: float; contact_time_ms: float; amplitude_mm: float
    recoil_force_ratio: Optional[float]; recoil_frequency_hz: Optional[float]
    prescribed_force_ratio: Optional[float]; prescribed_frequency_hz: Optional[float]
    force_settling_cycles: Optional[int]; force_settling_s: Optional[float]
    corners: int; corners_reaching_one_one_from_rest: int
    band_hz: Pair; safe_band_hz: Pair; robust_band_hz: Pair; stable_one_one_hz: Pair
    stable_one_one_ends: tuple[str, str]; safe_band_force_ratio_worst: tuple[Optional[float], Optional[float]]
    margin_below_percent: float; margin_above_percent: float; period_doubling_hz: Optional[float]
    multipliers: float; multipliers_worst: float
    jump_free: bool; jump_free_in_safe_band: bool; jump_range_hz: Optional[Pair]
    nominal_optimum_hz: float; nominal_optimum_force_ratio: float; force_ratio_at_natural_frequency: float
    impact_power_w: float; power_optimum_hz: float; power_optimum_w: float
    shaker: Record; shaker_force_at_optimum_n: Optional[float]; wanted_force_n: Optional[float]; amplitude_lowered: bool
    limits: list[Record]; sensitivity: list[Record]; uncertainty: Optional[Record]
    modes: Optional[int]; springs_mass_ratio: Optional[float]; springs_mass_percent: Optional[float]
    second_mode_hz: Optional[float]; modes_force_ratio: Optional[float]; modes_force_ratio_worst: Optional[float]
    modes_force_ratio_largest: Optional[float]; modes_multipliers_worst: Optional[float]
    modes_rigs: Optional[int]; modes_rigs_one_one: Optional[int]; modes_weak_hz: Optional[list[float]]
    one_mode_frequency_hz: Optional[float]; one_mode_safe_band_hz: Optional[Pair]
    one_mode_safe_band_force_share: Optional[float]; safe_band_force_share_any_springs: Optional[float]
    curve_frequency_hz: np.ndarray; curve_force_ratio: np.ndarray


class Bifurcation(Record):
    """What :func:`vibroimpact.bifurcation` returns."""

    rig: str; cart: str; section: str; cycles: int; recorded: int; simulations: int
    diagrams: list[Record]; twofold: list[Record]; points: Table


class Orbits(Record):
    """What :func:`vibroimpact.orbits` returns without ``curve``."""

    rig: str; cart: str; along: str; simulations: int; failed_simulations: int
    branches: list[Record]; seen_elsewhere: list[Record]; special_points: Table; orbits: Table


class Curves(Record):
    """What :func:`vibroimpact.orbits` returns with ``curve``."""

    rig: str; cart: str; parameter_1: str; parameter_2: str
    searched_at: list[float]; not_followed: int; simulations: int; failed_simulations: int
    curves: Table; codimension_two: Table; points: Table


class Poincare(Record):
    """What :func:`vibroimpact.poincare` returns."""

    rig: str; gap_mm: float; cart: str; frequency_hz: float; frequency_ratio: float
    regime: str; force_n: float; force_ratio: float; points: int; transient: int; phases_turns: list[float]
    steps_per_period: float; lyapunov: Optional[Record]; meaning: Optional[str]
    section: Table; trajectory: Table


class Lyapunov(Record):
    """What :func:`vibroimpact.lyapunov` returns."""

    largest_per_s: float; standard_error_per_s: float; other_per_s: Optional[float]; largest_per_period: float
    periods: int; meaning: str


class Identification(Record):
    """What :func:`vibroimpact.identify` returns."""

    rig: str; gap_mm: float; release_mm: float; impacts: int; sampling_hz: float
    noise_n: float; offset_n: float; ring: Optional[Record]; drift_n_per_s: float
    gain_percent: float; release_height_percent: float; clock_percent: float; free_cart_percent: float
    fits: list[Record]


class Comparison(Record):
    """What :func:`vibroimpact.compare` returns."""

    frequency_hz: float; frequency_ratio: float; frequency_from: str; shift_s: float
    cart_amplitude_mm: Optional[float]; regime: str; samples: int
    displacement_rms_mm: Optional[float]; displacement_rms_percent: Optional[float]; displacement_mean_mm: Optional[float]
    measured_peak_to_peak_mm: Optional[float]; simulated_peak_to_peak_mm: float
    force_rms_n: Optional[float]; measured_force_n: Optional[float]; measured_peak_mean_n: Optional[float]
    simulated_force_n: float; force_peak_percent: Optional[float]
    measured_contacts_per_period: Optional[float]; simulated_contacts_per_period: float
    measured_contact_time_ms: Optional[float]; simulated_contact_time_ms: Optional[float]
    rows: Table


class Modes(Record):
    """What :func:`vibroimpact.modes` returns."""

    modes: Table; rows: Table


class Drill(Record):
    """What :func:`vibroimpact.drill` returns."""

    rig: str; threshold_n: float; ground_stiffness_n_per_m: float; ground_damping_n_s_per_m: float; feed: str
    bit: Optional[Record]; advice: Optional[Record]; rows: Table


class Emulation(Record):
    """What :func:`vibroimpact.emulate` returns."""

    scenario: str; verdict: str; why: list[str]; final_state: str; faults: list[Record]
    time_to_hold_s: Optional[float]; frequency_hz: Optional[float]; force_ratio_mean: Optional[float]
    optimum_frequency_hz: Optional[float]; optimum_force_ratio: Optional[float]
    force_share: Optional[float]; share_from_start: Optional[float]
    prescribed_optimum_frequency_hz: Optional[float]; prescribed_optimum_force_ratio: Optional[float]
    overruns: int; reseeks: int; basin: str; true_basin: str; contacts: int
    largest_force_ratio: float; largest_force_n: float; largest_travel_mm: float; largest_cart_mm: float
    driven_with_fault_s: float; duration_s: float
    rate_of_penetration_um_per_s: Optional[float]; progress_mm: Optional[float]; loop_left_out: Optional[str]
    samples: Table; contact_list: Table; timeline: Table


class Trials(Record):
    """What :func:`vibroimpact.trials` returns without ``long``."""

    seed: int; seconds_s: float; distributions: Table; trials: Table


class LongTrials(Record):
    """What :func:`vibroimpact.trials` returns with ``long``."""

    seed: int; seconds_s: float; campaign: Record; trials: Table
