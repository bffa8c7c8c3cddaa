//! One run, and runs over gap and frequency.

use serde::Serialize;
use shared::model::bit::Bit;
use shared::model::params::RigParams;
use shared::model::regime::{Detector, Regime};
use shared::model::slider::Slider;

use super::blow::{Feed, GroundBlow};
use super::march::Drill;
use crate::engine::check_frequency;
use crate::error::{Error, MotionError};
use crate::orbit::Section;
use crate::parallel;
use crate::progress::{Progress, step};
use crate::row::CartModel;
use crate::row::{NamedRig, regime_as_text, tidy};

/// A section repeats well enough to stop settling when it moves by less than this share of A0 and A0 Ω.
const SETTLED: f64 = 1e-9;

/// A hammer this far beyond the front, in units of the amplitude, is lost.
const LOST: f64 = 1e4;

/// Ground, bit and feed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillSetting {
    /// The ground, which gives way.
    pub ground: Slider<f64>,
    /// A bit between hammer and ground.
    pub bit: Option<Bit<f64>>,
    /// How the rig follows it.
    pub feed: Feed,
}

impl DrillSetting {
    /// On `ground`, through a bit if there is one.
    pub fn new(ground: Slider<f64>, bit: Option<Bit<f64>>, feed: Feed) -> Self {
        Self { ground, bit, feed }
    }
}

/// How long a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillPlan {
    /// Drive periods in which it may settle; fewer where the section repeats before.
    pub settle: u32,
    /// Drive periods recorded after it has settled.
    pub recorded: u32,
}

impl Default for DrillPlan {
    fn default() -> Self {
        Self {
            settle: 300,
            recorded: 48,
        }
    }
}

/// What a run showed.
#[derive(Clone, Debug, PartialEq)]
pub struct DrillRun {
    /// Regime over the recorded periods.
    pub regime: Regime,
    /// Rate of penetration, m/s.
    pub rate_m_per_s: f64,
    /// Progress per drive period, m.
    pub per_cycle_m: f64,
    /// Contacts that ended in the recorded periods.
    pub blows: Vec<GroundBlow>,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Mean distance of the front beyond its nominal place on the section, m.
    pub lead_m: f64,
    /// Energy that went into progress, J per drive period.
    pub progress_j: f64,
    /// Energy that the contacts took from the hammer, J per drive period.
    pub contact_j: f64,
    /// Energy that went into the ground, J per drive period.
    pub ground_j: f64,
    /// Number of drive periods recorded.
    pub periods: f64,
    /// The section at the end.
    pub section: [f64; 3],
    /// Deviation of the cart from its course (m) and its rate (m/s) there.
    pub cart: [f64; 2],
}

impl DrillRun {
    /// Where a shooting for the orbit begins.
    pub fn guess(&self) -> Section {
        let ([q, v, _], [off, off_rate]) = (self.section, self.cart);
        [q, v, off, off_rate]
    }
}

/// Runs the hammer of `params` from rest at `frequency_hz`.
///
/// # Errors
/// If a parameter or the frequency is out of range, or the motion cannot be followed.
pub fn run(
    params: &RigParams,
    setting: &DrillSetting,
    frequency_hz: f64,
    plan: DrillPlan,
) -> Result<DrillRun, Error> {
    check_frequency(frequency_hz, params)?;
    let mut drill = Drill::<f64>::through(params, setting, frequency_hz)?;
    settle(&mut drill, plan.settle);
    observe(&mut drill, frequency_hz, plan.recorded)
}

