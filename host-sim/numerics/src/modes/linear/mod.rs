//! The hammer with its bending modes in a cart that may recoil: runs, and 1/1 orbits.
//!
//! With a spring-dashpot contact both phases of the motion, flight and contact, are linear and driven by a sine. The state
//! with sin Ωt, cos Ωt and 1 beside it moves by Ż = A Z with one constant matrix per phase, so a step of any length is a
//! matrix exponential, exact but for rounding, and the derivative of the return map is a product of such matrices and of
//! the saltations at the switches.
//!
//! The modes are those of [`super::ModalRig`], now under the cart's own acceleration ÿ,
//! m_i (η̈_i + 2ζω_i η̇_i + ω_i² η_i) = −Γ_i ÿ − F, and momentum gives that of the cart, y = y* + e: with the shaker's force
//! Fs of [`shared::model::cart`],
//!
//! (M + m + m_b − Σ Γ_i²/m_i) ÿ = Fs + Σ Γ_i (F/m_i + 2ζω_i η̇_i + ω_i² η_i).
//!
//! Lengths are in A0 and times in 1/Ω.

mod follow;
mod orbit;
mod run;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use shared::model::cart::{CartDrive, LoopParams};
use shared::model::contact::Law;
use shared::model::params::RigParams;

use super::dense::{Square, dot};
use super::{Beam, ModalRig};
use crate::error::{Error, ModesError};

pub use follow::Follower;
pub use orbit::ModalOrbit;

/// A step turns the fastest motion of its phase by no more than this, rad.
const TURN_PER_STEP: f64 = 0.5;

/// Steps in a drive period at least: ends and middles show the extremes of the displacement to some 1e-5 of them.
const STEPS_PER_PERIOD: f64 = 256.0;

/// A shaker that holds a cart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldingShaker {
    /// Parameters of the shaker's position loop.
    pub held: LoopParams,
    /// Mass M of the cart, kg.
    pub cart_kg: f64,
    /// Mass of hammer and springs, kg.
    pub hung_kg: f64,
}

/// Base steps that a flight far from the surface takes at once.
const LEAP: usize = 1 << FAR;

/// Place on the ladder of the base step, and how much farther up that of a leap is.
const WHOLE: usize = 3;
const FAR: usize = 4;

/// The motion at one drive frequency.
#[derive(Clone, Debug)]
pub struct LinearMotion {
    modes: usize,
    /// Whether the cart recoils.
    recoils: bool,
    frequency_hz: f64,
    /// A0 Ω² and A0 Ω.
    units: (f64, f64),
    free: Phase,
    pressing: Phase,
    /// δ/A0, δ̇/(A0 Ω) and the law's F/(A0 Ω²), kg, as rows on the state.
    delta: Vec<f64>,
    rate: Vec<f64>,
    force: Vec<f64>,
}

/// One of the two linear phases.
#[derive(Clone, Debug)]
struct Phase {
    a: Square,
    /// Base step h, in 1/Ω: the fastest motion turns by no more than [`TURN_PER_STEP`] in it.
    step: f64,
    /// e^(A h/8), e^(A h/4), e^(A h/2), e^(A h), e^(2 A h) ...
    ladder: Vec<Square>,
    /// What a state makes of penetration and its rate after each of the next [`LEAP`] base steps, a column for each of its numbers.
    ahead: Vec<[[f64; 2]; LEAP]>,
    /// The rates of penetration and of the law's force, as rows on the state.
    slopes: Slopes,
}

#[derive(Clone, Debug)]
struct Slopes {
    delta: Vec<f64>,
    force: Vec<f64>,
}

impl Phase {
    fn new(a: Square, step: f64, delta: &[f64], force: &[f64]) -> Self {
        let finest = step / (1 << WHOLE) as f64;
        let mut ladder = vec![a.exponential(finest)];
        while finest * 2.0_f64.powi(ladder.len() as i32) < TAU {
            let last = &ladder[ladder.len() - 1];
            ladder.push(last.times(last));
        }
        let slopes = Slopes {
            delta: a.after(delta),
            force: a.after(force),
        };
        let mut ahead = vec![[[0.0; 2]; LEAP]; delta.len()];
        let mut rows = [delta.to_vec(), slopes.delta.clone()];
        for k in 0..LEAP {
            rows = rows.map(|row| ladder[WHOLE].after(&row));
            for (i, column) in ahead.iter_mut().enumerate() {
                column[k] = rows.each_ref().map(|row| row[i]);
            }
        }
        Self {
            a,
            ahead,
            step,
            ladder,
            slopes,
        }
    }

    /// e^(A t), which leads over the time `t`, in 1/Ω.
    fn over(&self, t: f64) -> Square {
        let finest = self.step / (1 << WHOLE) as f64;
        let whole = (t / finest).floor();
        let mut product = self.a.exponential(t - whole * finest);
        for (k, power) in self.ladder.iter().enumerate() {
            if (whole as u64) >> k & 1 == 1 {
                product = power.times(&product);
            }
        }
        product
    }
}
impl LinearMotion {
    /// `params` with the `count` lowest modes of `beam` at `frequency_hz`, its cart as in `params`.
    ///
    /// # Errors
    /// As [`ModalRig::new`], except that a gap may be negative: the orbits are not those of a start from rest, free of the
    /// surface. Also if the frequency is not a positive number.
    pub fn of(
        params: &RigParams,
        beam: Beam,
        count: usize,
        frequency_hz: f64,
    ) -> Result<Self, Error> {
        let open = RigParams {
            gap_m: params.gap_m.max(0.0),
            ..*params
        };
        let mut rig = ModalRig::new(&open, beam, count)?;
        rig.gap_m = params.gap_m;
        if !(frequency_hz > 0.0 && frequency_hz.is_finite()) {
            return Err(Error::Frequency(frequency_hz));
        }
        let held = match params.cart {
            CartDrive::Prescribed => None,
            CartDrive::Loop(held) => Some(HoldingShaker {
                held,
                cart_kg: params.cart_mass_kg,
                hung_kg: params.mass_kg * (1.0 + beam.mass_ratio),
            }),
        };
        Self::new(&rig, held, frequency_hz)
    }

