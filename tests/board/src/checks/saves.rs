//! Settings saved with the power cut at an operation of the flash.

use shared::link::{LinkAct, LinkAnswer, ToBoard};

use super::session::Bench;
use super::{Found, Setup, must};
use crate::machine::{Change, Machine};
use crate::parts::UNITS_PER_S;
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
    bench.client.steer(LinkAct::SetSettings(second))?;
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
        let LinkAnswer::Settings(found) = after.client.ask(ToBoard::GetSettings)? else {
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
    bench.rig.borrow_mut().machine.parts.flash.leave_error();
    let units = stored(setup, &mut bench)?;
    Ok(("the settings sent are stored".into(), units))
}

/// The flash takes the longest times of the data sheet, and the watchdog's clock is at its fastest.
pub fn slowest(setup: &Setup) -> Found {
    let mut around = wired();
    around.slow_flash = true;
    around.lsi_hz = 47_000;
    let (mut bench, _) = Bench::power_up(setup, around)?.prepared(None)?;
    // The second save, at once after the first.
    let from = bench.now();
    let mut units = stored(setup, &mut bench)?;
    let saved_s = (bench.now() - from) as f64 / UNITS_PER_S as f64;
    bench.advance_ms(100)?;
    units += bench.now();
    let reset = |(_, change): &(u64, Change)| matches!(change, Change::Reset(_));
    must(!bench.changes_since(1).iter().any(reset), || {
        "the watchdog resets the board in a save".into()
    })?;
    let text = format!(
        "0.8 s for a sector, 100 µs a byte, LSI of 47 kHz: stored after {saved_s:.2} s, and no reset"
    );
    Ok((text, units))
}

/// Sends settings, which must be there after the next power-up; the rig time of that.
fn stored(setup: &Setup, bench: &mut Bench) -> Result<u64, Box<dyn std::error::Error>> {
    let mut settings = bench.scenario.settings;
    settings.rig.amplitude_m *= 1.01;
    bench.client.steer(LinkAct::SetSettings(settings))?;
    let flash = bench.rig.borrow().machine.flash.clone();
    let mut after = Bench::power_up(setup, wired())?;
    after.rig.borrow_mut().machine.set_flash(&flash);
    after.advance_ms(100)?;
    after.client.hello()?;
    let found = after.client.ask(ToBoard::GetSettings)?;
    must(
        matches!(found, LinkAnswer::Settings(s) if s == settings),
        || format!("the settings sent were not stored: {found:?}"),
    )?;
    Ok(after.now())
}

impl Machine {
    /// From now on the flash is copied at each operation, as a power cut in its middle leaves it.
    pub fn watch_flash(&mut self) {
        self.cuts = Some(Vec::new());
    }

    /// The copies made since [`Self::watch_flash`], one per operation; no more are made.
    pub fn take_flash_cuts(&mut self) -> Vec<Vec<u8>> {
        self.cuts.take().unwrap_or_default()
    }
}
