//! Settings in flash that are missing or damaged.

use shared::control::SettingsState;
use shared::fault::Fault;
use shared::link::{LinkAct, LinkAnswer, ToBoard};
use shared::settings::OperatorSettings;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::rig::wired;

/// Where the two slots begin, and a byte of the settings in them.
const SLOTS: [usize; 2] = [0x4000, 0x8000];
const SLOT: usize = 0x4000;
const PAYLOAD: usize = 80;

/// What the board makes of a flash.
fn start(
    setup: &Setup,
    flash: &[u8],
) -> Result<(SettingsState, Option<Fault>), Box<dyn std::error::Error>> {
    let mut bench = Bench::power_up(setup, wired())?;
    bench.rig.borrow_mut().machine.set_flash(flash);
    bench.advance_ms(100)?;
    let status = bench.status()?;
    let rose = bench.rig.borrow_mut().is_driven();
    must(!rose, || "PA8 was high without a start".into())?;
    let fault = status.fault.map(|record| record.fault);
    let state = bench.client.board()?.settings;
    let LinkAnswer::Settings(settings) = bench.client.ask(ToBoard::GetSettings)? else {
        return Err("no settings".into());
    };
    let stored = matches!(state, SettingsState::Stored | SettingsState::OlderCopy);
    let own = OperatorSettings {
        heartbeat: true,
        acknowledge: true,
    };
    must(stored || settings.operator == own, || {
        format!("{state:?}, and {:?}", settings.operator)
    })?;
    Ok((state, fault))
}

/// Two saves, so that both slots are full; then each damaged, both, and both erased.
pub fn damaged(setup: &Setup) -> Found {
    let (mut bench, _) = Bench::idle(setup)?;
    let mut second = bench.scenario.settings;
    second.rig.amplitude_m *= 1.01;
    bench.client.steer(LinkAct::SetSettings(second))?;
    let whole = bench.rig.borrow().machine.flash.clone();
    let damage = |slots: &[usize]| {
        let mut flash = whole.clone();
        slots.iter().for_each(|at| flash[at + PAYLOAD] ^= 4);
        flash
    };
    let mut erased = whole.clone();
    SLOTS
        .iter()
        .for_each(|at| erased[*at..at + SLOT].fill(0xff));
    let corrupt = Some(Fault::CorruptSettings);
    let cases = [
        ("whole", whole.clone(), SettingsState::Stored, None),
        (
            "the first damaged",
            damage(&SLOTS[..1]),
            SettingsState::OlderCopy,
            corrupt,
        ),
        (
            "the second damaged",
            damage(&SLOTS[1..]),
            SettingsState::OlderCopy,
            corrupt,
        ),
        (
            "both damaged",
            damage(&SLOTS),
            SettingsState::Damaged,
            corrupt,
        ),
        ("both blank", erased, SettingsState::Missing, corrupt),
    ];
    let mut text = Vec::new();
    for (name, flash, state, fault) in &cases {
        let found = start(setup, flash).map_err(|e| format!("{name}: {e}"))?;
        must(found == (*state, *fault), || {
            format!("{name}: {found:?}, not {:?}", (state, fault))
        })?;
        text.push(format!("{name}: {state:?}"));
    }
    let text =
        text.join(", ") + "; without its own, the board asks for the heartbeat and a tried chain";
    Ok((text, bench.now()))
}
