//! `orbits --curve`: doublings, folds and grazes over two parameters, each followed as one continuation.

use super::{Args, OrbitsAxis, end_words, gap_ends, one_drive, ratios};
use crate::cli::arguments::output::OutputArgs;
use crate::cli::arguments::range::{parse_finite, rising};
use crate::pictures;
use crate::progress::ProgressLine;
use files::{UserError, rigfile};
use numerics::NamedRig;
use numerics::continuation::FamilyDrive;
use numerics::continuation::two::table::{CurvePointRow, CurvesAnswer, TwoParameterCurveRow};
use numerics::continuation::two::{Condition, CurvesRequest, Dimension, Plane, Varied};
use numerics::knob::Knob;
use plot::chart::Chart;

/// One axis of the plane, `KEY=FROM:TO` or `KEY=FROM:TO:log`: a number of the rig, and the range it is followed over.
#[derive(Clone, Copy, Debug)]
pub struct CurveOver {
    knob: Knob,
    range: (f64, f64),
    log: bool,
}

/// Reads `KEY=FROM:TO[:log]`.
///
/// # Errors
/// In words: there is no such parameter, or the range cannot be read.
pub fn parse_curve(text: &str) -> Result<CurveOver, String> {
    let form = "write KEY=FROM:TO or KEY=FROM:TO:log, for example gap_mm=0:3";
    let (key, range) = text.split_once('=').ok_or(form)?;
    let key = key.trim();
    let knob = Knob::named(key).ok_or_else(|| {
        let hint = rigfile::nearest(key, Knob::all().map(Knob::name));
        format!(
            "there is no number '{key}' of a rig{hint}; one of {}",
            Knob::all().map(Knob::name).collect::<Vec<_>>().join(", ")
        )
    })?;
    let parts: Vec<&str> = range.split(':').map(str::trim).collect();
    let (from, to, log) = match parts.as_slice() {
        [from, to] => (from, to, false),
        [from, to, "log"] => (from, to, true),
        _ => return Err(form.to_owned()),
    };
    let (Some(from), Some(to)) = (parse_finite(from), parse_finite(to)) else {
        return Err(form.to_owned());
    };
    rising(from, to)?;
    if log && from <= 0.0 {
        return Err(format!("FROM is {from}, must be positive with log"));
    }
    Ok(CurveOver {
        knob,
        range: (from, to),
        log,
    })
}

/// Follows the curves.
///
/// # Errors
/// If the request makes no sense, a rig cannot be, or the work is interrupted.
pub fn run(args: &Args, output: &OutputArgs, rig: &NamedRig) -> Result<(), UserError> {
    let (starts, checks) = (usize::from(args.starts), args.checks.map_or(0, usize::from));
    let request = CurvesRequest {
        plane: plane(args, rig)?,
        search: CurvesRequest::search(args.periods, args.impacts, starts, checks),
        searches: usize::from(args.searches),
    };
    request.check()?;
    let progress = ProgressLine::new("starts", request.simulations(), output.quiet);
    let found = request.seeds(&progress)?;
    progress.finish();
    let progress = ProgressLine::new("special points", found.seeds.len() as u64, output.quiet);
    let answer = request.curves(&rig.name, &found, &progress)?;
    progress.finish();
    if answer.not_followed > 0 {
        output.note(&format!(
            "note: from {} of {} special points no curve could be followed",
            answer.not_followed,
            answer.not_followed + found.seeds.len()
        ));
    }
    let picture = || output.picture(&pictures::two::figure(&rig.name, &request.plane, &answer));
    output.answer(&answer, &answer.points, picture, || text(&answer))
}

