//! Values of the analyses as choices on the command line.

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use numerics::compare::MeasuredFrame;
use numerics::drop_test::Converter;
use numerics::identify::Misfit;
use numerics::modes::TipJoint;
use numerics::sweep::Direction;
use shared::model::contact::{LAWS, LawKind};

/// A value that can be chosen by name.
pub trait Choice: Clone + Send + Sync + 'static {
    /// Name, help and value of each choice.
    const CHOICES: &'static [(&'static str, &'static str, Self)];
}

/// The parser of a choice.
pub fn choice<T: Choice>() -> impl TypedValueParser<Value = T> {
    let values = T::CHOICES
        .iter()
        .map(|(name, help, _)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(values).try_map(|chosen| {
        let found = T::CHOICES.iter().find(|(name, ..)| *name == chosen);
        found
            .map(|(.., value)| value.clone())
            .ok_or("unknown choice")
    })
}

impl Choice for Converter {
    const CHOICES: &'static [(&'static str, &'static str, Self)] = &[
        ("plain", "samples as they are", Self::Plain),
        (
            "iir",
            "digital low-pass of second order, corner at a fifth of the sampling rate",
            Self::Iir,
        ),
        (
            "fir",
            "digital linear-phase low-pass of 31 samples, the same corner",
            Self::Fir,
        ),
        ("mean", "mean of three samples", Self::Mean),
        (
            "delta-sigma",
            "linear-phase low-pass before the samples are taken, corner at 0.45 of the sampling rate",
            Self::DeltaSigma,
        ),
    ];
}

/// How the cart is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CartChoice {
    /// Prescribed exactly, with any force that this takes, as in the chapter
    Prescribed,
    /// The rig's shaker (shaker_loop_hz) holds it; contacts push it off its course
    Recoil,
}

/// What a pick makes largest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Objective {
    /// Contact force on a surface that stays
    Force,
    /// Rate of penetration on ground that gives way (--threshold-n)
    Rop,
}

impl Choice for Direction {
    const CHOICES: &'static [(&'static str, &'static str, Self)] = &[
        ("rest", "Each frequency from rest", Self::Rest),
        (
            "up",
            "Upwards, each from the end of the previous run",
            Self::Up,
        ),
        (
            "down",
            "Downwards, each from the end of the previous run",
            Self::Down,
        ),
    ];
}

impl Choice for MeasuredFrame {
    const CHOICES: &'static [(&'static str, &'static str, Self)] = &[
        (
            "fixed",
            "Of the laboratory, as the chapter's (3-18)",
            Self::Fixed,
        ),
        ("relative", "Relative to the cart", Self::Relative),
    ];
}

impl Choice for TipJoint {
    const CHOICES: &'static [(&'static str, &'static str, Self)] = &[
        (
            "guided",
            "It cannot turn: two parallel springs hold the hammer upright",
            Self::Guided,
        ),
        (
            "free",
            "It turns with the beam's end: one spring, a small hammer",
            Self::Free,
        ),
    ];
}

impl Choice for LawKind {
    const CHOICES: &'static [(&'static str, &'static str, Self)] = &{
        let mut all = [("", "", Self::Hertz); LAWS.len()];
        let mut i = 0;
        while i < all.len() {
            let kind = LAWS[i].1.kind();
            all[i] = (kind.name(), kind.formula(), kind);
            i += 1;
        }
        all
    };
}

impl Choice for Misfit {
    const CHOICES: &'static [(&'static str, &'static str, Self)] = &[
        (
            "peaks",
            "The chapter's: differences of the force peaks, squared and summed",
            Self::Peaks,
        ),
        (
            "force",
            "Differences of the whole force, squared and summed over the samples",
            Self::Force,
        ),
    ];
}
