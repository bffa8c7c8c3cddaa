//! `host-sim drop`.

use super::arguments::choice::{Choice, choice};
use super::arguments::output::OutputArgs;
use super::arguments::rig::RigArgs;
use files::UserError;
use numerics::drop_test::{Converter, DropSample, DropTest, record};
use plot::chart::Chart;
use plot::{Axis, Color, Figure, Item, Panel};

/// Make a synthetic drop test of the released hammer, with noise, ringing and quantisation
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim drop --noise-n 0.2 --format csv > drop.csv")]
pub struct Args {
    /// Displacement at the release, mm from the hammer's rest position; negative: away from the surface
    #[arg(long, value_name = "MM", default_value_t = -3.0)]
    release_mm: f64,

    /// Impacts in the record
    #[arg(long, value_name = "N", default_value_t = 4)]
    impacts: usize,

    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 50e3)]
    sampling_hz: f64,

    /// Standard deviation of a force sample, N
    #[arg(long, value_name = "N", default_value_t = 0.0)]
    noise_n: f64,

    /// The surface's ringing: its first amplitude over the impact's peak (the emulator's surface: 0.5)
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    ringing: f64,

    /// Frequency of the ringing, Hz
    #[arg(long, value_name = "HZ", default_value_t = DropTest::default().ringing_hz)]
    ringing_hz: f64,

    /// Time constant of the ringing, ms
    #[arg(long, value_name = "MS", default_value_t = DropTest::default().ringing_decay_s * 1e3)]
    ringing_decay_ms: f64,

    /// Bits of the force channel; 0: not quantised
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=24))]
    bits: u32,

    /// Range of the force channel, from minus to plus this many N
    #[arg(long, value_name = "N", default_value_t = 100.0)]
    full_scale_n: f64,

    /// The force channel reads this many percent too much
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    force_gain_percent: f64,

    /// Reading of the force channel at the release without force, N
    #[arg(long, value_name = "N", default_value_t = 0.0)]
    offset_n: f64,

    /// Rise of that reading, N/s
    #[arg(long, value_name = "N_PER_S", default_value_t = 0.0)]
    drift_n_per_s: f64,

    /// Corner of the force channel's second-order Butterworth filter, Hz; 0: no filter (the emulator's: 6000)
    #[arg(long, value_name = "HZ", default_value_t = 0.0)]
    filter_hz: f64,

    /// Effect of the force channel's converter on the samples
    #[arg(long, value_parser = choice::<Converter>(), default_value = "plain")]
    converter: Converter,

    /// Step of the reading without force, up or down, in each 0.1 s, N
    #[arg(long, value_name = "N", default_value_t = 0.0)]
    step_n: f64,

    /// The record's clock is this many percent fast
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    clock_fast_percent: f64,

    /// The displacement channel reads this many percent too much, so the record has a wrong point of release
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    displacement_gain_percent: f64,

    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let rig = args.rig.load()?;
    args.output.doubt(&rig);
    let output = &args.output.about([&rig])?;
    let test = test(args);
    let rows = record(&rig.params, &test)?;
    let picture = || output.picture(&figure(&rig.name, &test, &rows));
    output.answer(&rows, &rows, picture, || text(&rig.name, &test, &rows))
}

fn test(args: &Args) -> DropTest {
    DropTest {
        release_m: args.release_mm * 1e-3,
        impacts: args.impacts,
        sampling_hz: args.sampling_hz,
        noise_n: args.noise_n,
        ringing_share: args.ringing,
        ringing_hz: args.ringing_hz,
        ringing_decay_s: args.ringing_decay_ms * 1e-3,
        bits: args.bits,
        full_scale_n: args.full_scale_n,
        force_gain_percent: args.force_gain_percent,
        offset_n: args.offset_n,
        drift_n_per_s: args.drift_n_per_s,
        filter_hz: args.filter_hz,
        converter: args.converter,
        step_n: args.step_n,
        clock_fast_percent: args.clock_fast_percent,
        displacement_gain_percent: args.displacement_gain_percent,
        seed: args.seed,
    }
}

/// Time shown after the first impact, s; a fifth of it is shown before.
const AROUND_S: f64 = 5e-3;

