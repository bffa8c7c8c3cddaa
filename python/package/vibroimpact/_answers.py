"""The answers with many fields, with the type of each: for editors and type checkers."""

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
