//! `host-sim simulate`.

use super::arguments::cycles::{CycleArgs, parse_start};
use super::arguments::drive::OneFrequency;
use super::arguments::engine::EngineArgs;
use super::arguments::output::{Contents, Format, OutputArgs, to_json};
use super::arguments::rig::{CartArg, RigArgs};
use crate::pictures::drawn;
use crate::pictures::poincare::history;
use crate::pictures::regimes::regime_color;
use files::UserError;
use files::table::{to_csv, to_csv_or_header};
use files::words::count;
use numerics::NamedRig;
use numerics::engine::answer::{ContactRow, RunAnswer, SectionRow, contact_rows, section_rows};
use numerics::engine::{CycleRecorder, RecordedSample, Start, machine, observe};
use numerics::row::RunRow;
use plot::chart::Chart;
use plot::{Axis, Color, Figure, Item, Panel};
use shared::model::regime::Regime;

/// Run at one frequency: time history, phase plane, section, regime and force
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim simulate --ratio 2 --out out\n  host-sim simulate --gap 2.4 --frequency 4.9 --initial -2,0"
)]
#[command(group(clap::ArgGroup::new("drive").required(true).args(["ratio", "frequency"])))]
pub struct Args {
    #[command(flatten)]
    drive: OneFrequency,

    #[command(flatten)]
    cycles: CycleArgs,

