//! The board's converters and pins, as the controller's side sees them: the traits of [`shared::io`] over the
//! plant's sensors and shaker.

use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use shared::io::{
    AdcCode, DacCode, DisplacementSensors, Drive, EmergencyStop, ForceSensor, NormallyClosed,
    Output, SetPoints,
};

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

/// The ADC: the codes that were converted last.
#[derive(Clone, Copy, Debug)]
pub struct MockAdc {
    /// Force, hammer, cart.
    pub codes: [AdcCode; 3],
    /// The emergency-stop chain.
    pub chain: NormallyClosed<ChainPin>,
}

impl Default for MockAdc {
    fn default() -> Self {
        Self {
            codes: [AdcCode::default(); 3],
            chain: NormallyClosed(ChainPin::default()),
        }
    }
}

impl ForceSensor for MockAdc {
    fn force(&mut self) -> AdcCode {
        self.codes[0]
    }
}

impl DisplacementSensors for MockAdc {
    fn hammer(&mut self) -> AdcCode {
        self.codes[1]
    }
    fn cart(&mut self) -> AdcCode {
        self.codes[2]
    }
}

impl EmergencyStop for MockAdc {
    fn is_open(&mut self) -> bool {
        self.chain.is_open()
    }
}

/// What the DAC and the motor's set-point were told last.
#[derive(Clone, Debug, Default)]
pub struct MockDac(Rc<Cell<(DacCode, f32)>>);

impl SetPoints for MockDac {
    fn set(&mut self, dac: DacCode, frequency_hz: f32) {
        self.0.set((dac, frequency_hz));
    }
}

/// The drive's enable line.
#[derive(Clone, Debug, Default)]
pub struct EnablePin(Rc<Cell<bool>>);

impl ErrorType for EnablePin {
    type Error = Infallible;
}

impl OutputPin for EnablePin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

/// DAC and enable line behind the controller's own [`Drive`].
#[derive(Debug)]
pub struct MockActuator {
    drive: Drive<MockDac, EnablePin>,
    dac: MockDac,
    enable: EnablePin,
}

impl Default for MockActuator {
    fn default() -> Self {
        let (dac, enable) = (MockDac::default(), EnablePin::default());
        Self {
            drive: Drive::new(dac.clone(), enable.clone()),
            dac,
            enable,
        }
    }
}

impl MockActuator {
    /// Applies one tick's output.
    #[inline]
    pub fn apply(&mut self, output: &Output) {
        self.drive.apply(output);
    }

    /// What the shaker gets: DAC code, the motor's frequency (Hz), enabled.
    #[inline]
    pub fn lines(&self) -> (DacCode, f32, bool) {
        let (dac, frequency_hz) = self.dac.0.get();
        (dac, frequency_hz, self.enable.0.get())
    }
}