    /// `rig` at `frequency_hz`, held by `held` or prescribed.
    ///
    /// # Errors
    /// If the law is not the spring-dashpot.
    pub fn new(
        rig: &ModalRig,
        held: Option<HoldingShaker>,
        frequency_hz: f64,
    ) -> Result<Self, Error> {
        let Law::SpringDashpot { stiffness, damping } = rig.law else {
            return Err(ModesError::Law.into());
        };
        let omega = TAU * frequency_hz;
        let n = rig.modes.len();
        let size = 2 * n + if held.is_some() { 2 } else { 0 } + 3;
        let one = size - 1;
        let (mut delta, mut rate) = (vec![0.0; size], vec![0.0; size]);
        delta[..n].fill(1.0);
        delta[one] = -rig.gap_m / rig.amplitude_m;
        rate[n..2 * n].fill(1.0);
        let force: Vec<f64> = (0..size)
            .map(|i| (stiffness * delta[i] / omega + damping * rate[i]) / omega)
            .collect();
        let inverse_mass: f64 = rig.modes.iter().map(|m| 1.0 / m.mass_kg).sum();
        let highest = rig.modes.iter().map(|m| m.omega).fold(0.0, f64::max);
        let in_contact = (stiffness * inverse_mass)
            .sqrt()
            .max(damping * inverse_mass);
        let phase = |acting: &[f64], fastest: f64| {
            let step = (TURN_PER_STEP * omega / fastest).min(TAU / STEPS_PER_PERIOD);
            Phase::new(field(rig, held, omega, acting), step, &delta, &force)
        };
        let held_at = held.map_or(0.0, |shaker| TAU * shaker.held.frequency_hz);
        let (free, pressing) = (
            phase(&vec![0.0; size], highest.max(held_at)),
            phase(&force, highest.max(held_at).max(in_contact)),
        );
        Ok(Self {
            modes: n,
            recoils: held.is_some(),
            frequency_hz,
            units: (rig.amplitude_m * omega * omega, rig.amplitude_m * omega),
            free,
            pressing,
            delta,
            rate,
            force,
        })
    }

    /// Size of the section.
    fn section_size(&self) -> usize {
        2 * self.modes + if self.recoils { 2 } else { 0 }
    }

    /// The state at drive phase 0 over a section point.
    fn at_phase_zero(&self, section: &[f64]) -> Vec<f64> {
        let mut z = section.to_vec();
        z.extend([0.0, 1.0, 1.0]);
        z
    }

    fn phase(&self, touching: bool) -> &Phase {
        if touching { &self.pressing } else { &self.free }
    }

    /// Whether the hammer touches and pushes.
    fn pushes(&self, z: &[f64]) -> bool {
        dot(&self.delta, z) > 0.0 && dot(&self.force, z) > 0.0
    }
}

/// The matrix of a phase whose contact force over A0 Ω² is `force`, as a row on the state.
fn field(rig: &ModalRig, held: Option<HoldingShaker>, omega: f64, force: &[f64]) -> Square {
    let size = force.len();
    let (n, sine) = (rig.modes.len(), size - 3);
    let mut a = Square::zero(size);
    *a.at_mut(sine, sine + 1) = 1.0;
    *a.at_mut(sine + 1, sine) = -1.0;
    // What spring and damper of mode i hold back, over its mass.
    let holding = |i: usize| {
        let (own, mut row) = (rig.modes[i].omega / omega, vec![0.0; size]);
        row[i] = own * own;
        row[n + i] = 2.0 * rig.damping_ratio * own;
        row
    };
    let mut cart = vec![0.0; size];
    cart[sine] = -1.0;
    if let Some(HoldingShaker {
        held,
        cart_kg,
        hung_kg,
    }) = held
    {
        let own = TAU * held.frequency_hz / omega;
        let carried: f64 = rig
            .modes
            .iter()
            .map(|m| m.participation_kg * m.participation_kg / m.mass_kg)
            .sum();
        let moved = cart_kg + hung_kg - carried;
        let mut push = vec![0.0; size];
        push[2 * n] = -cart_kg * own * own;
        push[2 * n + 1] = -2.0 * held.damping_ratio * cart_kg * own;
        push[sine] = -held.feed_forward * cart_kg;
        for (i, mode) in rig.modes.iter().enumerate() {
            for (sum, (h, f)) in push.iter_mut().zip(holding(i).iter().zip(force)) {
                *sum += mode.participation_kg * (h + f / mode.mass_kg);
            }
        }
        cart = push.iter().map(|x| x / moved).collect();
        *a.at_mut(2 * n, 2 * n + 1) = 1.0;
        a.set_row(2 * n + 1, &cart);
        *a.at_mut(2 * n + 1, sine) += 1.0;
    }
    for (i, mode) in rig.modes.iter().enumerate() {
        *a.at_mut(i, n + i) = 1.0;
        let held_back = holding(i);
        for k in 0..size {
            *a.at_mut(n + i, k) =
                -(mode.participation_kg * cart[k] + force[k]) / mode.mass_kg - held_back[k];
        }
    }
    a
}