/// What `drill`, driven at `frequency_hz`, shows in the next `recorded` periods.
///
/// # Errors
/// If the motion cannot be followed.
pub fn observe(
    drill: &mut Drill<f64>,
    frequency_hz: f64,
    recorded: u32,
) -> Result<DrillRun, Error> {
    let (q_unit, v_unit) = drill.units();
    let mut detector = Detector::new(q_unit, v_unit);
    let [q, v, _] = drill.section();
    detector.push(q, v, &Default::default());
    let (before, drift) = (drill.energies(), drill.drift_m());
    let (mut blows, mut force_n, mut lead) = (Vec::new(), 0.0_f64, 0.0);
    for _ in 0..recorded {
        let (period, _) = drill.run_period(&mut blows);
        let [q, v, _] = drill.section();
        if q.is_nan() || (q / q_unit).abs() > LOST {
            return Err(MotionError::Lost { frequency_hz }.into());
        }
        detector.push(q, v, &period);
        force_n = force_n.max(period.peak_force);
        lead += drill.lead_m();
    }
    let periods = f64::from(recorded);
    let per_cycle_m = (drill.drift_m() - drift) / periods;
    let after = drill.energies();
    Ok(DrillRun {
        regime: detector.regime(),
        rate_m_per_s: per_cycle_m * frequency_hz,
        per_cycle_m,
        blows,
        force_n,
        lead_m: lead / periods,
        progress_j: (after.progress - before.progress) / periods,
        contact_j: (after.contact - before.contact) / periods,
        ground_j: (after.ground - before.ground) / periods,
        periods,
        section: drill.section(),
        cart: drill.cart(),
    })
}

/// Runs until the section repeats, at most `periods` drive periods.
pub fn settle(drill: &mut Drill<f64>, periods: u32) {
    let [q_unit, v_unit, length, speed] = drill.all_units();
    let state = |drill: &Drill<f64>| {
        let ([q, v, _], [off, off_rate]) = (drill.section(), drill.cart());
        [
            q / q_unit,
            v / v_unit,
            off / length,
            off_rate / speed,
            drill.lead_m() / q_unit,
        ]
    };
    let mut blows = Vec::new();
    let mut last = [state(drill); 2];
    for _ in 0..periods {
        drill.run_period(&mut blows);
        blows.clear();
        let now = state(drill);
        let near = |then: &[f64; 5]| (0..5).all(|i| (now[i] - then[i]).abs() < SETTLED);
        if last.iter().any(near) {
            return;
        }
        last = [now, last[0]];
    }
}

/// A run as a row of a table. Units are in the names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrillRow {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm, that the feed restores.
    pub gap_mm: f64,
    /// Threshold force Pf at which the ground gives way, N.
    pub threshold_n: f64,
    /// Stiffness k of the ground, N/m.
    pub ground_stiffness_n_per_m: f64,
    /// Damping c of the ground, N·s/m.
    pub ground_damping_n_s_per_m: f64,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// p: contacts in n periods; when nothing repeats, in the last 16 recorded periods.
    pub impacts: u16,
    /// n; none when the section does not repeat, or nothing touches.
    pub periods: Option<u8>,
    /// Written as "p/n", "none", "aperiodic" or "chatter".
    #[serde(serialize_with = "regime_as_text")]
    pub regime: Regime,
    /// Rate of penetration, µm/s.
    pub rate_of_penetration_um_per_s: f64,
    /// Progress per contact, µm.
    pub progress_per_blow_um: Option<f64>,
    /// Progress per drive period, µm.
    pub progress_per_cycle_um: f64,
    /// The feed that keeps the gap, mm/s.
    pub feed_needed_mm_per_s: f64,
    /// Energy that a contact takes from the hammer, mJ.
    pub energy_per_blow_mj: Option<f64>,
    /// Share of it that goes into progress.
    pub share_into_progress: Option<f64>,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Mean approach speed, m/s.
    pub approach_speed_m_per_s: Option<f64>,
    /// Mean clearance that the feed leaves at drive phase 0, mm: the gap and what the front is beyond it.
    pub mean_clearance_mm: f64,
    /// How the cart is moved.
    pub cart: CartModel,
    /// Mass m_b of the bit, kg; none without a bit.
    pub bit_mass_kg: Option<f64>,
    /// Static feed force W on the bit, N; none without a bit.
    pub bit_feed_force_n: Option<f64>,
    /// Largest force on the ground, N: that on the hammer without a bit.
    pub ground_force_n: f64,
    /// Energy per blow that goes into the ground, mJ: with a bit, the work of its feed force included.
    pub ground_energy_per_blow_mj: Option<f64>,
    /// How often hammer and bit touch in a blow; once without a bit.
    pub contacts_per_blow: Option<f64>,
}

