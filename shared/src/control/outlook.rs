//! What is known of the future: the forecast as far as control needs it.

use crate::forecast::{MAX_ROWS, Request, Target};

/// What is known of the future.
#[derive(Clone, Debug, Default)]
pub struct Outlook {
    /// Number of the next request.
    pub next_id: u32,
    /// A request nobody has taken yet.
    pub wanted: Option<Request>,
    /// The request that is waited for.
    pub awaited: Option<u32>,
    /// Where to run.
    pub target: Option<Target>,
    /// Whether a forecast has come at all.
    pub come: bool,
    /// Frequency and whether a start from rest strikes there.
    pub strikes: heapless::Vec<(f32, bool), MAX_ROWS>,
}

impl Outlook {
    /// Whether the forecast has contact from rest on both sides of `hz`.
    pub fn strikes_at(&self, hz: f32) -> bool {
        let mut below = None;
        for &(row_hz, strikes) in &self.strikes {
            if row_hz > hz {
                return strikes && below.unwrap_or(strikes);
            }
            below = Some(strikes);
        }
        below.unwrap_or(false)
    }
}
