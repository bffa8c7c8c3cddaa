//! `host-sim poincare`.

use super::arguments::cycles::parse_start;
use super::arguments::drive::OneFrequency;
use super::arguments::output::OutputArgs;
use super::arguments::rig::{CartArg, RigArgs};
use crate::pictures::poincare::{against_figure, figure};
use crate::progress::ProgressLine;
use files::UserError;
use files::words::count;
use numerics::CartModel;
use numerics::engine::Start;
use numerics::lyapunov::{self, Exponents};
use numerics::poincare::against::{self, SectionComparison, SectionSummary};
use numerics::poincare::answer::SectionAnswer;
use numerics::poincare::{Portrait, SectionPoint, SectionRequest, portrait};
use numerics::row::{Outcome, tidy};
use numerics::{Error, NamedRig};
use plot::chart::Chart;

/// What the section is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Other {
    /// The smoothing method, at each --epsilon-m
    Smoothed,
}

/// Compute a Poincaré section with thousands of points, Lyapunov exponents, and the smoothing method beside the switch
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim poincare --gap 2.4 --ratio 2.7 --points 2000 --out out"
)]
#[command(group(clap::ArgGroup::new("drive").required(true).args(["ratio", "frequency"])))]
pub struct Args {
    #[command(flatten)]
    drive: OneFrequency,

    /// Points of each section, one per drive period
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    points: u32,

    /// Drive cycles before the first point
    #[arg(long, value_name = "N", default_value_t = 500)]
    transient: u32,

    /// Drive phase of the section, turns from 0 to below 1; may be given several times [default: 0]
    #[arg(long, value_name = "TURNS")]
    phase: Vec<f64>,

    /// Initial condition: rest (relative to the cart), fixed (at rest in the laboratory), or
    /// DISPLACEMENT_MM,VELOCITY_M_PER_S relative to the cart
    #[arg(long, value_parser = parse_start, default_value = "rest", allow_hyphen_values = true)]
    initial: Start,

    /// Also compute the Lyapunov exponents over the same drive periods
    #[arg(long)]
    lyapunov: bool,

    /// Compare the section at drive phase 0 with another model
    #[arg(long, value_enum)]
    against: Option<Other>,

    /// Width of the smoothed switch in penetration, m; may be given several times [default: 1e-6, 3e-7 and 1e-7]
    #[arg(long, value_name = "M", requires = "against")]
    epsilon_m: Vec<f64>,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let rig = args.cart.apply(args.rig.load()?)?;
    if args.against.is_some() && rig.params.cart.recoils() {
        let refused = UserError::from(Error::Recoil("the smoothing method"));
        return Err(refused.at("--against smoothed"));
    }
    args.output.doubt_without_uncertainty(&rig);
    let request = request(args, &rig)?;
    let output = &args.output.about([&rig])?;
    match args.against {
        Some(Other::Smoothed) => run_against(args, output, &rig, &request),
        None => run_section(args, output, &rig, &request),
    }
}

fn request(args: &Args, rig: &NamedRig) -> Result<SectionRequest, UserError> {
    let natural = rig.params.natural_frequency_hz();
    let frequency_hz = args.drive.needed_hz(natural)?;
    let mut phases = if args.phase.is_empty() {
        vec![0.0]
    } else {
        args.phase.clone()
    };
    phases.sort_by(f64::total_cmp);
    phases.dedup();
    if args.against.is_some() && phases != [0.0] {
        return Err(UserError::new(
            "--against compares sections at drive phase 0; leave --phase out",
        ));
    }
    let request = SectionRequest {
        params: rig.params,
        frequency_hz,
        start: args.initial,
        phases,
        transient: args.transient,
        points: args.points,
    };
    request.check()?;
    Ok(request)
}

fn run_section(
    args: &Args,
    output: &OutputArgs,
    rig: &NamedRig,
    request: &SectionRequest,
) -> Result<(), UserError> {
    let progress = ProgressLine::new("drive periods", u64::from(request.points), output.quiet);
    let (portrait, exponents) = rayon::join(
        || portrait(request, &progress),
        || args.lyapunov.then(|| exponents(request)).transpose(),
    );
    let (portrait, exponents) = (portrait?, exponents?);
    progress.finish();
    let rows: Vec<SectionPoint> = portrait.sections.iter().flatten().copied().collect();
    let answer = SectionAnswer::new(&rig.name, request, &portrait, exponents);
    let picture = || output.picture(&figure(rig, request, &portrait));
    output.answer(&answer, &rows, picture, || text(&answer, &portrait))
}

