//! `host-sim orbits`.

mod curve;
mod lines;

use clap::ValueEnum;

use curve::{CurveOver, parse_curve};

use crate::cli::arguments::output::OutputArgs;
use crate::cli::arguments::range::{parse_finite, rising};
use crate::cli::arguments::rig::{CartArg, RigName, at_gap, parse_gap};
use crate::pictures;
use crate::progress::ProgressLine;
use crate::words::number;
use files::UserError;
use files::decimal::hint;
use numerics::NamedRig;
use numerics::continuation::table::{BranchRow, OrbitsAnswer, SpecialRow};
use numerics::continuation::{Along, CurveEnd, FamilyDrive, OrbitsRequest, diagram};
use numerics::orbit::Stability;
use plot::chart::Chart;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OrbitsAxis {
    /// The drive frequency, at one gap
    Frequency,
    /// The gap, at one drive frequency
    Gap,
}

/// Follow periodic orbits, stable and unstable, over frequency or gap, with doublings, folds and grazes
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim orbits --gap 1 --ratio 1:2.5\n  host-sim orbits --curves --gap 0:1:0.5 --ratio 1:3\n  host-sim orbits --curve gap_mm=0:3 --periods 1 --impacts 1 --out out\n  host-sim orbits --curve contact_stiffness_n_per_m=1e6:1e8:log --ratio 1:3"
)]
#[command(group(clap::ArgGroup::new("drive").args(["ratio", "frequency"])))]
pub struct Args {
    /// Parameter to vary
    #[arg(long, value_enum, default_value = "frequency")]
    along: OrbitsAxis,

    /// Frequencies over the natural frequency, Ω/ω; one value with --along gap [default: 0.8:4]
    #[arg(long, value_name = "FROM:TO", allow_hyphen_values = true)]
    ratio: Option<String>,

    /// Frequencies, Hz; one value with --along gap
    #[arg(long, value_name = "FROM:TO", allow_hyphen_values = true)]
    frequency: Option<String>,

    /// Most drive periods of an orbit
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=8))]
    periods: u8,

    /// Most contacts of an orbit
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u16).range(1..=16))]
    impacts: u16,

    /// Frequencies (or gaps) at which simulations search for orbits
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=2000))]
    starts: u16,

    /// Frequencies (or gaps) at which simulations check that no orbit was missed [default: forty times --starts; twice
    /// with a nonlinear contact law, whose simulations take longer]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=20000))]
    checks: Option<u16>,

    /// Simulations drawn behind the orbits in the picture
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u16).range(0..=20000))]
    behind: u16,

    /// Join the special points of the 1/1 at many gaps to lines over gap and frequency
    #[arg(long)]
    curves: bool,

    /// Follow period doublings, folds and grazes over frequency or gap (--along) and this parameter. Given twice: over
    /// these two, at one drive frequency
    #[arg(long, value_name = "KEY=FROM:TO[:log]", value_parser = parse_curve, conflicts_with_all = ["curves", "behind"])]
    curve: Vec<CurveOver>,

    /// Values of the second parameter of --curve at which the search for orbits begins
    #[arg(long, value_name = "N", default_value_t = 5, requires = "curve", value_parser = clap::value_parser!(u16).range(1..=200))]
    searches: u16,

    #[command(flatten)]
    rig: RigName,

    /// Clearance at rest, mm [default: the rig's]; FROM:TO with --along gap [default: 0:3.56], FROM:TO:STEP with --curves
    /// [default: 0:3.56:0.04]
    #[arg(
        long,
        alias = "gaps",
        value_name = "MM|FROM:TO[:STEP]",
        allow_hyphen_values = true,
        help_heading = "Rig"
    )]
    gap: Option<String>,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let rig = args.cart.apply(args.rig.at(one_gap(args)?).load()?)?;
    let output = &args.output.about([&rig])?;
    output.doubt_without_uncertainty(&rig);
    if args.curves {
        return lines::run(args, output, &rig);
    }
    if !args.curve.is_empty() {
        return curve::run(args, output, &rig);
    }
    let request = request(args, &rig)?;
    let progress = ProgressLine::new("starts", request.simulations(), output.quiet);
    let found = diagram(&rig.params, &request, &progress)?;
    progress.finish();
    let answer = OrbitsAnswer::new(&rig.name, &found);
    if answer.failed_simulations > 0 {
        output.note(&format!(
            "note: in {} of {} simulations the hammer leaves the model's range (1 rad or 1 m); they found no orbit",
            answer.failed_simulations, answer.simulations
        ));
    }
    let picture = || {
        let behind = pictures::orbits::simulated(&found, usize::from(args.behind))?;
        output.picture(&pictures::orbits::figure(&rig.name, &found, &behind))
    };
    output.answer(&answer, &answer.orbits, picture, || text(&answer))
}

