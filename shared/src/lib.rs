//! # The vibro-impact hammer, computed
//!
//! A hammer hangs in a cart, on wires or on beam springs. A shaker moves the cart as y = A0 sin Ωt; at the
//! right frequency the hammer strikes the cart's impact surface hard, once per cycle. This crate is the
//! model of that motion, once, for `f32` on a microcontroller and `f64` on a desktop. It has no heap, no
//! `unsafe`, no clock and no logger, and a step cannot panic (the firmware's link check shows it).
//!
//! It follows the chapter *Study of an embarked vibro-impact system: mathematical modeling and nonlinear
//! analysis*; numbers in brackets, (3-16), are its equations, and "Table 3.1" is its table.
//!
//! ## What is where
//!
//! | folder or file | holds | may use |
//! |---|---|---|
//! | [`model`] | the hammer's motion, for `f32` and `f64` | nothing of this crate |
//! | [`forecast`] | orbits and their multipliers, computed in slices beside the control task | `model` |
//! | [`io`], [`settings`], [`fault`] | the controller's inputs and outputs, what it must be given, what trips it | `model` |
//! | [`sense`] | contacts, section, regime and identified parameters, from samples | those above |
//! | [`control`] | the controller | those above |
//! | [`link`] | the serial protocol, settings in flash, messages for the processor in the loop | all |
//!
//! ## Reading order
//!
//! 1. [`model::scalar`]: what a number must be able to do ([`Real`]), and sums that lose nothing
//!    ([`model::scalar::Compensated`]). [`model::trig`]: sine for small angles, with its error.
//! 2. [`model::drive`]: the shaker's phase. A 32-bit accumulator wraps once per period and is the only time there
//!    is; a phasor is rotated beside it and set afresh four times per turn.
//! 3. [`model::contact`]: force from penetration: the contact laws; when a contact pushes, and when it would pull.
//! 4. [`model::params`]: what a rig is, and the four presets. [`model::rig`]: the equations of motion of both rigs.
//! 5. [`model::switch`]: the Filippov model. Two indicators, h_α = δ (touching) and h_β = F (pushing), four fields.
//! 6. [`model::step`]: three ways across the switch at a fixed step. [`model::contacts`]: the record of each contact.
//! 7. [`model::regime`]: z = p/n from the section at drive phase 0. [`model::twin`]: all of it, a tick at a time.
//! 8. [`model::tangent`] and [`forecast`]: periodic orbits and their multipliers in slices.
//! 9. [`io`], [`settings`], [`fault`].
//! 10. [`sense`]: contacts, section, regime, and the identification of the rig, from samples.
//! 11. [`control`]: the controller. [`link`]: the serial protocol; [`link::store`]: settings in flash.
//!
//! ## The motion
//!
//! On wires of length l, θ from the vertical, relative to the cart (3-15 to 3-18):
//!
//! ```text
//! θ̈ = (A0 Ω²/l) cos θ sin Ωt − (g/l) sin θ − F/(m l),     δ = l sin θ − gap,   δ̇ = l θ̇ cos θ
//! ```
//!
//! On beam springs, Δ = x − y (3-30 to 3-39), with k = mω², c = 2ζmω:
//!
//! ```text
//! m Δ̈ + c Δ̇ + k Δ + κ Δ³ + F = m A0 Ω² sin Ωt,            δ = Δ − gap,         δ̇ = Δ̇
//! ```
//!
//! F acts only in contact: when δ > 0 *and* the law pushes. In print the chapter has some signs the other
//! way round ("no impact, l sin θ − gap > 0"; "x − (y + gap) > 0"), h_α for beams as A0 sin Ωt + gap where
//! x − y − gap is meant (3-35), and the contact torque of (3-16) as F l where a horizontal force has
//! F l cos θ. The torque is kept as printed, so that the chapter's figures are reproduced, and corrected by
//! a parameter ([`model::params::Torque`]); at a gap of 3.56 mm and Ω/ω = 1.4 it changes the force by 0.03 %, at
//! 0.0 mm by nothing.
//!
//! ## The switch
//!
//! The surface is some thousand times stiffer than what the hammer hangs on: a contact of Table 3.1 lasts
//! 0.571 ms in a cycle of 100 to 700 ms. Its force jumps at onset (the dashpot acts at once: 96 N at
//! 0.08 m/s) and vanishes, with δ still positive, at release. An integrator that does not know where that
//! happens misplaces it by up to a step; at 20 kHz that is several percent of the contact. Three steppers:
//!
//! | stepper | at the switch | at a 50 µs tick in f32 |
//! |---|---|---|
//! | [`model::step::Banded`] | the chapter's band of 2η about it, field by stage | force wrong by up to 8 %, sections that never repeat |
//! | [`model::step::Corrected`] | the step is split there, four secant iterations at most | within 0.007 % on 200 random orbits |
//! | [`model::step::Smoothed`] | arctangents in its place | stiff; needs far shorter steps |
//!
//! The measured tables are in `docs/accuracy.md`.
//!
//! ## Regimes
//!
//! The section is taken once per drive period, at phase 0. z = p/n: p contacts in n periods, n the smallest
//! number of periods after which the section repeats, not reduced (a doubled 1/1 is 2/2). `none`,
//! `aperiodic` and `chatter` have stated rules: [`model::regime::Regime`].
//!
//! ## In use
//!
//! ```
//! use shared::model::drive::Drive;
//! use shared::model::params::WIRES;
//! use shared::model::rig::Rig;
//! use shared::model::step::Corrected;
//! use shared::model::twin::Twin;
//!
//! // Wires, gap 0.0 mm, 1.5 times the natural frequency, 20 kHz, as the microcontroller computes it.
//! let rig = Rig::<f32>::new(&WIRES)?;
//! let drive = Drive::new(1.5 * WIRES.natural_frequency_hz(), 50e-6)?;
//! let mut twin = Twin::at_rest(rig, drive, Corrected);
//! let mut detector = twin.detector();
//! let mut peak = 0.0_f32;
//! let mut periods = 0;
//! while periods < 150 {
//!     if let Some(strobe) = twin.tick().strobe {
//!         periods += 1;
//!         if periods > 100 {
//!             detector.push(strobe.q, strobe.v, &strobe.period);
//!             peak = peak.max(strobe.period.peak_force);
//!         }
//!     }
//! }
//! assert!(detector.regime().is(1, 1));
//! assert!((f64::from(peak) / WIRES.weight_n() - 17.151).abs() < 0.004);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod control;
mod crc_32;
pub mod fault;
pub mod forecast;
pub mod io;
pub mod link;
pub mod model;
pub mod sense;
pub mod settings;

pub use model::scalar::Real;