/// The plane asked for: what the command varies and the one `--curve`, or the two.
fn plane(args: &Args, rig: &NamedRig) -> Result<Plane, UserError> {
    let params = &rig.params;
    let of =
        |over: &CurveOver| Dimension::new(Varied::Rig(over.knob), over.range, over.log, params);
    let gap = |over: &&CurveOver| over.knob.name() == "gap_mm";
    let over_gap = args.along != OrbitsAxis::Gap && args.curve.iter().any(|c| gap(&c));
    if over_gap && args.gap.is_some() {
        return Err(UserError::new(
            "--gap does not go with a curve over the gap; leave it out",
        ));
    }
    let (first, second) = match args.curve.as_slice() {
        [second] if args.along == OrbitsAxis::Gap => {
            let knob = Knob::named("gap_mm").map(Varied::Rig);
            let range = gap_ends(args)?;
            let first = knob.map(|gap| Dimension::new(gap, range, false, params));
            (first.unwrap_or_else(|| of(second)), second)
        }
        [second] => {
            let range = ratios(args, rig)?;
            if args.frequency.is_some() {
                let natural = params.natural_frequency_hz();
                let hz = (range.0 * natural, range.1 * natural);
                (Dimension::new(Varied::Frequency, hz, false, params), second)
            } else {
                (Dimension::new(Varied::Ratio, range, false, params), second)
            }
        }
        [first, second] if args.along == OrbitsAxis::Frequency => (of(first), second),
        _ => {
            return Err(UserError::new(
                "--curve may be given once (beside what --along varies), or twice with --along frequency",
            ));
        }
    };
    Ok(Plane {
        params: *params,
        drive: drive(args, first.varied)?,
        dimensions: [first, of(second)],
    })
}

/// The drive, where neither parameter is the drive's.
fn drive(args: &Args, first: Varied) -> Result<FamilyDrive, UserError> {
    if first.drives() {
        return Ok(FamilyDrive::Ratio(1.0));
    }
    let two = "two parameters of the rig";
    one_drive(args, two, &format!("a curve over {two}"))
}

fn text(answer: &CurvesAnswer) -> String {
    let values: Vec<_> = answer.searched_at.iter().map(f64::to_string).collect();
    let searched = format!("{} {}", answer.parameter_2, values.join(", "));
    if answer.curves.is_empty() {
        return format!(
            "no special point was found at {searched}; widen the ranges, or raise --searches, --starts, --periods or --impacts\n"
        );
    }
    let mut text = format!(
        "{}, {}: special points over two parameters\n\n{:<20} {:<6} {:>6}  {:<26} {:<30} ends\n",
        answer.rig,
        answer.cart.words(),
        "curve",
        "p/n",
        "points",
        answer.parameter_1,
        answer.parameter_2
    );
    for curve in &answer.curves {
        text += &curve_line(curve);
    }
    if !answer.codimension_two.is_empty() {
        text += &format!(
            "\n{:<20} {:<22} {:>26} {:>30}\n",
            "curve", "second condition", answer.parameter_1, answer.parameter_2
        );
    }
    for point in &answer.codimension_two {
        text += &mark_line(point);
    }
    text += &format!(
        "\np/n of a graze: contacts without the touch\nsearched at {searched} (--searches)\n\n"
    );
    let mut chart = Chart::new(answer.parameter_2, answer.parameter_1);
    for condition in Condition::ALL {
        let points = answer.points.iter().filter(|p| p.condition == condition);
        let points: Vec<_> = points.map(|p| (p.value_2, p.value_1)).collect();
        if !points.is_empty() {
            chart = chart.points(condition.label(), points);
        }
    }
    text + &chart.render()
}

fn curve_line(curve: &TwoParameterCurveRow) -> String {
    let range = |[from, to]: [f64; 2]| format!("{} to {}", short(from), short(to));
    let [from, to] = curve.ends;
    format!(
        "{:<20} {:<6} {:>6}  {:<26} {:<30} {} | {}\n",
        curve.curve,
        format!("{}/{}", curve.impacts, curve.periods),
        curve.points,
        range(curve.range_1),
        range(curve.range_2),
        end_words(from),
        end_words(to)
    )
}

fn mark_line(point: &CurvePointRow) -> String {
    let label = point.codimension_two.map_or("", |mark| mark.label());
    format!(
        "{:<20} {label:<22} {:>26} {:>30}\n",
        point.curve,
        short(point.value_1),
        short(point.value_2)
    )
}

/// Five decimals; a very small or large value has an exponent.
fn short(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) {
        format!("{x:.5e}")
    } else {
        format!("{x:.5}")
    }
}