/// The one gap given, mm, where none is varied.
fn one_gap(args: &Args) -> Result<Option<f64>, UserError> {
    let Some(text) = &args.gap else {
        return Ok(None);
    };
    if args.curves || args.along == OrbitsAxis::Gap {
        args.rig.check_gap()?;
        return Ok(None);
    }
    let gap = parse_gap(text).map_err(|_| {
        UserError::new(format!(
            "--gap {text}: write one number of millimetres; FROM:TO goes with --along gap, FROM:TO:STEP with --curves"
        ))
    });
    gap.map(Some)
}

fn request(args: &Args, rig: &NamedRig) -> Result<OrbitsRequest, UserError> {
    let natural_hz = rig.params.natural_frequency_hz();
    let (along, limits) = match args.along {
        OrbitsAxis::Frequency => (Along::Frequency, ratios(args, rig)?),
        OrbitsAxis::Gap => {
            let hz = match one_drive(args, "--along gap", "--along gap")? {
                FamilyDrive::Ratio(ratio) => ratio * natural_hz,
                FamilyDrive::Hz(hz) => hz,
            };
            let (from, to) = gap_ends(args)?;
            for mm in [from, to] {
                at_gap(&rig.params, mm, "--gap")?;
            }
            let unit = rig.params.amplitude_m * 1e3;
            (Along::Gap(hz), (from / unit, to / unit))
        }
    };
    Ok(OrbitsRequest {
        along,
        limits,
        periods: args.periods,
        impacts: args.impacts,
        starts: usize::from(args.starts),
        checks: args.checks.map_or_else(
            || OrbitsRequest::usual_checks(&rig.params, usize::from(args.starts)),
            usize::from,
        ),
    })
}

/// The one drive frequency that goes `with` what is varied, and that `who` needs.
fn one_drive(args: &Args, with: &str, who: &str) -> Result<FamilyDrive, UserError> {
    let one = |option: &str, text: &str| {
        let value = parse_finite(text).filter(|x| *x > 0.0);
        value.ok_or_else(|| {
            UserError::new(format!(
                "{option} {text}: with {with} write one positive number{}",
                hint(text)
            ))
        })
    };
    match (&args.ratio, &args.frequency) {
        (Some(text), _) => one("--ratio", text).map(FamilyDrive::Ratio),
        (None, Some(text)) => one("--frequency", text).map(FamilyDrive::Hz),
        (None, None) => Err(UserError::new(format!(
            "{who} needs the drive frequency: --ratio or --frequency"
        ))),
    }
}

/// The range of Ω/ω asked for.
fn ratios(args: &Args, rig: &NamedRig) -> Result<(f64, f64), UserError> {
    let (option, text, unit) = match (&args.ratio, &args.frequency) {
        (None, Some(text)) => (
            "--frequency",
            text.as_str(),
            rig.params.natural_frequency_hz(),
        ),
        (Some(text), _) => ("--ratio", text.as_str(), 1.0),
        (None, None) => ("--ratio", "0.8:4", 1.0),
    };
    let (from, to) = ends(option, text)?;
    if from <= 0.0 {
        return Err(UserError::new(format!(
            "{option} {text}: {from} is not a positive value"
        )));
    }
    Ok((from / unit, to / unit))
}

/// The range of gaps asked for with `--along gap`, mm.
fn gap_ends(args: &Args) -> Result<(f64, f64), UserError> {
    ends("--gap", args.gap.as_deref().unwrap_or("0:3.56"))
}

/// Both ends of `FROM:TO`, of which FROM must be below TO; errors begin with `option`.
fn ends(option: &str, text: &str) -> Result<(f64, f64), UserError> {
    let parts: Vec<_> = text.split(':').map(|t| t.trim().parse::<f64>()).collect();
    match parts.as_slice() {
        [Ok(from), Ok(to)] if from.is_finite() && to.is_finite() => {
            let wrong = |what| UserError::new(format!("{option} {text}: {what}"));
            rising(*from, *to).map(|()| (*from, *to)).map_err(wrong)
        }
        _ => Err(UserError::new(format!(
            "{option} {text}: write FROM:TO, for example 0.8:4{}",
            hint(text)
        ))),
    }
}

