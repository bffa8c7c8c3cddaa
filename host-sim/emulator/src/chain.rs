//! The emergency-stop chain's input pin, as the board's processor reads it.

use std::convert::Infallible;

use embedded_hal::digital::{ErrorType, InputPin};

/// The emergency-stop chain's input: low while the chain is closed.
#[derive(Clone, Copy, Debug, Default)]
pub struct ChainPin {
    /// Whether the chain is open.
    pub open: bool,
}

impl ErrorType for ChainPin {
    type Error = Infallible;
}

impl InputPin for ChainPin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.open)
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.open)
    }
}
