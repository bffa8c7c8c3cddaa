//! `host-sim modes`.

use std::f64::consts::TAU;

use serde_json::json;

use super::arguments::choice::choice;
use super::arguments::cycles::CycleArgs;
use super::arguments::drive::Drives;
use super::arguments::output::OutputArgs;
use super::arguments::rig::{CartArg, RigArgs};
use crate::figures::modes::in_words;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::modes::{Beam, BendingMode, ModalRig, ModesRequest, ModesRow, TipJoint};
use plot::chart::Chart;
use plot::{Axis, Color, Figure, Item, Panel};

/// Compute beam springs with more than one bending mode: force, displacement, and the energy of the modes
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On two cores a hundred runs (a number of modes at a frequency each) take some two seconds.\n\nExamples:\n  host-sim modes --rig beam-170 --ratio 1.6:2.4:0.05 --modes 1,3"
)]
#[command(group(clap::ArgGroup::new("drive").required(true).args(["ratio", "frequency"])))]
pub struct Args {
    #[command(flatten)]
    drive: Drives,

    /// Numbers of bending modes to compare
    #[arg(long, value_name = "N,N...", value_delimiter = ',', default_values_t = [1, 2, 3, 5])]
    modes: Vec<usize>,

    /// Mass of the beam springs over the hammer's (assumed: the chapter gives none)
    #[arg(long, value_name = "RATIO", default_value_t = 0.1)]
    springs_mass: f64,

    /// Motion of the springs' end
    #[arg(long, value_parser = choice::<TipJoint>(), default_value = "guided")]
    tip: TipJoint,

    #[command(flatten)]
    cycles: CycleArgs,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let rig = args.cart.apply(args.rig.load()?)?;
    let output = &args.output.about([&rig])?;
    output.doubt_without_uncertainty(&rig);
    let beam = Beam {
        tip: args.tip,
        mass_ratio: args.springs_mass,
    };
    let natural_hz = rig.params.natural_frequency_hz();
    let frequencies_hz = args.drive.needed_hz(natural_hz)?;
    if let Some(twice) = (1..args.modes.len()).find(|i| args.modes[..*i].contains(&args.modes[*i]))
    {
        return Err(UserError::new(format!(
            "--modes names {} twice; name each number of modes once",
            args.modes[twice]
        )));
    }
    let most = args.modes.iter().copied().max().unwrap_or(0);
    let modes = ModalRig::new(&rig.params, beam, most)?.modes;
    let plan = ModesRequest {
        rig: &rig,
        beam,
        counts: &args.modes,
        frequencies_hz: &frequencies_hz,
        cycles: args.cycles.plan()?,
    };
    let runs = (args.modes.len() * frequencies_hz.len()) as u64;
    let progress = ProgressLine::new("runs", runs, output.quiet);
    let rows = plan.run(&progress)?;
    progress.finish();
    let mode = |mode: &BendingMode| {
        json!({
            "frequency_hz": mode.omega / TAU,
            "mass_kg": mode.mass_kg,
            "participation_kg": mode.participation_kg,
        })
    };
    let answer = json!({ "modes": modes.iter().map(mode).collect::<Vec<_>>(), "rows": rows });
    let picture = || output.picture(&figure(&rows, &args.modes));
    output.answer(&answer, &rows, picture, || text(&modes, &rows, &args.modes))
}

/// What is computed, for text and picture.
fn one_frequency(rows: &[ModesRow]) -> bool {
    rows.iter()
        .all(|row| row.frequency_hz == rows[0].frequency_hz)
}

fn heading(rows: &[ModesRow]) -> String {
    rows.first().map_or(String::new(), |row| {
        let cart = row.cart.words();
        let hz = match one_frequency(rows) {
            true => format!(", {:.4} Hz", row.frequency_hz),
            false => String::new(),
        };
        format!(
            "{}, gap {:?} mm, {cart}{hz}: bending modes",
            row.rig, row.gap_mm
        )
    })
}

fn text(modes: &[BendingMode], rows: &[ModesRow], counts: &[usize]) -> String {
    let mut text = heading(rows);
    text += "\n\nmode   frequency, Hz   modal mass, kg   participation, kg\n";
    for (i, mode) in modes.iter().enumerate() {
        text += &format!(
            "{:>4} {:>15.3} {:>16.4} {:>19.5}\n",
            i + 1,
            mode.omega / TAU,
            mode.mass_kg,
            mode.participation_kg
        );
    }
    text += "\n     Hz     Ω/ω  modes  regime     force, N  force/weight  swing, mm  energy not in mode 1  lost by it\n";
    let every = rows
        .len()
        .div_ceil(40)
        .max(1)
        .next_multiple_of(counts.len());
    let shown =
        |i: usize| rows.len() <= 40 || (i / counts.len()).is_multiple_of(every / counts.len());
    for (_, row) in rows.iter().enumerate().filter(|(i, _)| shown(*i)) {
        text += &format!(
            "{:>7.4} {:>7.4}  {:>5}  {:<9} {:>9.2} {:>13.3} {:>10.4} {:>20.3} % {:>8.2} %\n",
            row.frequency_hz,
            row.frequency_ratio,
            row.modes,
            // A regime ignores the width of its column; a string does not.
            row.regime.to_string(),
            row.force_n,
            row.force_ratio,
            row.swing_mm,
            100.0 * row.higher_energy_share,
            100.0 * row.higher_loss_share
        );
    }
    if rows.len() > counts.len() {
        let mut chart = Chart::new("drive frequency, Hz", "swing, mm");
        for count in counts {
            let points = of(rows, *count, |row| row.swing_mm);
            chart = chart.series(in_words(*count), points);
        }
        text.push('\n');
        text += &chart.render();
    }
    text
}

/// A column over frequency, for one number of modes.
fn of(rows: &[ModesRow], count: usize, column: impl Fn(&ModesRow) -> f64) -> Vec<(f64, f64)> {
    let rows = rows.iter().filter(|row| row.modes == count);
    rows.map(|row| (row.frequency_hz, column(row))).collect()
}

/// Force, swing and energy in the higher modes over frequency; over the number of modes where there is one frequency.
fn figure(rows: &[ModesRow], counts: &[usize]) -> Figure {
    let one = one_frequency(rows);
    let subtitle = rows.first().map_or(String::new(), |row| {
        format!(
            "From rest. Springs of {} times the hammer's mass, tip {}. Swing: largest less least displacement in the fixed frame.",
            row.springs_mass_ratio,
            if row.tip == TipJoint::Guided { "guided" } else { "free to turn" }
        )
    });
    let panel = |label: &str, column: fn(&ModesRow) -> f64| {
        if one {
            let points = rows.iter().map(|row| (row.modes as f64, column(row)));
            return Panel::new(
                Axis::new("bending modes").whole(),
                Axis::new(label).with_zero(),
            )
            .without_legend()
            .dotted("", Color::series(0), points.collect());
        }
        let mut panel = Panel::new("drive frequency, Hz", Axis::new(label).with_zero());
        for (i, count) in counts.iter().enumerate() {
            let points = of(rows, *count, column);
            panel = panel.item(Item::line(in_words(*count), Color::series(i), points));
        }
        panel
    };
    Figure::new(heading(rows))
        .subtitle(subtitle)
        .size(1000, 1150)
        .panel(panel("largest force, N", |row| row.force_n))
        .panel(panel("swing, mm", |row| row.swing_mm).without_legend())
        .panel(
            panel("energy not in mode 1, %", |row| {
                100.0 * row.higher_energy_share
            })
            .without_legend(),
        )
}
