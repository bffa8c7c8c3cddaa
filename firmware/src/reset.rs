//! The cause of a reset.

use shared::control::ResetCause;

/// The flags of the reset controller, as they were found after the reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// A watchdog ran out.
    pub watchdog: bool,
    /// The program reset itself.
    pub software: bool,
    /// Power came on, also after a short drop of the supply.
    pub power_on: bool,
    /// The supply fell below the brown-out detector's level (set when power comes on, too).
    pub brown_out: bool,
    /// The reset pin was low (set by every other cause, too).
    pub pin: bool,
}

impl Flags {
    /// The cause. `driving`: memory that outlives a reset, and a short drop of the supply, shows that the drive was enabled;
    /// then a power-on flag means that the supply dropped while the drive ran.
    ///
    /// Several flags are set at once: the part sets the pin's with every cause, and the brown-out's with
    /// power coming on (RM0390, "RCC clock control and status register"). So the rarer flag is tested first.
    pub fn cause(self, driving: bool) -> ResetCause {
        match self {
            Self { watchdog: true, .. } => ResetCause::Watchdog,
            Self { software: true, .. } if !driving => ResetCause::Software,
            Self { power_on: true, .. } if driving => ResetCause::BrownOut,
            Self { power_on: true, .. } => ResetCause::PowerOn,
            Self {
                brown_out: true, ..
            } => ResetCause::BrownOut,
            _ if driving => ResetCause::WhileDriving,
            _ => ResetCause::Pin,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rarer_flag_decides() {
        let pin = Flags {
            pin: true,
            ..Flags::default()
        };
        let power_on = Flags {
            power_on: true,
            brown_out: true,
            ..pin
        };
        assert_eq!(pin.cause(false), ResetCause::Pin);
        assert_eq!(pin.cause(true), ResetCause::WhileDriving);
        assert_eq!(power_on.cause(false), ResetCause::PowerOn);
        assert_eq!(power_on.cause(true), ResetCause::BrownOut);
        let dropped = Flags {
            brown_out: true,
            ..pin
        };
        assert_eq!(dropped.cause(false), ResetCause::BrownOut);
        let watchdog = Flags {
            watchdog: true,
            ..pin
        };
        assert_eq!(watchdog.cause(true), ResetCause::Watchdog);
        let software = Flags {
            software: true,
            ..pin
        };
        assert_eq!(software.cause(false), ResetCause::Software);
        assert_eq!(software.cause(true), ResetCause::WhileDriving);
    }
}
