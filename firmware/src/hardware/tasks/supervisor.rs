//! The supervisor: button, LED, watchdog, and the log.

use core::sync::atomic::{AtomicU32, Ordering};

use rtic::Mutex;
use shared::{
    control::{Command, Unfit},
    link::store,
};

use super::{blocks, control, drive, forecasts, link, log, report};
use crate::{
    button::Button,
    hardware::{board, stack},
    led::{LedPattern, LedShown},
    liveness::{Liveness, TurnCounts},
    recorder::ControlRecorder,
};

/// Turns of the task (wraps).
static TURNS: AtomicU32 = AtomicU32::new(0);

/// Turns since the start (wraps).
pub fn turns() -> u32 {
    TURNS.load(Ordering::Relaxed)
}

/// What the task owns.
pub struct Supervisor {
    led: board::LedPin,
    pin: board::ButtonPin,
    button: Button,
    pattern: LedPattern,
    liveness: Liveness,
    bench: bool,
    steps: u32,
    /// What the board's registers were set to.
    registers: board::Registers,
}

impl Supervisor {
    /// With the button as it is now.
    pub(super) fn new(
        led: board::LedPin,
        pin: board::ButtonPin,
        bench: bool,
        registers: board::Registers,
    ) -> Self {
        Self {
            led,
            button: Button::new(pin.is_pressed()),
            pin,
            pattern: LedPattern::default(),
            liveness: Liveness::default(),
            bench,
            steps: 0,
            registers,
        }
    }

    /// To be called every 10 ms.
    #[inline]
    pub fn step(&mut self, shared: &mut impl Mutex<T = ControlRecorder>) {
        let (status, acknowledge) = shared.lock(|recorder| {
            let controller = recorder.controller();
            let opened = drive::chain_was_open();
            let awaited = controller.awaits_acknowledgement();
            let acknowledge = awaited.then_some(Command::Acknowledge { opened });
            (controller.status(), acknowledge)
        });
        let pressed = self.pin.is_pressed();
        if let Some(command) = self.button.step(pressed, status.state, acknowledge) {
            match shared.lock(|recorder| recorder.command(command)) {
                Ok(()) if Some(command) == acknowledge => drive::forget_chain(),
                Ok(()) => {}
                Err(why) => log::refused(why),
            }
        }
        let shown = LedShown {
            state: status.state,
            fault: status.fault.map_or(0, |record| record.fault.code()),
            bench: self.bench,
        };
        self.led.set(self.pattern.step(shown));
        let progress = TurnCounts {
            blocks: blocks::served(),
            links: link::turns(),
            looks: blocks::looks(),
            idles: forecasts::turns(),
        };
        if self.liveness.step(progress) {
            board::feed_watchdog();
        }
        while let Some(event) = shared.lock(|recorder| recorder.taking().take_event()) {
            log::event(&event.kind);
        }
        TURNS.fetch_add(1, Ordering::Relaxed);
        self.steps = self.steps.wrapping_add(1);
        if self.steps.is_multiple_of(100) {
            self.look_for_changes(shared);
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

    /// Once a second: whether registers and settings are still what they were set to. If not, nothing that the program
    /// decides can be relied on: the outputs are made safe, and the board starts anew.
    fn look_for_changes(&mut self, shared: &mut impl Mutex<T = ControlRecorder>) {
        let (settings, sum) = shared.lock(|recorder| {
            let settings = *recorder.controller().settings();
            (settings, recorder.settings_sum())
        });
        if self.registers != board::registers() || store::sum(&settings) != sum {
            report::unfit(Unfit::CHANGED);
        }
    }
}
