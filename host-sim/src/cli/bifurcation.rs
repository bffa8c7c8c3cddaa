//! `host-sim bifurcation`.

use std::path::PathBuf;

use serde::Serialize;

use super::arguments::cycles::usual_recorded;
use super::arguments::drive::{Drives, chapters};
use super::arguments::engine::EngineArgs;
use super::arguments::output::OutputArgs;
use super::arguments::rig::{CartArg, RigAtGaps};
use crate::pictures::bifurcation::{Abscissa, figure};
use crate::pictures::drawn;
use crate::progress::ProgressLine;
use files::UserError;
use files::table::to_csv_or_header;
use files::words::count;
use numerics::bifurcation::answer::{BifurcationAnswer, DiagramAnswer};
use numerics::bifurcation::{BifurcationDiagram, DiagramRequest, diagrams, rows};
use numerics::lanes::CellPlan;
use numerics::map::request::chapter_frequencies_hz;
use numerics::row::regime_as_text;
use numerics::sweep::Direction;
use plot::chart::Chart;
use shared::model::regime::Regime;

/// In which order the frequencies are visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Which {
    /// Each frequency from rest
    Rest,
    /// The state carried upwards
    Up,
    /// The state carried downwards
    Down,
    /// All three
    All,
}

/// Draw bifurcation diagrams: displacement and force at the section over frequency, per gap, up, down and from rest
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim bifurcation --gap 1 --ratio 1.4:4:0.01 --direction all --out out"
)]
#[command(group(clap::ArgGroup::new("drive").args(["ratio", "frequency"])), mut_arg("frequency", chapters))]
pub struct Args {
    #[command(flatten)]
    drive: Drives,

    /// Start each frequency from rest, or carry the state up or down (which shows the jumps), or all three
    #[arg(long, value_enum, default_value = "rest")]
    direction: Which,

    /// Drive cycles at each frequency
    #[arg(long, value_name = "N", default_value_t = 300)]
    cycles: u32,

    /// Cycles at the end that are recorded; where the motion does not repeat, each gives a point [default: 100, of
    /// fewer than 200 cycles
    /// half]
    #[arg(long, value_name = "N")]
    recorded: Option<u32>,

    /// Measured points to draw over the diagram: CSV with frequency_hz and displacement_mm, force_n or both
    #[arg(long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,

