//! The emergency-stop chain, and the pin by which the board's processor sees it through a filter (docs/wiring.md).

use std::convert::Infallible;

use embedded_hal::digital::{ErrorType, InputPin};
use shared::io::NormallyClosed;

/// Time constants of the pin's filter, s: 100 nF are charged through 2 kΩ when the chain opens, and discharged through
/// 1 kΩ when it closes. So an open of less than 0.139 ms is not seen.
const OPENS_S: f64 = 2e-4;
const CLOSES_S: f64 = 1e-4;

/// Share of the supply above which the pin reads high.
const HIGH: f64 = 0.5;

/// Nearer to its end than this, the voltage has arrived.
const ARRIVED: f64 = 1e-9;

/// The pin: low while the chain is closed.
#[derive(Clone, Copy, Debug, Default)]
struct Pin {
    /// Voltage over the supply.
    level: f64,
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl InputPin for Pin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.level >= HIGH)
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(self.level < HIGH)
    }
}

/// The emergency-stop chain: whether it is open, and the filtered pin that follows it.
#[derive(Clone, Debug)]
pub struct EmergencyChain {
    open: bool,
    pin: NormallyClosed<Pin>,
    /// When it opens or closes next, s.
    flips: Vec<(f64, bool)>,
}

impl Default for EmergencyChain {
    /// A closed chain, its pin settled low.
    fn default() -> Self {
        Self {
            open: false,
            pin: NormallyClosed(Pin::default()),
            flips: Vec::new(),
        }
    }
}

impl EmergencyChain {
    /// It opens or closes at `at_s`, within the next tick.
    pub fn flip(&mut self, open: bool, at_s: f64) {
        self.flips.push((at_s, open));
    }

    /// Whether it is open, seen or not.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Goes on from `from_s` to `to_s`; whether the processor saw it open meanwhile, by its interrupt or now.
    #[inline]
    pub fn tick(&mut self, from_s: f64, to_s: f64) -> bool {
        if self.flips.is_empty() && self.pin.0.level == self.end() {
            return self.pin.is_open();
        }
        let (mut now_s, mut seen) = (from_s, false);
        for (at_s, open) in std::mem::take(&mut self.flips) {
            let at_s = at_s.clamp(now_s, to_s);
            self.charge(at_s - now_s);
            seen |= self.pin.is_open();
            self.open = open;
            now_s = at_s;
        }
        self.charge(to_s - now_s);
        seen || self.pin.is_open()
    }

    /// Where the voltage goes.
    fn end(&self) -> f64 {
        f64::from(u8::from(self.open))
    }

    fn charge(&mut self, for_s: f64) {
        let constant_s = if self.open { OPENS_S } else { CLOSES_S };
        let off = (self.pin.0.level - self.end()) * (-for_s / constant_s).exp();
        let off = if off.abs() < ARRIVED { 0.0 } else { off };
        self.pin.0.level = self.end() + off;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 5e-5;

    /// The ticks in which it is seen open, of an open of `for_s` that begins in a tick's share `at`.
    fn seen(at: f64, for_s: f64) -> Vec<usize> {
        let mut chain = EmergencyChain::default();
        let (opens_s, closes_s) = (at * TICK_S, at * TICK_S + for_s);
        let ticks = 0..60;
        let sees = |k: &usize| {
            let (from_s, to_s) = (*k as f64 * TICK_S, (*k + 1) as f64 * TICK_S);
            for (at_s, open) in [(opens_s, true), (closes_s, false)] {
                if (from_s..to_s).contains(&at_s) {
                    chain.flip(open, at_s);
                }
            }
            chain.tick(from_s, to_s)
        };
        ticks.filter(sees).collect()
    }

    #[test]
    fn it_is_seen_once_its_filter_has_charged_however_it_lies_to_the_samples() {
        let threshold_s = OPENS_S * 2_f64.ln();
        for at in [0.0, 0.2, 0.5, 0.99] {
            assert!(seen(at, 0.98 * threshold_s).is_empty(), "{at}");
            assert!(!seen(at, 1.02 * threshold_s).is_empty(), "{at}");
        }
        // Seen in the third tick, until 69 µs after it has closed.
        assert_eq!(seen(0.0, 20.0 * TICK_S), (2..21).collect::<Vec<_>>());
        // Between two samples alone.
        assert_eq!(seen(0.15, threshold_s + 1e-6), [2]);
    }
}
