//! What only a person can do: acknowledge an emergency stop, and say which settings are the rig's.

use super::{Refused, SettingsState};

/// The emergency-stop chain must have been closed for so long before its opening can be acknowledged, ticks: 20 ms, longer
/// than contacts bounce.
pub(super) const CLOSED_TICKS: u32 = 400;

/// What a person has still to do. Outlives a replacement of the settings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Operator {
    /// Where the settings come from.
    pub settings: SettingsState,
    /// An emergency stop has not been acknowledged, and must be.
    awaited: bool,
    /// When the chain was last seen open, ticks.
    open_at: u32,
}

impl Operator {
    /// The emergency-stop chain is open; `required`: the settings ask for an acknowledgement. What was once required stays
    /// so, whatever settings are sent.
    pub fn emergency(&mut self, tick: u32, required: bool) {
        self.awaited |= required;
        self.open_at = tick;
    }

    /// Whether an acknowledgement is awaited.
    pub fn is_awaited(&self) -> bool {
        self.awaited
    }

    /// Takes an acknowledgement.
    pub fn acknowledge(&mut self, tick: u32) -> Result<(), Refused> {
        if !self.awaited {
            return Err(Refused::WrongState);
        }
        if tick.wrapping_sub(self.open_at) < CLOSED_TICKS {
            return Err(Refused::StillFaulty);
        }
        self.awaited = false;
        Ok(())
    }
}
