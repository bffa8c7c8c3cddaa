//! The beam rig with more than one bending mode.
//!
//! The chapter models the beam springs by their first bending mode (3-30) and blames the modes it leaves out for
//! displacements that come out too large. Here the springs are an Euler–Bernoulli beam, clamped to the cart, with the
//! hammer as its tip mass, and as many of its modes are kept as one wants:
//!
//! m_i (η̈_i + 2ζ ω_i η̇_i + ω_i² η_i) = Γ_i A0 Ω² sin Ωt − F,  Δ = Σ η_i,  δ = Δ − gap,
//!
//! with shapes that are 1 at the hammer, modal masses m_i and participations Γ_i ([`beam`]). Flight and contact are both
//! linear: [`linear`] runs them, and finds the 1/1 orbits. [`ModesRequest`] summarises runs. The tests compare both with an
//! engine that integrates the contacts.

pub mod beam;
pub mod dense;
pub mod linear;
mod log;
mod observe;

pub use beam::{Beam, BendingMode, TipJoint};
pub use observe::{ModalObservation, ModesRequest, ModesRow};

use shared::model::contact::Law;
use shared::model::params::{RigParams, SupportParams};

use crate::error::{Error, ModesError};

/// Most modes that can be kept. The eighth of a beam rig is well above the contact's own 684 Hz.
pub const MAX_MODES: usize = 8;

/// One number for every mode; those that are not kept are 0.
pub type PerMode = [f64; MAX_MODES];

/// A beam rig in modal coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalRig {
    /// The modes kept, lowest first.
    pub modes: Vec<BendingMode>,
    /// ζ of every mode.
    pub damping_ratio: f64,
    /// Cart amplitude A0, m.
    pub amplitude_m: f64,
    /// Clearance at rest, m.
    pub gap_m: f64,
    /// The contact law, a spring-dashpot.
    pub law: Law<f64>,
}

/// Where the hammer is: the modal coordinates and their rates at a time after drive phase 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModalState {
    /// Time since drive phase 0, s.
    pub t: f64,
    /// η_i, m: what each mode moves the hammer, relative to the cart.
    pub q: PerMode,
    /// η̇_i, m/s: rates of the modal coordinates.
    pub v: PerMode,
}

impl ModalState {
    /// Δ, m: the hammer relative to the cart.
    pub fn tip(&self) -> f64 {
        self.q.iter().sum()
    }

    /// Δ̇, m/s: rate of the hammer's displacement relative to the cart.
    pub fn tip_rate(&self) -> f64 {
        self.v.iter().sum()
    }
}

impl ModalRig {
    /// The beam rig of `params` with the `count` lowest modes of `beam`, the first at the rig's natural frequency. The
    /// rig's mass is the hammer's; the beam's comes on top. The chapter's cubic term is left out.
    ///
    /// # Errors
    /// If the rig is not on beams or has a parameter out of range, if the law is not the spring-dashpot, if the gap is
    /// below 0, if a cubic stiffness is given, or if the number of modes or the mass of the beam is out of range.
    pub fn new(params: &RigParams, beam: Beam, count: usize) -> Result<Self, Error> {
        params.check()?;
        let SupportParams::Beams {
            natural_frequency_hz,
            damping_ratio,
            cubic_stiffness_n_per_m3,
        } = params.support
        else {
            return Err(ModesError::NotBeams.into());
        };
        if !matches!(params.contact, Law::SpringDashpot { .. }) {
            return Err(ModesError::Law.into());
        }
        if params.gap_m < 0.0 {
            return Err(ModesError::Gap(params.gap_m).into());
        }
        if cubic_stiffness_n_per_m3.is_some_and(|cubic| cubic != 0.0) {
            return Err(ModesError::Cubic.into());
        }
        if !(1..=MAX_MODES).contains(&count) {
            return Err(ModesError::Count {
                count,
                most: MAX_MODES,
            }
            .into());
        }
        Ok(Self {
            modes: beam.modes(params.mass_kg, natural_frequency_hz, count)?,
            damping_ratio,
            amplitude_m: params.amplitude_m,
            gap_m: params.gap_m,
            law: params.contact,
        })
    }

    /// Energy of each mode, J, relative to the cart.
    pub fn energies(&self, state: &ModalState) -> PerMode {
        let mut e = PerMode::default();
        for (i, mode) in self.modes.iter().enumerate() {
            let spring = mode.omega * state.q[i];
            e[i] = 0.5 * mode.mass_kg * (state.v[i] * state.v[i] + spring * spring);
        }
        e
    }

    /// What damping takes from each mode, W.
    pub fn losses(&self, state: &ModalState) -> PerMode {
        let mut p = PerMode::default();
        for (i, mode) in self.modes.iter().enumerate() {
            let c = 2.0 * self.damping_ratio * mode.omega * mode.mass_kg;
            p[i] = c * state.v[i] * state.v[i];
        }
        p
    }
}

#[cfg(test)]
mod tests;
