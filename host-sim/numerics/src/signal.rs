//! What a sensor recorded over time.

use crate::error::{Error, RecordError};

/// Fewest samples that a record, or a part of one, can have.
pub const FEWEST_SAMPLES: usize = 16;

/// A recording: as many values in each column as there are times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// What errors and titles call the record: mostly its file.
    pub name: String,
    /// Times of the samples, rising, s.
    pub time_s: Vec<f64>,
    /// Contact force at each time, N; none if it was not recorded.
    pub force_n: Option<Vec<f64>>,
    /// Hammer displacement at each time, fixed frame or relative to the cart, mm; none if not recorded.
    pub displacement_mm: Option<Vec<f64>>,
    /// Cart displacement, fixed frame, mm.
    pub cart_mm: Option<Vec<f64>>,
}

impl Signal {
    /// The median time from sample to sample, s.
    pub fn sample_s(&self) -> f64 {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// What was recorded from `from_s` to `to_s`.
    ///
    /// # Errors
    /// If fewer than 16 samples are left.
    pub fn between(&self, from_s: f64, to_s: f64) -> Result<Self, Error> {
        let first = self.time_s.partition_point(|t| *t < from_s);
        let end = self.time_s.partition_point(|t| *t <= to_s).max(first);
        if end - first < FEWEST_SAMPLES {
            let end_s = |end: Option<&f64>| end.copied().unwrap_or(f64::NAN);
            return Err(self.lacks(RecordError::Samples {
                count: end - first,
                part_s: (from_s, to_s),
                whole_s: (end_s(self.time_s.first()), end_s(self.time_s.last())),
            }));
        }
        let cut = |column: &Option<Vec<f64>>| column.as_ref().map(|c| c[first..end].to_vec());
        Ok(Self {
            name: self.name.clone(),
            time_s: self.time_s[first..end].to_vec(),
            force_n: cut(&self.force_n),
            displacement_mm: cut(&self.displacement_mm),
            cart_mm: cut(&self.cart_mm),
        })
    }

    /// The error that says what this record lacks.
    pub fn lacks(&self, what: RecordError) -> Error {
        Error::Record {
            record: self.name.clone(),
            what,
        }
    }
}