/// The samples about the first impact: its largest force and what is within [`AROUND_S`] of it.
fn first_impact(rows: &[DropSample]) -> impl Iterator<Item = &DropSample> {
    let hardest = rows.iter().max_by(|a, b| a.force_n.total_cmp(&b.force_n));
    let middle = hardest.map_or(0.0, |r| r.time_s);
    rows.iter()
        .filter(move |r| r.time_s > middle - 0.2 * AROUND_S && r.time_s < middle + AROUND_S)
}

/// What is wrong with the sensors beside noise, ringing and bits.
fn faults(test: &DropTest) -> String {
    let listed = [
        (test.force_gain_percent, "force gain", "% off"),
        (test.offset_n, "offset", "N"),
        (test.drift_n_per_s, "drift", "N/s"),
        (test.filter_hz, "filter", "Hz"),
        (test.step_n, "steps of the zero", "N"),
        (test.clock_fast_percent, "clock", "% fast"),
        (test.displacement_gain_percent, "displacement gain", "% off"),
    ];
    let there = listed.iter().filter(|(value, ..)| *value != 0.0);
    let there = there.map(|(value, name, unit)| format!(", {name} {value} {unit}"));
    let converter = Converter::CHOICES
        .iter()
        .find(|(.., c)| *c == test.converter);
    let named = converter.filter(|(.., c)| *c != Converter::Plain);
    there
        .chain(named.map(|(name, ..)| format!(", converter {name}")))
        .collect()
}

fn figure(rig: &str, test: &DropTest, rows: &[DropSample]) -> Figure {
    let force = || Axis::new("force, N").with_zero();
    let first: Vec<_> = first_impact(rows).collect();
    let began = first.first().map_or(0.0, |r| r.time_s);
    let near = |f: fn(&DropSample) -> f64| {
        first
            .iter()
            .map(|r| ((r.time_s - began) * 1e3, f(r)))
            .collect::<Vec<_>>()
    };
    let all = |f: fn(&DropSample) -> f64| rows.iter().map(|r| (r.time_s, f(r))).collect::<Vec<_>>();
    let release = format!("{:.2}", test.release_m * 1e3).replace('-', "−");
    Figure::new(format!("Synthetic drop test: {rig}, released at {release} mm"))
        .subtitle(format!(
            "{:.0} samples a second, noise {} N, ringing {:.2} of the peak at {:.0} Hz, {} bits, seed {}{}. Made from the model, not measured.",
            test.sampling_hz, test.noise_n, test.ringing_share, test.ringing_hz, test.bits, test.seed, faults(test)
        ))
        .columns(2)
        .size(1200, 860)
        .panel(
            Panel::new("time since release, s", "displacement, mm")
                .titled("Displacement from rest")
                .without_legend()
                .item(Item::line("displacement", Color::BLUE, all(|r| r.displacement_mm))),
        )
        .panel(
            Panel::new("time since release, s", force())
                .titled("Force as the sensor has it")
                .without_legend()
                .item(Item::line("force", Color::RED, all(|r| r.force_n))),
        )
        .panel(
            Panel::new("time, ms", force())
                .titled("First impact: force")
                .without_legend()
                .item(Item::line("force", Color::RED, near(|r| r.force_n))),
        )
        .panel(
            Panel::new("time, ms", Axis::new("deceleration, m/s²").with_zero())
                .titled("First impact: the hammer's deceleration")
                .without_legend()
                .item(Item::line("deceleration", Color::BLUE, near(|r| -r.acceleration_m_per_s2))),
        )
}

fn text(rig: &str, test: &DropTest, rows: &[DropSample]) -> String {
    let peak = rows.iter().fold(0.0_f64, |m, r| m.max(r.force_n));
    let mut text = format!(
        "{rig}, released at {:.3} mm: {} samples over {:.3} s, largest force {peak:.2} N\n\n",
        test.release_m * 1e3,
        rows.len(),
        rows.last().map_or(0.0, |r| r.time_s)
    );
    let points = rows.iter().map(|r| (r.time_s, r.displacement_mm));
    text += &Chart::new("time since release, s", "displacement, mm")
        .series("displacement", points.collect())
        .render();
    text += "\n--format csv writes the samples: host-sim drop --format csv > drop.csv\n";
    text
}
