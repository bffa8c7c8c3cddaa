//! What a run shows: regime, force, displacement, and the energy in each mode.

use std::f64::consts::TAU;

use serde::Serialize;
use shared::model::contacts::{Contact, Period};
use shared::model::params::RigParams;
use shared::model::regime::{Detector, Regime};

use super::linear::{Follower, LinearMotion};
use super::{Beam, MAX_MODES, ModalRig, ModalState, PerMode, TipJoint};
use crate::engine::{Arrival, Plan as Cycles, STILL, repeated};
use crate::error::{Error, ModesError};
use crate::parallel;
use crate::progress::{Progress, step};
use crate::row::CartModel;
use crate::row::NamedRig;
use crate::row::{extent, regime_as_text, tidy};

/// A beam rig run at several drive frequencies with several numbers of modes.
#[derive(Clone, Debug)]
pub struct ModesRequest<'a> {
    /// The rig, which must be on beam springs.
    pub rig: &'a NamedRig,
    /// Its beam springs: their mass, and how the hammer holds their end.
    pub beam: Beam,
    /// Numbers of modes, one run each.
    pub counts: &'a [usize],
    /// Drive frequencies, Hz.
    pub frequencies_hz: &'a [f64],
    /// Cycles in all, and those not recorded.
    pub cycles: Cycles,
}

impl ModesRequest<'_> {
    /// Every frequency with every number of modes, from rest: a row each, by frequency, then by number of modes.
    ///
    /// # Errors
    /// As [`ModalRig::new`]; also if a frequency is not a positive number, if a motion cannot be followed, or if the work is
    /// interrupted.
    pub fn run(&self, progress: &dyn Progress) -> Result<Vec<ModesRow>, Error> {
        let rigs = self
            .counts
            .iter()
            .map(|count| ModalRig::new(&self.rig.params, self.beam, *count))
            .collect::<Result<Vec<_>, _>>()?;
        let runs: Vec<_> = self
            .frequencies_hz
            .iter()
            .flat_map(|hz| rigs.iter().map(move |rig| (*hz, rig)))
            .collect();
        parallel::try_map(&runs, |&(hz, rig)| {
            let params = &self.rig.params;
            let modes = rig.modes.len();
            let motion = LinearMotion::of(params, self.beam, modes, hz)?;
            let seen = watched(Follower::at_rest(motion, rig), rig, hz, self.cycles)?;
            step(progress, 1)?;
            Ok(ModesRow::new(self.rig, self.beam, modes, hz, &seen))
        })
    }
}

/// What the recorded cycles of a run showed.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalObservation {
    /// Regime over the recorded cycles.
    pub regime: Regime,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Approach speed of the strongest contact that ended, m/s.
    pub approach_m_per_s: Option<f64>,
    /// The hammer's displacement in the fixed frame, x: least and largest, m.
    pub reach_m: [f64; 2],
    /// x at drive phase 0, oldest first, m.
    pub section_m: Vec<f64>,
    /// Mean energy of each mode, J, relative to the cart.
    pub energy_j: PerMode,
    /// Mean power that damping takes from each mode, W.
    pub loss_w: PerMode,
    /// Mean power that the contact takes, W.
    pub contact_loss_w: f64,
}

/// Runs `hammer` of `rig` through `cycles`.
pub(super) fn watched(
    mut hammer: Follower,
    rig: &ModalRig,
    frequency_hz: f64,
    cycles: Cycles,
) -> Result<ModalObservation, Error> {
    let lost = |state: &ModalState| -> Result<(), Error> {
        if state.tip().abs() < 1.0 {
            return Ok(());
        }
        Err(ModesError::Lost { frequency_hz }.into())
    };
    let mut recorded = (cycles.cycles - cycles.transient) as usize;
    let mut arrival = Arrival::of_section(hammer.section(), STILL);
    for left in (0..cycles.transient as usize).rev() {
        hammer.skip();
        if let Some(fewer) = repeated(arrival.at(hammer.section()), left, recorded) {
            recorded = fewer;
            break;
        }
    }
    let start = hammer.state();
    lost(&start)?;
    let mut sampler = ModesSampler::new(rig.clone(), frequency_hz, &start);
    for _ in 0..recorded {
        let mut work = 0.0;
        let period = hammer.run_period(|state, cart_m| sampler.see(state, cart_m), |w| work += w);
        sampler.worked(work);
        let state = hammer.state();
        lost(&state)?;
        sampler.close(&state, &period);
    }
    Ok(sampler.observation(hammer.take_strongest()))
}

