//! Sentences about a record beside its simulation.

use numerics::compare::{ComparisonErrors, Note};
use serde::Serialize;

/// The figures of a comparison with its notes in words, as JSON has them.
#[derive(Serialize)]
pub struct WordedComparison<'a> {
    /// The figures of the comparison; in JSON they stand beside `notes`.
    #[serde(flatten)]
    pub errors: &'a ComparisonErrors,
    /// What to keep in mind.
    pub notes: Vec<String>,
}

impl<'a> From<&'a ComparisonErrors> for WordedComparison<'a> {
    fn from(errors: &'a ComparisonErrors) -> Self {
        Self {
            errors,
            notes: errors.notes.iter().map(note).collect(),
        }
    }
}

fn note(note: &Note) -> String {
    match *note {
        Note::NotRepeating => "the simulation does not repeat: histories drift apart, compare the phase plane and the forces".to_owned(),
        Note::CartAmplitude {
            measured_mm,
            assumed_mm,
        } => format!(
            "the cart moves by {measured_mm:.4} mm, the simulation's by {assumed_mm:.4} mm: --set amplitude_mm={measured_mm:.4} compares like with like"
        ),
        Note::CartUnused => {
            "the cart does not move at this frequency alone: its phase is not used".to_owned()
        }
        Note::CoarseContacts { samples } => format!(
            "the record has {samples:.1} samples in a contact: the measured contact time is known to one sample, the largest force may lie between two"
        ),
        Note::NoContact => "no contact stands out in the measured force".to_owned(),
        Note::FrequencyFound => "the drive frequency is found from the record: the strongest pitch or a multiple of it, whichever the simulation is most like; give --frequency if it is known".to_owned(),
    }
}
