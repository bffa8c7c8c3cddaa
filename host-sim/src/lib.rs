//! # The hammer on the desktop
//!
//! The answer to one question (at which frequency should the hammer run, how hard will it strike, and will
//! it stay there?) and the means to trust it. The model itself is in [`shared`]; this crate runs it, holds
//! it to a reference, searches it, and shows what it finds.
//!
//! Data goes one way: parameters → engine → table → picture.
//!
//! | step | modules |
//! |---|---|
//! | parameters | [`rigfile`]: presets, TOML files, `key=value` |
//! | engine | [`mod@reference`]: event-located, f64, the truth; the switch model of `shared`, fixed tick, as on the microcontroller; [`engine`]: both behind one interface |
//! | many cells | [`lanes`]: maps, basins and diagrams, cell by cell |
//! | analysis | [`map`]: regimes over gap and frequency; [`sweep`]: the force curve; [`orbit`]: periodic orbits by shooting, with multipliers from [`dual`] numbers; [`branch`]: stable 1/1 followed to its ends; [`continuation`]: curves of orbits, stable and not, with what is special on them; [`pick`]: the operating frequency; [`accuracy`]: the switch model held to the reference |
//! | emulator | [`emulator`]: shaker, two bodies and sensors around the controller, and scenarios to run them by; [`replay`]: a log through the controller again |
//! | link | [`mod@link`]: talking to a board, or an emulated one, over a serial port |
//! | table, picture | [`table`], [`picture`], [`terminal`], [`files`] |
//! | command line | [`cli`] |

pub mod accuracy;
pub mod basins;
pub mod bifurcation;
pub mod branch;
pub mod cli;
pub mod compare;
pub mod contact_law;
pub mod continuation;
pub mod drop_test;
pub mod dual;
pub mod emulator;
pub mod engine;
pub mod error;
pub mod figures;
pub mod files;
pub mod golden;
pub mod identify;
pub mod lanes;
pub mod link;
pub mod lyapunov;
pub mod map;
pub mod modes;
pub mod orbit;
pub mod pick;

pub mod poincare;
pub mod progress;
pub mod reference;
pub mod regime_style;
pub mod replay;
pub mod rigfile;
pub mod signal;
pub mod sweep;
pub mod table;
