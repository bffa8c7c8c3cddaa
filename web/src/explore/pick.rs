//! The recommendation.

use files::words::pick::WordedPick;
use numerics::PickLimits;
use numerics::pick::outline::outline;
use numerics::pick::{Springs, pick_on};
use serde::{Deserialize, Serialize};

use super::rig;
use crate::json::{read, write};

#[derive(Deserialize)]
struct Asked {
    rig: rig::RigAsked,
    gap_mm: f64,
    /// For the rig as it stands, without its uncertainty: quicker.
    nominal: bool,
    max_force_n: Option<f64>,
    max_frequency_hz: Option<f64>,
    max_shaker_force_n: Option<f64>,
}

#[derive(Serialize)]
struct Found<'a> {
    /// The recommendation, as the command `pick` answers.
    #[serde(flatten)]
    answer: WordedPick<'a>,
    /// The nominal stable 1/1: Hz and force ratio.
    curve: &'a [(f64, f64)],
}

/// Random rigs within the uncertainty, and their seed: those of the command `pick`.
const SAMPLES: (u32, u64) = (256, 1);

#[derive(Deserialize)]
struct First {
    rig: rig::RigAsked,
    gap_mm: f64,
}

/// Where the nominal rig is strongest: the first part of [`pick`], for who waits.
pub fn first(argument: &[u8]) -> Result<Vec<u8>, String> {
    let asked: First = read(argument)?;
    let rig = asked.rig.at_gap(asked.gap_mm)?;
    write(&outline(&rig).map_err(|e| files::UserError::from(e).to_string())?)
}

/// The operating point, as the command `pick` finds it.
pub fn pick(argument: &[u8]) -> Result<Vec<u8>, String> {
    let asked: Asked = read(argument)?;
    let rig = asked.rig.at_gap(asked.gap_mm)?;
    let (samples, seed) = SAMPLES;
    let whole = rig
        .stated
        .complete(samples, seed, rig.params.cart.recoils());
    let uncertainty = (!asked.nominal).then_some(whole);
    let limits = PickLimits {
        max_force_n: asked.max_force_n,
        max_frequency_hz: asked.max_frequency_hz,
        max_shaker_force_n: asked.max_shaker_force_n,
        rig_shaker_force_n: None,
    };
    let found = pick_on(&rig, Springs::default(), uncertainty, limits, &())
        .map_err(|e| files::UserError::from(e).to_string())?;
    write(&Found {
        answer: (&found.answer).into(),
        curve: &found.curve,
    })
}
