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
    /// Its opening was acknowledged since the last start.
    tried: bool,
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

    /// Acknowledges an emergency stop; refused if none awaits that, or the chain was open in the last [`CLOSED_TICKS`].
    /// `opened`: as in [`super::Command::Acknowledge`].
    pub fn acknowledge(&mut self, tick: u32, opened: bool) -> Result<(), Refused> {
        if !self.awaited {
            return Err(Refused::WrongState);
        }
        if tick.wrapping_sub(self.open_at) < CLOSED_TICKS {
            return Err(Refused::StillFaulty);
        }
        self.awaited = false;
        self.tried |= opened;
        Ok(())
    }

    /// A start. `required`: as in [`Self::emergency`]; then the chain's report must have been tried since the last one.
    pub fn start(&mut self, required: bool) -> Result<(), Refused> {
        if required && !self.tried {
            return Err(Refused::ChainNotTried);
        }
        self.tried = false;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chain_must_have_been_closed_for_20_ms() {
        let mut operator = Operator::default();
        assert_eq!(operator.acknowledge(0, true), Err(Refused::WrongState));
        // The count of ticks wraps meanwhile.
        let open_at = u32::MAX - 100;
        operator.emergency(open_at, true);
        let after = |ticks: u32| open_at.wrapping_add(ticks);
        assert_eq!(
            operator.acknowledge(after(399), true),
            Err(Refused::StillFaulty)
        );
        assert_eq!(operator.acknowledge(after(400), true), Ok(()));
        assert!(!operator.is_awaited());
    }
}