/// Follows a run at the ends and middles of its steps; integrals by the trapezoidal rule.
pub(super) struct ModesSampler {
    rig: ModalRig,
    pub(super) frequency_hz: f64,
    detector: Detector<f64>,
    /// Time, energies and losses last seen.
    last: (f64, PerMode, PerMode),
    /// What was seen: of energies, losses and the contact's, the integrals over time.
    seen: ModalObservation,
}

impl ModesSampler {
    /// For a run that is watched from `state`, at drive phase 0, on.
    pub(super) fn new(rig: ModalRig, frequency_hz: f64, state: &ModalState) -> Self {
        let amplitude = rig.amplitude_m;
        let mut detector = Detector::new(amplitude, amplitude * (TAU * frequency_hz));
        detector.push(state.tip(), state.tip_rate(), &Period::default());
        let last = (0.0, rig.energies(state), rig.losses(state));
        let seen = ModalObservation {
            regime: Regime::None,
            force_n: 0.0,
            approach_m_per_s: None,
            reach_m: [f64::INFINITY, f64::NEG_INFINITY],
            section_m: Vec::new(),
            energy_j: PerMode::default(),
            loss_w: PerMode::default(),
            contact_loss_w: 0.0,
        };
        Self {
            rig,
            frequency_hz,
            detector,
            last,
            seen,
        }
    }

    /// The surface took `work`, J.
    pub(super) fn worked(&mut self, work: f64) {
        self.seen.contact_loss_w += work;
    }

    /// A drive period has ended at `state`.
    pub(super) fn close(&mut self, state: &ModalState, period: &Period<f64>) {
        self.last.0 = 0.0;
        self.detector.push(state.tip(), state.tip_rate(), period);
        self.seen.section_m.push(state.tip());
        self.seen.force_n = self.seen.force_n.max(period.peak_force);
    }

    /// What the periods showed, the `strongest` contact among it.
    pub(super) fn observation(self, strongest: Option<Contact<f64>>) -> ModalObservation {
        let time = self.seen.section_m.len() as f64 / self.frequency_hz;
        ModalObservation {
            regime: self.detector.regime(),
            approach_m_per_s: strongest.map(|contact| contact.approach_speed),
            energy_j: self.seen.energy_j.map(|e| e / time),
            loss_w: self.seen.loss_w.map(|e| e / time),
            contact_loss_w: self.seen.contact_loss_w / time,
            ..self.seen
        }
    }

    /// The hammer at `state`, its cart `cart_m` off its course.
    pub(super) fn see(&mut self, state: &ModalState, cart_m: f64) {
        let x =
            state.tip() + self.rig.amplitude_m * (TAU * self.frequency_hz * state.t).sin() + cart_m;
        let [least, most] = self.seen.reach_m;
        self.seen.reach_m = [least.min(x), most.max(x)];
        let (energies, losses) = (self.rig.energies(state), self.rig.losses(state));
        let half = 0.5 * (state.t - self.last.0);
        for i in 0..MAX_MODES {
            self.seen.energy_j[i] += half * (energies[i] + self.last.1[i]);
            self.seen.loss_w[i] += half * (losses[i] + self.last.2[i]);
        }
        self.last = (state.t, energies, losses);
    }
}