    /// Initial condition: rest (relative to the cart), fixed (at rest in the laboratory), or
    /// DISPLACEMENT_MM,VELOCITY_M_PER_S relative to the cart
    #[arg(long, value_parser = parse_start, default_value = "rest", allow_hyphen_values = true)]
    initial: Start,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    engine: EngineArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// Drive periods shown in the time history.
const SHOWN_PERIODS: f64 = 6.0;
const SAMPLES_PER_PERIOD: usize = 400;

pub fn run(args: &Args) -> Result<(), UserError> {
    let rig = args.cart.apply(args.rig.load()?)?;
    let output = &args.output.about([&rig])?;
    output.doubt_without_uncertainty(&rig);
    let engine = args.engine.engine(output)?;
    let plan = args.cycles.plan()?;
    let natural = rig.params.natural_frequency_hz();
    let frequency_hz = args.drive.needed_hz(natural)?;
    let mut hammer = machine(engine, &rig.params, frequency_hz, args.initial)?;
    let mut recorder = CycleRecorder::default();
    // Only the last recorded periods are drawn, but a table that is asked for has them all.
    if output.out.is_some() || output.format == Format::Text {
        recorder.samples_per_period = SAMPLES_PER_PERIOD;
    }
    let seen = observe(hammer.as_mut(), plan, &mut recorder)?;
    if (seen.frequency_hz / frequency_hz - 1.0).abs() > 1e-5 {
        output.note(&format!(
            "note: at this tick the drive's phase accumulator runs at {:.6} Hz",
            seen.frequency_hz
        ));
    }
    let section = section_rows(&seen, hammer.rig());
    let answer = RunAnswer::new(&rig, engine, plan, &seen, &recorder);
    if let Some(dir) = &output.out {
        let figure = figure(&rig, &answer.row, &recorder, &section);
        let mut contents = drawn(&output.name(""), &figure)?;
        contents.extend(tables(output, &answer, &recorder, &section)?);
        output.write(dir, contents)?;
    }
    let row = std::slice::from_ref(&answer.row);
    output.emit(&answer, row, || text(&answer, &recorder))
}

/// JSON, and tables of the history, the section and the contacts.
fn tables(
    output: &OutputArgs,
    answer: &RunAnswer,
    recorder: &CycleRecorder,
    section: &[SectionRow],
) -> Result<Contents, UserError> {
    Ok(vec![
        (output.name(".json"), to_json(answer)?.into_bytes()),
        (output.name("-history.csv"), to_csv(&recorder.samples)),
        (output.name("-section.csv"), to_csv(section)),
        (
            output.name("-contacts.csv"),
            to_csv_or_header(&contact_rows(recorder), ContactRow::default()),
        ),
    ])
}

/// The samples of the last few periods, with time from their start.
fn tail(
    recorder: &CycleRecorder,
    frequency_hz: f64,
) -> impl Iterator<Item = (f64, &RecordedSample)> {
    let end = recorder.samples.last().map_or(0.0, |s| s.time_s);
    let from = end - SHOWN_PERIODS / frequency_hz;
    recorder
        .samples
        .iter()
        .filter(move |s| s.time_s >= from)
        .map(move |s| (s.time_s - from, s))
}

/// Force over time of the last contact, from its onset; nothing if there was none.
fn last_contact(recorder: &CycleRecorder) -> Option<Vec<(f64, f64)>> {
    let contact = contact_rows(recorder).pop()?;
    let since_ms = |s: &RecordedSample| 1e3 * (s.time_s - contact.onset_s);
    let inside = recorder.samples.iter().map(|s| (since_ms(s), s.force_n));
    let inside = inside.filter(|(ms, _)| (0.0..=contact.duration_ms).contains(ms));
    // A little before and after, so that onset and release can be seen. The force may jump at the onset.
    let margin_ms = 0.1 * contact.duration_ms;
    let mut points = vec![(-margin_ms, 0.0), (0.0, 0.0)];
    points.extend(inside);
    points.push((contact.duration_ms, 0.0));
    points.push((contact.duration_ms + margin_ms, 0.0));
    Some(points)
}

/// Why nothing is known of a motion that does not repeat.
fn unsettled(answer: &RunAnswer) -> String {
    let recorded = answer.cycles - answer.transient;
    match answer.settling_cycles {
        Some(cycles) => format!(
            "it repeats only from drive period {cycles} on, and the record begins earlier; give --transient {cycles}"
        ),
        None => match answer.row.periods {
            Some(n) => format!(
                "it nearly repeats after {n} drive periods, but its difference from {n}/2 periods still changes; give more --cycles"
            ),
            None => format!(
                "it has not repeated in the {recorded} recorded drive periods, too few to call it aperiodic; give more --cycles"
            ),
        },
    }
}

fn text(answer: &RunAnswer, recorder: &CycleRecorder) -> String {
    let row = &answer.row;
    let mut text = format!(
        "{}, gap {:?} mm, {}, {:.4} Hz ({:.4} times the natural frequency), {} engine\n",
        row.rig,
        row.gap_mm,
        row.cart.words(),
        row.frequency_hz,
        row.frequency_ratio,
        answer.engine
    );
    let meaning = match row.regime {
        Regime::None => "no contact in the recorded cycles".to_owned(),
        _ if row.unsettled() => unsettled(answer),
        Regime::Aperiodic { .. } => format!(
            "no repetition within 16 drive periods ({} contacts in the last 16)",
            row.regime.impacts()
        ),
        Regime::Chatter { .. } => {
            format!("{} contacts that die out into a stay", row.regime.impacts())
        }
        Regime::Periodic { .. } => format!(
            "{} in {}",
            count(usize::from(row.regime.impacts()), "contact"),
            count(usize::from(row.periods.unwrap_or(0)), "drive period")
        ),
    };
    text += &format!("  regime         {}: {meaning}\n", row.outcome);
    if let (Some(cycles), Some(seconds), false) =
        (answer.settling_cycles, answer.settling_s, row.unsettled())
    {
        text += &format!(
            "  settles        the motion repeats from drive period {cycles} on, {seconds:.1} s after the start\n"
        );
    }
    text += &format!(
        "  force          {:.2} N, {:.3} times the hammer's weight\n",
        row.force_n, row.force_ratio
    );
    if let (Some(speed), Some(time)) = (row.approach_speed_m_per_s, row.contact_time_ms) {
        text += &format!("  approach speed {speed:.5} m/s\n  contact time   {time:.4} ms\n");
    }
    let points = tail(recorder, row.frequency_hz).map(|(t, s)| (t, s.relative_displacement_mm));
    text.push('\n');
    text += &Chart::new("time, s", "hammer relative to the cart, mm")
        .series("displacement", points.collect())
        .render();
    text
}

const BLUE: Color = Color(0x1f, 0x4e, 0x79);
const RED: Color = Color(0xb0, 0x3a, 0x2e);

fn figure(
    rig: &NamedRig,
    row: &RunRow,
    recorder: &CycleRecorder,
    section: &[SectionRow],
) -> Figure {
    let shown: Vec<_> = tail(recorder, row.frequency_hz).collect();
    let force = shown.iter().map(|(t, s)| (*t, s.force_n)).collect();
    let plane = shown
        .iter()
        .map(|(_, s)| (s.relative_displacement_mm, s.relative_velocity_m_per_s));
    let strobes: Vec<_> = section
        .iter()
        .map(|s| (s.relative_displacement_mm, s.relative_velocity_m_per_s))
        .collect();
    let gap = rig.params.gap_m * 1e3;
    let displacement = "displacement relative to the cart, mm";
    let velocity = "velocity relative to the cart, m/s";
    // A periodic motion has few points in the section, and the phase plane shows them.
    let contact = match row.regime {
        Regime::Periodic { .. } => last_contact(recorder),
        _ => None,
    };
    let last = match contact {
        Some(force) => Panel::new(
            "time since onset, ms",
            Axis::new("contact force, N").with_zero(),
        )
        .titled("The last contact")
        .without_legend()
        .item(Item::line("contact force", RED, force)),
        None => Panel::new(displacement, velocity)
            .titled("Poincaré section at drive phase 0")
            .without_legend()
            .item(Item::points(
                "section",
                regime_color(&row.regime.to_string()),
                strobes.clone(),
            )),
    };
    Figure::new(format!("{}, gap {:?} mm, {}, {:.3} Hz: regime {}", row.rig, row.gap_mm, row.cart.words(), row.frequency_hz, row.outcome))
        .subtitle(format!(
            "Drive at {:.4} times the natural frequency; strongest contact {:.2} N ({:.2} times the hammer's weight). The last {SHOWN_PERIODS} recorded drive periods; drive phase 0 of all {} recorded.",
            row.frequency_ratio, row.force_n, row.force_ratio, section.len()
        ))
        .columns(2)
        .size(1200, 860)
        .panel(history(&shown, gap, [BLUE, RED]).titled("Time history"))
        .panel(
            Panel::new("time, s", Axis::new("contact force, N").with_zero())
                .titled("Contact force")
                .without_legend()
                .item(Item::line("contact force", RED, force)),
        )
        .panel(
            Panel::new(displacement, velocity)
                .titled("Phase plane")
                .item(Item::line("trajectory", BLUE, plane.collect()))
                .item(Item::points("drive phase 0", RED, strobes))
                .item(Item::mark_x("surface", gap)),
        )
        .panel(last)
}
