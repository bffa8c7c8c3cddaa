//! `host-sim drill --published`: the published drifting oscillator on the same ground.

use serde::Serialize;
use serde_json::json;

use crate::cli::arguments::output::OutputArgs;
use crate::cli::arguments::range::parse_range;
use crate::pictures::drill::drifting;
use crate::progress::ProgressLine;
use files::UserError;
use files::range::within;
use files::table::to_csv;
use numerics::drill::DrillPlan;
use numerics::drill::published::{Drifting, DriftingRow, PERIOD_TWO, diagram};

/// Its parameters, without dimensions: mass, stiffness and threshold are 1.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Published oscillator")]
pub struct PublishedOscillator {
    /// With --published: static forces b over the threshold
    #[arg(long, value_name = "FROM:TO:STEP", default_value = "0.02:0.3:0.001", value_parser = forces)]
    static_force: Forces,

    /// With --published: amplitude a of the harmonic force over the threshold
    #[arg(long, value_name = "A", default_value_t = PERIOD_TWO.a)]
    force_amplitude: f64,

    /// With --published: damping ratio ξ
    #[arg(long, value_name = "XI", default_value_t = PERIOD_TWO.xi)]
    damping_ratio: f64,

    /// With --published: drive frequency ω over √(k/m)
    #[arg(long, value_name = "W", default_value_t = PERIOD_TWO.omega)]
    omega: f64,
}

/// Values of the static force b, in units of the threshold at which the ground gives way.
#[derive(Clone, Debug)]
struct Forces(Vec<f64>);

fn forces(text: &str) -> Result<Forces, String> {
    let values = parse_range(text)?;
    Ok(Forces(
        values.into_iter().map(numerics::row::tidy).collect(),
    ))
}

/// Neighbouring static forces with motions that repeat after the same number of periods.
#[derive(Serialize)]
struct Stretch {
    from_static_force: f64,
    to_static_force: f64,
    periods: Option<u8>,
    motions: usize,
}

/// A point of the diagram: the mass seen from the front of the ground, at the end of a period of the force.
#[derive(Serialize)]
struct PointRow {
    a: f64,
    b: f64,
    xi: f64,
    omega: f64,
    p: f64,
    p_rate: f64,
}

fn points(rows: &[DriftingRow]) -> Vec<PointRow> {
    let of = |row: &DriftingRow| {
        let (a, b, xi, omega) = (row.a, row.b, row.xi, row.omega);
        let points = row.section.iter();
        let point = points.map(move |(p, p_rate)| PointRow {
            a,
            b,
            xi,
            omega,
            p: *p,
            p_rate: *p_rate,
        });
        point.collect::<Vec<_>>()
    };
    rows.iter().flat_map(of).collect()
}

pub fn run(args: &PublishedOscillator, settle: u32, output: &OutputArgs) -> Result<(), UserError> {
    within("--force-amplitude", args.force_amplitude, 1e-3, 10.0)?;
    within("--damping-ratio", args.damping_ratio, 1e-4, 10.0)?;
    within("--omega", args.omega, 1e-3, 100.0)?;
    let output = &output.about(None)?;
    let motions = args.static_force.0.iter().map(|b| Drifting {
        a: args.force_amplitude,
        b: *b,
        xi: args.damping_ratio,
        omega: args.omega,
    });
    let motions: Vec<_> = motions.collect();
    if let Some(bad) = motions.iter().find(|m| !(m.b > 0.0 && m.b < 1.0)) {
        return Err(UserError::new(format!(
            "--static-force: {} is not between 0 and 1, the threshold",
            bad.b
        )));
    }
    let plan = DrillPlan {
        settle,
        recorded: 64,
    };
    let progress = ProgressLine::new("motions", motions.len() as u64, output.quiet);
    let rows = diagram(&motions, plan, &progress)?;
    progress.finish();
    let stretches: Vec<_> = rows
        .chunk_by(|a, b| a.periods == b.periods)
        .map(|same| Stretch {
            from_static_force: same[0].b,
            to_static_force: same[same.len() - 1].b,
            periods: same[0].periods,
            motions: same.len(),
        })
        .collect();
    let answer = json!({ "stretches": stretches, "rows": rows });
    let files = || {
        let mut files = output.picture(&drifting(&rows))?;
        files.push((output.name("-points.csv"), to_csv(&points(&rows))));
        Ok(files)
    };
    output.answer(&answer, &rows, files, || text(&stretches, &rows))
}

fn text(stretches: &[Stretch], rows: &[DriftingRow]) -> String {
    let Some(first) = rows.first() else {
        return String::new();
    };
    let of = first;
    let mut text = format!(
        "drifting oscillator, a {:?}, ξ {:?}, ω {:?}: the motion repeats after\n",
        of.a, of.xi, of.omega
    );
    let lasting = stretches.iter().filter(|s| s.motions > 2);
    for s in lasting {
        let after = match s.periods {
            Some(1) => "1 period".to_owned(),
            Some(n) => format!("{n} periods"),
            None => "no number of periods up to 16".to_owned(),
        };
        text += &format!(
            "  b {:.4} to {:.4}: {after}\n",
            s.from_static_force, s.to_static_force
        );
    }
    let brief = stretches.iter().filter(|s| s.motions <= 2).count();
    if brief > 0 {
        text +=
            &format!("  and {brief} stretches of one or two values (--format json lists them)\n");
    }
    let best = rows
        .iter()
        .max_by(|a, b| a.progression_rate.total_cmp(&b.progression_rate));
    if let Some(best) = best {
        text += &format!(
            "it drifts fastest at b {:.4}: {:.4} per period\n",
            best.b, best.progress_per_period
        );
    }
    text
}