impl DrillRow {
    /// The row of a run.
    pub fn new(rig: &NamedRig, setting: &DrillSetting, frequency_hz: f64, seen: &DrillRun) -> Self {
        let count = seen.blows.len() as f64;
        let mean = |value: fn(&GroundBlow) -> f64| {
            let sum: f64 = seen.blows.iter().map(value).sum();
            (count > 0.0).then(|| sum / count)
        };
        let per_blow = mean(|b| b.progress_m);
        Self {
            rig: rig.name.clone(),
            gap_mm: tidy(rig.params.gap_m * 1e3),
            threshold_n: setting.ground.threshold,
            ground_stiffness_n_per_m: setting.ground.stiffness,
            ground_damping_n_s_per_m: setting.ground.damping,
            frequency_hz: tidy(frequency_hz),
            frequency_ratio: tidy(frequency_hz / rig.params.natural_frequency_hz()),
            impacts: seen.regime.impacts(),
            periods: seen.regime.periods(),
            regime: seen.regime,
            rate_of_penetration_um_per_s: 1e6 * seen.rate_m_per_s,
            progress_per_blow_um: per_blow.map(|m| 1e6 * m),
            progress_per_cycle_um: 1e6 * seen.per_cycle_m,
            feed_needed_mm_per_s: 1e3 * seen.rate_m_per_s,
            energy_per_blow_mj: mean(|b| b.energy_lost_j).map(|j| 1e3 * j),
            share_into_progress: (seen.contact_j > 0.0).then(|| seen.progress_j / seen.contact_j),
            force_n: seen.force_n,
            approach_speed_m_per_s: mean(|b| b.approach_speed_m_per_s),
            mean_clearance_mm: 1e3 * (rig.params.gap_m + seen.lead_m),
            cart: CartModel::of(&rig.params),
            bit_mass_kg: setting.bit.map(|b| b.mass),
            bit_feed_force_n: setting.bit.map(|b| b.feed_force),
            ground_force_n: seen
                .blows
                .iter()
                .map(|b| b.ground_force_n)
                .fold(0.0, f64::max),
            ground_energy_per_blow_mj: (count > 0.0)
                .then(|| 1e3 * seen.ground_j * seen.periods / count),
            contacts_per_blow: mean(|b| f64::from(b.contacts)),
        }
    }
}

/// Runs at every gap (mm) and frequency (Hz), gap by gap, each from rest. A step of the progress is a run.
///
/// # Errors
/// If a parameter or frequency is out of range, a motion cannot be followed, or the work is interrupted.
pub fn grid(
    rig: &NamedRig,
    setting: &DrillSetting,
    gaps_mm: &[f64],
    frequencies_hz: &[f64],
    plan: DrillPlan,
    progress: &dyn Progress,
) -> Result<Vec<DrillRow>, Error> {
    let mut rigs = Vec::with_capacity(gaps_mm.len());
    for gap_mm in gaps_mm {
        let mut there = rig.clone();
        there.params = rig.params.with_gap_mm(*gap_mm)?;
        rigs.push(there);
    }
    let cells: Vec<_> = rigs
        .iter()
        .flat_map(|rig| frequencies_hz.iter().map(move |hz| (rig, *hz)))
        .collect();
    parallel::try_map(&cells, |(rig, hz)| {
        let seen = run(&rig.params, setting, *hz, plan)?;
        step(progress, 1)?;
        Ok(DrillRow::new(rig, setting, *hz, &seen))
    })
}
