//! # Analyses of the hammer's motion
//!
//! Plain numbers in, plain values out. The model itself is in [`shared`]; here it is run, held to a reference,
//! searched and mapped. Nothing here knows a command line, a terminal, a picture or a file: errors are values
//! ([`error::Error`]) that the caller words, progress is reported to a trait ([`progress::Progress`]), which can also
//! end the work.
//!
//! | step | modules |
//! |---|---|
//! | engine | [`flow`]: phases of a motion, one integrator for all of them; [`mod@reference`]: event-located, f64; [`engine`]: the reference and the switch model of `shared` behind one trait; [`lanes`]: many short simulations side by side |
//! | orbits | [`orbit`]: periodic orbits by shooting, with multipliers from [`dual`] numbers; [`branch`]: the stable 1/1 followed to its ends; [`continuation`]: curves of orbits, stable and not, with their special points |
//! | operating point | [`pick`]: which frequency, how hard, and will it stay there |
//! | over a range | [`sweep`]: the force curve; [`map`]: regimes over gap and frequency; [`bifurcation`]; [`basins`] |
//! | one motion | [`poincare`], [`lyapunov`], [`modes`]: beams with several bending modes |
//! | ground that gives way | [`drill`]: rate of penetration over frequency and gap |
//! | the contact | [`contact_law`], [`drop_test`] as a sensor sees it ([`low_pass`]), [`identify`], [`compare`] with a [`signal`] |
//! | underneath | [`parallel`]: work shared out over the threads; [`progress`], [`error`] |

pub mod basins;
pub mod bifurcation;
pub mod branch;
// The page reads no records: less to compile.
#[cfg(not(target_family = "wasm"))]
pub mod compare;
pub mod contact_law;
pub mod continuation;
pub mod drill;
pub mod drop_test;
pub mod dual;
pub mod engine;
pub mod error;
pub mod flow;
mod found_once;
#[cfg(not(target_family = "wasm"))]
pub mod identify;
mod interpolation;
pub mod knob;
pub mod lanes;
pub mod limits;
pub mod low_pass;
pub mod lyapunov;
pub mod map;
pub mod modes;
pub mod noise;
pub mod orbit;
pub mod parallel;
pub mod pick;
pub mod poincare;
pub mod progress;
mod range;
pub mod reference;

pub mod root;
pub mod row;
pub mod signal;
pub mod sweep;
pub mod uncertainty;

pub use error::Error;
pub use limits::PickLimits;
pub use row::{CartModel, NamedRig};
pub use uncertainty::Uncertainty;