/// One run as a row of a table. Units are in the names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModesRow {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// How the cart is moved.
    pub cart: CartModel,
    /// How the hammer holds the beam's end.
    pub tip: TipJoint,
    /// Mass of the springs over the hammer's.
    pub springs_mass_ratio: f64,
    /// Number of bending modes kept.
    pub modes: usize,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the first mode's natural frequency.
    pub frequency_ratio: f64,
    /// "p/n", "none", "aperiodic" or "chatter".
    #[serde(serialize_with = "regime_as_text")]
    pub regime: Regime,
    /// p: contacts in n periods; when nothing repeats, in the last 16 recorded periods.
    pub impacts: u16,
    /// n; none when the section does not repeat, or nothing touches.
    pub periods: Option<u8>,
    /// Largest contact force over the hammer's weight.
    pub force_ratio: f64,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Approach speed of the strongest contact, m/s.
    pub approach_speed_m_per_s: Option<f64>,
    /// Largest less least displacement in the fixed frame, mm.
    pub swing_mm: f64,
    /// Mean displacement at drive phase 0, mm.
    pub section_mm: f64,
    /// Largest less least displacement at drive phase 0, mm.
    pub section_spread_mm: f64,
    /// Mean energy of all modes, mJ.
    pub energy_mj: f64,
    /// Share of it in all modes but the first.
    pub higher_energy_share: f64,
    /// Share of the modes' damping losses that is not the first's.
    pub higher_loss_share: f64,
    /// Mean power the contact takes, mW.
    pub contact_loss_mw: f64,
    /// Mean power the modes' damping takes, mW.
    pub damping_loss_mw: f64,
    /// Share of the energy in mode 2.
    pub energy_share_2: f64,
    /// Share of the energy in mode 3.
    pub energy_share_3: f64,
    /// Share of the energy in mode 4.
    pub energy_share_4: f64,
    /// Share of the energy in mode 5.
    pub energy_share_5: f64,
    /// Share of the energy in modes 6 to 8.
    pub energy_share_6_to_8: f64,
}

impl ModesRow {
    fn new(
        rig: &NamedRig,
        beam: Beam,
        modes: usize,
        frequency_hz: f64,
        seen: &ModalObservation,
    ) -> Self {
        let params: &RigParams = &rig.params;
        let count = seen.section_m.len() as f64;
        let [least, most] = extent(seen.section_m.iter().copied());
        let energy: f64 = seen.energy_j.iter().sum();
        let loss: f64 = seen.loss_w.iter().sum();
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let of_energy = |i: usize| share(seen.energy_j[i], energy);
        Self {
            rig: rig.name.clone(),
            gap_mm: tidy(params.gap_m * 1e3),
            cart: CartModel::of(params),
            tip: beam.tip,
            springs_mass_ratio: beam.mass_ratio,
            modes,
            frequency_hz: tidy(frequency_hz),
            frequency_ratio: tidy(frequency_hz / params.natural_frequency_hz()),
            regime: seen.regime,
            impacts: seen.regime.impacts(),
            periods: seen.regime.periods(),
            force_ratio: seen.force_n / params.weight_n(),
            force_n: seen.force_n,
            approach_speed_m_per_s: seen.approach_m_per_s,
            swing_mm: 1e3 * (seen.reach_m[1] - seen.reach_m[0]),
            section_mm: 1e3 * seen.section_m.iter().sum::<f64>() / count,
            section_spread_mm: 1e3 * (most - least),
            energy_mj: 1e3 * energy,
            higher_energy_share: share(energy - seen.energy_j[0], energy),
            higher_loss_share: share(loss - seen.loss_w[0], loss),
            contact_loss_mw: 1e3 * seen.contact_loss_w,
            damping_loss_mw: 1e3 * loss,
            energy_share_2: of_energy(1),
            energy_share_3: of_energy(2),
            energy_share_4: of_energy(3),
            energy_share_5: of_energy(4),
            energy_share_6_to_8: (5..MAX_MODES).map(of_energy).sum(),
        }
    }
}