fn text(answer: &OrbitsAnswer) -> String {
    if answer.branches.is_empty() {
        return "no periodic orbit with contact was found; widen the range, raise --periods, --impacts or --starts\n"
            .to_owned();
    }
    let parameter = if answer.along == "gap" {
        "gap/A0"
    } else {
        "Ω/ω"
    };
    let mut text = format!(
        "{}, {}: periodic orbits\n\n{:<8} {:>6} {:<19} {:<36} {:>9}  ends\n",
        answer.rig,
        answer.cart.words(),
        "branch",
        "orbits",
        parameter,
        format!("stable in {parameter}"),
        "F/mg to"
    );
    for branch in &answer.branches {
        text += &branch_line(branch);
    }
    text += &format!(
        "\n{:<8} {:<25} {:>10} {:>9} {:>9} {:>9} {:>12}\n",
        "branch", "special point", "Hz", "Ω/ω", "gap, mm", "F/mg", "|multiplier|"
    );
    for point in &answer.special_points {
        text += &special_line(point);
    }
    text += &seen_elsewhere(answer, parameter);
    let of = |stability: Stability| {
        let orbits = answer.orbits.iter();
        let shown = orbits.filter(|o| o.strobe == 1 && o.stability == stability);
        let x = |o: &numerics::continuation::table::OrbitRow| match answer.along {
            "gap" => o.gap_mm,
            _ => o.frequency_ratio,
        };
        shown.map(|o| (x(o), o.force_ratio)).collect::<Vec<_>>()
    };
    let x = if answer.along == "gap" {
        "gap, mm"
    } else {
        "frequency ratio"
    };
    text.push('\n');
    let mut chart = Chart::new(x, "force over weight").points("stable", of(Stability::Stable));
    let neutral = of(Stability::Neutral);
    if !neutral.is_empty() {
        chart = chart.points("neutral", neutral);
    }
    text += &chart.points("unstable", of(Stability::Unstable)).render();
    text
}

fn branch_line(branch: &BranchRow) -> String {
    let range = |[from, to]: [f64; 2]| format!("{from:.4} to {to:.4}");
    let stable = branch.stable.iter().map(|s| range(*s));
    let neutral = branch
        .neutral
        .iter()
        .map(|s| format!("neutral {}", range(*s)));
    let stable: Vec<_> = stable.chain(neutral).collect();
    let stable = if stable.is_empty() {
        "nowhere".to_owned()
    } else {
        stable.join(", ")
    };
    let from = branch.doubled_from.as_ref();
    let ends = match from {
        Some(from) => format!("doubled {from} | {}", end_words(branch.ends[1])),
        None => format!(
            "{} | {}",
            end_words(branch.ends[0]),
            end_words(branch.ends[1])
        ),
    };
    format!(
        "{:<8} {:>6} {:<19} {:<36} {:>9}  {}\n",
        branch.branch,
        branch.orbits,
        range(branch.range),
        stable,
        number(branch.largest_stable_force_ratio, 3),
        ends
    )
}

fn end_words(end: CurveEnd) -> &'static str {
    match end {
        CurveEnd::Limit => "range ends",
        CurveEnd::Special(kind) => kind.label(),
        CurveEnd::Halved => "closes on half its period",
        CurveEnd::Closed => "closes on itself",
        CurveEnd::Lost => "not followed further",
        CurveEnd::Merged => "two contacts merge",
    }
}

/// What simulations settled on besides, and what was not looked for.
fn seen_elsewhere(answer: &OrbitsAnswer, parameter: &str) -> String {
    let mut text = String::new();
    for row in &answer.seen_elsewhere {
        let [from, to] = row.range;
        text += &format!(
            "\n{} of {} simulations settled on {}/{} off these branches ({parameter} {from:.4} to {to:.4})",
            row.simulations, answer.simulations, row.impacts, row.periods
        );
    }
    if !text.is_empty() {
        text.push('\n');
    }
    text + "\nnot computed: crises of chaotic motion and homoclinic ends of branches\n"
}

fn special_line(point: &SpecialRow) -> String {
    format!(
        "{:<8} {:<25} {:>10.6} {:>9.6} {:>9.4} {:>9.3} {:>12.4}\n",
        point.branch,
        point.special.label(),
        point.frequency_hz,
        point.frequency_ratio,
        point.gap_mm,
        point.force_ratio,
        point.multiplier_modulus
    )
}