fn exponents(request: &SectionRequest) -> Result<Exponents, UserError> {
    let rig = shared::model::rig::Rig::<f64>::new(&request.params)?;
    let section = request
        .start
        .section(&rig, std::f64::consts::TAU * request.frequency_hz)?;
    let plan = lyapunov::LyapunovSpan {
        transient: request.transient,
        periods: request.points,
    };
    Ok(lyapunov::exponents(
        &request.params,
        request.frequency_hz,
        section,
        plan,
    )?)
}

fn heading(rig: &NamedRig, request: &SectionRequest) -> String {
    format!(
        "{}, gap {:?} mm, cart prescribed, {:.4} Hz ({:.4} times the natural frequency)\n",
        rig.name,
        tidy(request.params.gap_m * 1e3),
        request.frequency_hz,
        request.frequency_hz / request.params.natural_frequency_hz()
    )
}

fn text(answer: &SectionAnswer, portrait: &Portrait) -> String {
    let regime = match answer.regime {
        Outcome::Unsettled => format!(
            "{}: it does not repeat in the {} recorded, and still changes; give a longer --transient or more --points",
            answer.regime,
            count(answer.points as usize, "drive period")
        ),
        known => format!(
            "{known} over {}",
            count(answer.points as usize, "drive period")
        ),
    };
    let mut text = format!(
        "{}, gap {:?} mm, {}, {:.4} Hz ({:.4} times the natural frequency)\n  regime    {regime}\n  force     {:.2} N, {:.3} times the hammer's weight\n",
        answer.rig,
        answer.gap_mm,
        answer.cart.words(),
        answer.frequency_hz,
        answer.frequency_ratio,
        answer.force_n,
        answer.force_ratio
    );
    if let (Some(e), Some(meaning)) = (&answer.lyapunov, answer.meaning) {
        text += &format!(
            "  exponent  {:+.4} ± {:.4} per second ({:+.4} per drive period): {meaning}\n",
            e.largest_per_s, e.standard_error_per_s, e.largest_per_period
        );
        if let Some(other) = e.other_per_s {
            let which = match answer.cart {
                CartModel::Prescribed => "the other",
                CartModel::Recoil => "the second of the four of hammer and cart",
            };
            text += &format!("            {which} {other:+.4} per second\n");
        }
    }
    for (phase, section) in answer.phases_turns.iter().zip(&portrait.sections) {
        let points = section
            .iter()
            .map(|p| (p.relative_displacement_mm, p.relative_velocity_m_per_s));
        text += &format!("\nsection at drive phase {phase:?} turns\n");
        text += &Chart::new("displacement relative to the cart, mm", "velocity, m/s")
            .points("section", points.collect())
            .render();
    }
    text
}

fn run_against(
    args: &Args,
    output: &OutputArgs,
    rig: &NamedRig,
    request: &SectionRequest,
) -> Result<(), UserError> {
    let widths = match args.epsilon_m.as_slice() {
        [] => &against::WIDTHS_M[..],
        widths => widths,
    };
    let runs = (widths.len() as u64 + 2) * u64::from(request.points);
    let progress = ProgressLine::new("drive periods", runs, output.quiet);
    let found = against::against(request, widths, &progress)?;
    progress.finish();
    let rows = found.rows();
    let picture = || output.picture(&against_figure(rig, request, &found));
    output.answer(&rows, &rows, picture, || {
        heading(rig, request) + &against_text(&found, &rows)
    })
}

fn against_text(found: &SectionComparison, rows: &[SectionSummary]) -> String {
    let mut text = format!(
        "  the switch: regime {} over {} points\n\n  model                  width, m  repeats  steps/period  away, A0  boxes not shared  exponent/period\n",
        found.exact.outcome(),
        found.exact.sections[0].len()
    );
    for r in rows {
        let dash = || "-".to_owned();
        text += &format!(
            "  {:<21}  {:>8}  {:>7}  {:>12.1}  {:>8.4}  {:>14.1} %  {}\n",
            r.model,
            r.epsilon_m.map_or_else(dash, |e| format!("{e:.0e}")),
            r.section_periods.map_or_else(dash, |n| n.to_string()),
            r.steps_per_period,
            r.carried,
            100.0 * r.boxes_not_shared,
            match (r.largest_exponent_per_period, r.exponent_error_per_period) {
                (Some(e), Some(error)) => format!("{e:+.4} ± {error:.4}"),
                _ => dash(),
            }
        );
    }
    text + "\n  away: mean distance by which points must be moved to give the switch model's section (in A0 and A0 Ω)\n"
}
