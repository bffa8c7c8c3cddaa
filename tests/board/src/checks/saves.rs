//! Settings saved with the power cut at an operation of the flash.

use shared::link::{Act, Answer, ToBoard};

use super::session::Bench;
use super::{Found, Setup, must};
use crate::machine::Machine;
use crate::rig::wired;

/// The most operations that a save is expected to take.
const MOST: u32 = 4_000;

/// Saves once, then a second time with the power cut at operation after operation. After each cut the board starts, and has
/// the first settings, the second, or says that none are good; never others.
pub fn power_cuts(setup: &Setup) -> Found {
    let (mut bench, _) = Bench::idle(setup)?;
    let first = bench.scenario.settings;
    let mut second = first;
    second.rig.amplitude_m *= 1.01;
    let before = bench.rig.borrow().machine.flash.clone();
    bench.rig.borrow_mut().machine.watch_flash();
    bench.client.steer(Act::SetSettings(second))?;
    let saved = bench.rig.borrow().machine.flash.clone();
    let cuts = bench.rig.borrow_mut().machine.take_flash_cuts();
    must(!cuts.is_empty() && (cuts.len() as u32) < MOST, || {
        format!("{} operations in a save", cuts.len())
    })?;
    let mut counts = [0u32; 3];
    let mut units = bench.now();
    let mut tried = 0;
    for flash in cuts
        .iter()
        .step_by(setup.short.unwrap_or(1) as usize)
        .chain([&before, &saved])
    {
        let mut after = Bench::power_up(setup, wired())?;
        after.rig.borrow_mut().machine.set_flash(flash);
        after.advance_ms(100)?;
        after.client.hello()?;
        let Answer::Settings(found) = after.client.ask(ToBoard::GetSettings)? else {
            return Err("no settings in the answer".into());
        };
        let status = after.client.status()?;
        let which = if status.fault.is_some() {
            2
        } else if found == second {
            1
        } else {
            0
        };
        must(which == 2 || found == first || found == second, || {
            format!("after a cut at operation {tried}: settings that were never sent")
        })?;
        counts[which] += 1;
        tried += 1;
        units += after.now();
    }
    let [old, new, none] = counts;
    let text = format!(
        "{} operations, {tried} boots: {old} start with the settings before, {new} with the new ones, {none} in Fault until \
         they are sent or confirmed",
        cuts.len()
    );
    Ok((text, units))
}

/// An error of an earlier operation still stands in FLASH_SR: a save must not take it for its own.
pub fn old_error(setup: &Setup) -> Found {
    let (mut bench, _) = Bench::idle(setup)?;
    let mut settings = bench.scenario.settings;
    settings.rig.amplitude_m *= 1.01;
    bench.rig.borrow_mut().machine.parts.flash.leave_error();
    bench.client.steer(Act::SetSettings(settings))?;
    let flash = bench.rig.borrow().machine.flash.clone();
    let mut after = Bench::power_up(setup, wired())?;
    after.rig.borrow_mut().machine.set_flash(&flash);
    after.advance_ms(100)?;
    after.client.hello()?;
    let found = after.client.ask(ToBoard::GetSettings)?;
    must(
        matches!(found, Answer::Settings(s) if s == settings),
        || format!("the settings sent were not stored: {found:?}"),
    )?;
    Ok(("the settings sent are stored".into(), after.now()))
}

impl Machine {
    /// From now on the flash is copied at each operation, as a power cut in its middle leaves it.
    pub fn watch_flash(&mut self) {
        self.cuts = Some(Vec::new());
    }

    /// Those copies.
    pub fn take_flash_cuts(&mut self) -> Vec<Vec<u8>> {
        self.cuts.take().unwrap_or_default()
    }
}
