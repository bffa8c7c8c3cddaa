//! The supervisor: button, LED, watchdog, and the log.

use rtic::Mutex;

use super::{blocks, control, forecasts, link, log};
use crate::{
    button::Button,
    hardware::{board, stack},
    led::{LedPattern, Shown},
    liveness::{Liveness, Progress},
    recorder::Recorder,
};

/// What the task owns.
pub struct Supervisor {
    led: board::LedPin,
    pin: board::ButtonPin,
    button: Button,
    pattern: LedPattern,
    watchdog: board::Watchdog,
    liveness: Liveness,
    bench: bool,
    steps: u32,
}

impl Supervisor {
    /// With the button as it is now.
    pub(super) fn new(
        led: board::LedPin,
        pin: board::ButtonPin,
        watchdog: board::Watchdog,
        bench: bool,
    ) -> Self {
        Self {
            led,
            button: Button::new(pin.is_pressed()),
            pin,
            pattern: LedPattern::default(),
            watchdog,
            liveness: Liveness::default(),
            bench,
            steps: 0,
        }
    }

    /// To be called every 10 ms.
    #[inline]
    pub fn step(&mut self, shared: &mut impl Mutex<T = Recorder>) {
        let (status, awaited) = shared.lock(|recorder| {
            let controller = recorder.controller();
            (controller.status(), controller.awaits_acknowledgement())
        });
        let pressed = self.pin.is_pressed();
        if let Some(command) = self.button.step(pressed, status.state, awaited)
            && let Err(why) = shared.lock(|recorder| recorder.command(command))
        {
            log::refused(why);
        }
        let shown = Shown {
            state: status.state,
            fault: status.fault.map_or(0, |record| record.fault.code()),
            bench: self.bench,
        };
        self.led.set(self.pattern.step(shown));
        let progress = Progress {
            blocks: blocks::served(),
            links: link::turns(),
            idles: forecasts::turns(),
        };
        if self.liveness.step(progress) {
            self.watchdog.feed();
        }
        while let Some(event) = shared.lock(|recorder| recorder.taking().take_event()) {
            log::event(&event.kind);
        }
        self.steps = self.steps.wrapping_add(1);
        if self.steps.is_multiple_of(100) {
            if status.events_dropped > 0 {
                defmt::warn!("{=u16} events were lost", status.events_dropped);
            }
            let [last, longest] = control::take_cycles();
            defmt::info!(
                "{=str} {=f32} Hz, peak {=f32} N, cycles per block: last {=u32}, longest {=u32}, stack {=usize} B",
                log::state_name(status.state),
                status.frequency_hz,
                status.peak_n,
                last,
                longest,
                stack::peak(),
            );
        }
    }
}