    #[command(flatten)]
    rig: RigAtGaps,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    engine: EngineArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// A change in a table.
#[derive(Serialize)]
struct ChangeRow {
    gap_mm: f64,
    direction: &'static str,
    change: &'static str,
    #[serde(serialize_with = "regime_as_text")]
    below: Regime,
    #[serde(serialize_with = "regime_as_text")]
    above: Regime,
    frequency_hz: f64,
    frequency_ratio: f64,
    within_hz: f64,
    lasting: bool,
}

impl ChangeRow {
    /// For the names of its fields.
    const NONE: Self = Self {
        gap_mm: 0.0,
        direction: "",
        change: "",
        below: Regime::None,
        above: Regime::None,
        frequency_hz: 0.0,
        frequency_ratio: 0.0,
        within_hz: 0.0,
        lasting: false,
    };
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let request = request(args)?;
    let output = &args.output.about([&request.rig])?;
    let measured = args
        .measured
        .as_deref()
        .map(|file| crate::measured::diagram(file, |line| output.note(line)))
        .transpose()?;
    let progress = ProgressLine::new("simulations", request.simulations(), output.quiet);
    let diagrams = diagrams(&request, &progress)?;
    progress.finish();
    let points = rows(&diagrams);
    let answer = BifurcationAnswer::new(&request, &diagrams, measured.as_ref());
    let failed: usize = answer.diagrams.iter().map(|d| d.failed).sum();
    if failed > 0 {
        output.note(&format!(
            "note: in {failed} of {} simulations the hammer leaves the model's range (1 rad or 1 m) or needs a shorter tick; their rows say failed",
            answer.simulations
        ));
    }
    if let Some(dir) = &output.out {
        let abscissa = match args.drive.in_hz() {
            true => Abscissa::Frequency,
            false => Abscissa::Ratio,
        };
        let mut contents = output.tables(&output.name(""), &answer, &points)?;
        let changes: Vec<_> = answer.diagrams.iter().flat_map(change_rows).collect();
        contents.push((
            output.name("-changes.csv"),
            to_csv_or_header(&changes, ChangeRow::NONE),
        ));
        for same in diagrams.chunk_by(|a, b| a.gap_mm == b.gap_mm) {
            let all: Vec<_> = same.iter().collect();
            let name = match request.gaps_mm.len() {
                1 => output.name(""),
                _ => {
                    let gap = files::made_from::in_name(&format!("{:?}", same[0].gap_mm));
                    output.name(&format!("-at-{gap}mm"))
                }
            };
            contents.extend(drawn(&name, &figure(&all, abscissa, measured.as_ref()))?);
        }
        output.write(dir, contents)?;
    }
    output.emit(&answer, &points, || text(&answer, &diagrams))
}

fn request(args: &Args) -> Result<DiagramRequest, UserError> {
    let rig = args.cart.apply(args.rig.name.load()?)?;
    args.output.doubt_without_uncertainty(&rig);
    let given = args.drive.hz(rig.params.natural_frequency_hz())?;
    let frequencies_hz = given.unwrap_or_else(|| chapter_frequencies_hz(&rig.params));
    let recorded = args.recorded.unwrap_or(usual_recorded(args.cycles));
    let given = args.rig.gaps_mm()?;
    let mut gaps_mm = given.unwrap_or_else(|| vec![numerics::row::tidy(rig.params.gap_m * 1e3)]);
    gaps_mm.sort_by(f64::total_cmp);
    gaps_mm.dedup();
    let request = DiagramRequest {
        gaps_mm,
        frequencies_hz,
        directions: match args.direction {
            Which::Rest => vec![Direction::Rest],
            Which::Up => vec![Direction::Up],
            Which::Down => vec![Direction::Down],
            Which::All => vec![Direction::Rest, Direction::Up, Direction::Down],
        },
        engine: args.engine.engine(&args.output)?,
        plan: CellPlan {
            cycles: args.cycles,
            recorded,
            early: true,
            strobes: recorded,
        },
        locate: true,
        rig,
    };
    request.check()?;
    Ok(request)
}

fn change_rows(found: &DiagramAnswer) -> impl Iterator<Item = ChangeRow> {
    found.changes.iter().map(|c| ChangeRow {
        gap_mm: found.gap_mm,
        direction: found.direction,
        change: c.kind.words(),
        below: c.below,
        above: c.above,
        frequency_hz: c.frequency_hz,
        frequency_ratio: c.frequency_ratio,
        within_hz: c.within_hz,
        lasting: c.lasting,
    })
}

fn text(answer: &BifurcationAnswer, diagrams: &[BifurcationDiagram]) -> String {
    let mut text = String::new();
    for (found, diagram) in answer.diagrams.iter().zip(diagrams) {
        text += &format!(
            "{}, gap {:?} mm, {}, {}: {}\n",
            answer.rig,
            found.gap_mm,
            answer.cart.words(),
            match diagram.direction {
                Direction::Rest => "each from rest",
                Direction::Up => "carried up",
                Direction::Down => "carried down",
            },
            count(found.frequencies, "frequency")
        );
        let points = diagram.stations.iter().flat_map(|s| {
            let few = s.points.iter().rev().take(16);
            few.map(|p| (s.row.frequency_ratio, p.displacement_mm))
        });
        text += &Chart::new("Ω/ω", "displacement at drive phase 0, mm")
            .points("section", points.collect())
            .render();
        text += &changes_text(found);
        for (what, distance) in [
            ("displacement, mm", found.measured_displacement_mm),
            ("force, N", found.measured_force_n),
        ] {
            if let Some(d) = distance {
                text += &format!(
                    "  measured {what}: {} points compared ({} outside), root mean square distance {:.4}, largest {:.4}\n",
                    d.points_compared, d.points_outside, d.rms, d.largest
                );
            }
        }
        text.push('\n');
    }
    for t in &answer.twofold {
        let place = match t.from_hz == t.to_hz {
            true => format!("at {:.4}", t.from_hz),
            false => format!("from {:.4} to {:.4}", t.from_hz, t.to_hz),
        };
        text += &format!(
            "gap {:?} mm: up and down differ {place} Hz (up {}, down {})\n",
            t.gap_mm, t.up, t.down
        );
    }
    text
}

fn changes_text(found: &DiagramAnswer) -> String {
    let lasting: Vec<_> = found.changes.iter().filter(|c| c.lasting).collect();
    let mut text = String::new();
    if !lasting.is_empty() {
        text += "   Hz          within     Ω/ω      below      above      what\n";
    }
    for c in &lasting {
        text += &format!(
            "  {:>9.5}  {:>9.5}  {:>8.5}  {:<10} {:<10} {}\n",
            c.frequency_hz,
            c.within_hz,
            c.frequency_ratio,
            c.below.to_string(),
            c.above.to_string(),
            c.kind.words()
        );
    }
    let brief = found.changes.len() - lasting.len();
    if brief > 0 {
        text +=
            &format!("  and {brief} shorter than three frequencies (--format json lists them)\n");
    }
    if found.not_settled > 0 {
        text += &format!(
            "  {} of {} have not settled\n",
            found.not_settled,
            count(found.frequencies, "frequency")
        );
    }
    text
}
