//! `pick --beside`: the answers as columns, quantity by quantity.

use super::text::chart_of;
use files::rigfile;
use files::words::digits::Digits;
use numerics::NamedRig;
use numerics::pick::{Pick, PickAnswer};

/// Width of the names of the quantities.
const NAMES: usize = 26;

/// The answers side by side, what differs between the rigs, and both curves.
pub fn text(rigs: &[NamedRig], picks: &[Pick]) -> String {
    let answers: Vec<&PickAnswer> = picks.iter().map(|pick| &pick.answer).collect();
    let mut table = Table::new(&answers);
    table.change(
        "run at, Hz",
        |a, d| d.run_at(a),
        |a| a.operating_frequency_hz,
    );
    table.line("times natural frequency", |a, d| {
        format!("{:.*}", d.ratio, a.frequency_ratio)
    });
    table.change(
        "force, N",
        |a, d| format!("{:.*}", d.force_n, a.force_n),
        |a| a.force_n,
    );
    table.change(
        "force over weight",
        |a, d| format!("{:.*}", d.force_ratio, a.force_ratio),
        |a| a.force_ratio,
    );
    if answers.iter().any(|a| a.uncertainty.is_some()) {
        table.line("  over the uncertainty", |a, d| {
            let digits = d.force_ratio;
            format!(
                "{:.digits$} to {:.digits$}",
                a.force_ratio_worst, a.force_ratio_largest
            )
        });
    }
    table.line("cart", |a, _| {
        a.cart.words().trim_start_matches("cart ").to_owned()
    });
    table.line("safe band, Hz", |a, d| d.safe_band(a));
    table.line("period doubling, Hz", |a, d| {
        a.period_doubling_hz.map_or("-".to_owned(), |hz| d.hz(hz))
    });
    table.line("multipliers", |a, d| {
        format!("{:.*}", d.others, a.multipliers)
    });
    table.line("jumps", |a, _| {
        if a.jump_free { "no" } else { "yes" }.to_owned()
    });
    table.change(
        "impact power, W",
        |a, d| d.other(a.impact_power_w),
        |a| a.impact_power_w,
    );
    table.change(
        "shaker must give, N",
        |a, d| d.other(a.shaker.force_n),
        |a| a.shaker.force_n,
    );
    let mut text = table.text;
    text += "\nWhat differs between the rigs\n";
    text += &differing(rigs);
    text.push('\n');
    text + &chart_of(picks)
}

struct Table<'a> {
    answers: &'a [&'a PickAnswer],
    digits: Vec<Digits>,
    widths: Vec<usize>,
    text: String,
}

impl<'a> Table<'a> {
    fn new(answers: &'a [&'a PickAnswer]) -> Self {
        let head = |a: &&PickAnswer| format!("{}, gap {:?} mm", a.rig, a.gap_mm);
        let heads: Vec<String> = answers.iter().map(head).collect();
        let widths: Vec<usize> = heads
            .iter()
            .map(|head| head.chars().count().max(22))
            .collect();
        let cells = heads.iter().zip(&widths);
        let cells: String = cells
            .map(|(head, width)| format!("  {head:<width$}"))
            .collect();
        Self {
            answers,
            digits: answers.iter().map(|a| Digits::of(a)).collect(),
            widths,
            text: format!("{:<NAMES$}{}\n", "", cells.trim_end()),
        }
    }

    fn line(&mut self, name: &str, value: impl Fn(&PickAnswer, Digits) -> String) {
        let cells = self
            .answers
            .iter()
            .zip(&self.digits)
            .map(|(a, digits)| value(a, *digits));
        self.cells(name, &cells.collect::<Vec<_>>());
    }

    /// A line whose later columns say by how much they differ from the first.
    fn change(
        &mut self,
        name: &str,
        value: impl Fn(&PickAnswer, Digits) -> String,
        number: impl Fn(&PickAnswer) -> f64,
    ) {
        let first = self.answers.first().map_or(f64::NAN, |a| number(a));
        let cells = self.answers.iter().zip(&self.digits).enumerate();
        let cells = cells.map(|(i, (a, digits))| match i {
            0 => value(a, *digits),
            _ => format!(
                "{} ({:+.1} %)",
                value(a, *digits),
                100.0 * (number(a) / first - 1.0)
            ),
        });
        let cells: Vec<String> = cells.collect();
        self.cells(name, &cells);
    }

    fn cells(&mut self, name: &str, cells: &[String]) {
        let cells = cells.iter().zip(&self.widths);
        let line: String = cells
            .map(|(cell, width)| format!("  {cell:<width$}"))
            .collect();
        self.text += &format!("{name:<NAMES$}{}\n", line.trim_end());
    }
}

/// The parameters that are not the same in all rigs.
fn differing(rigs: &[NamedRig]) -> String {
    let mut text = String::new();
    for (key, _) in rigfile::KEYS.iter() {
        let values = rigs.iter().map(|rig| rigfile::shown(&rig.params, key));
        let values: Vec<String> = values
            .map(|v| v.unwrap_or_else(|| "-".to_owned()))
            .collect();
        if values.iter().any(|value| *value != values[0]) {
            text += &format!("  {key:<28} {}\n", values.join("  |  "));
        }
    }
    if text.is_empty() {
        return "  nothing\n".to_owned();
    }
    text
}
