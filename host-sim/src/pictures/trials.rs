//! The picture of many trials: how soon they hold, and how hard they strike from then on.

use emulator::trials::TrialOutcome;
use files::words::count;
use plot::{Axis, Color, Figure, Item, Panel};

/// Share of the trials that hold by a time, and share of them that keep at least a share of the optimum's force.
pub fn figure(rigs: &[&str], outcomes: &[TrialOutcome], seconds: f64) -> Figure {
    let held = outcomes.iter().filter(|o| o.held).count();
    let mut time = Panel::new(
        Axis::new("Hold after the start, s").with_zero(),
        Axis::new("trials that hold by then, %").fixed(0.0, 100.0),
    )
    .titled("how soon it holds")
    .item(Item::mark_x("10 s", 10.0));
    let mut share = Panel::new(
        "force over the optimum's at the amplitude as read",
        Axis::new("trials with at most that, %").fixed(0.0, 100.0),
    )
    .titled("how hard it strikes from Hold on");
    for (k, rig) in rigs.iter().copied().enumerate() {
        let these: Vec<&TrialOutcome> = outcomes.iter().filter(|o| o.rig == rig).collect();
        if these.is_empty() {
            continue;
        }
        let color = Color::series(k);
        let times = these.iter().map(|o| o.hold_s.unwrap_or(f64::INFINITY));
        let shares = these
            .iter()
            .map(|o| o.force_share_at_amplitude.unwrap_or(0.0));
        time = time.item(Item::line(rig, color, stairs(times.collect())));
        share = share.item(Item::line(rig, color, stairs(shares.collect())));
    }
    Figure::new(format!("{held} of {} end in Hold", count(outcomes.len(), "trial")))
        .subtitle(format!(
            "Cold starts of {seconds} s on rigs that differ at random from what the controller believes, with 2 % noise"
        ))
        .columns(2)
        .size(1300, 560)
        .panel(time)
        .panel(share)
}

/// The share of the values up to each, in percent.
fn stairs(mut values: Vec<f64>) -> Vec<(f64, f64)> {
    values.sort_by(f64::total_cmp);
    let step = 100.0 / values.len() as f64;
    let mut points = Vec::with_capacity(2 * values.len());
    for (k, value) in values.into_iter().enumerate() {
        if value.is_finite() {
            points.push((value, k as f64 * step));
            points.push((value, (k + 1) as f64 * step));
        }
    }
    points
}
