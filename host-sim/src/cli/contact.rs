//! `host-sim contact`.

use super::arguments::output::OutputArgs;
use super::arguments::range::range_or_value;
use super::arguments::rig::RigName;
use crate::pictures::contact_law::{blows, grid, over_speed};
use files::UserError;
use numerics::NamedRig;
use numerics::contact_law::{ContactFigures, FIGURE_3_3, FIGURE_3_3_MASS_KG, all_laws, rows};
use shared::model::contact::Law;

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Which {
    /// The rig's own law, and the others with parameters for the contact of Table 3.1
    All,
    /// The rig's own law alone
    Own,
}

/// Compute one impact of a free mass on a wall under each contact law: force, restitution, energy, and the pull of some
/// laws
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim contact --speed 0.1\n  host-sim contact --figure-3-3"
)]
pub struct Args {
    /// Approach speeds, m/s: FROM:TO:STEP, or one value [default: 0.02:0.3:0.02; figure 3.3: 0.1:0.5:0.1]
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true)]
    speed: Option<String>,

    /// Contact laws
    #[arg(long, value_enum, default_value = "all")]
    law: Which,

    /// The impact of figure 3.3: 2 kg, Hunt-Crossley, ki = 2.1e8, n = 1.6, lambda = 0.6
    #[arg(long, conflicts_with_all = ["rig", "set", "law"])]
    figure_3_3: bool,

    #[command(flatten)]
    rig: RigName,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// Mass, laws and speeds to simulate.
struct Case {
    title: String,
    mass_kg: f64,
    laws: Vec<(&'static str, Law<f64>)>,
    speeds: Vec<f64>,
    /// The rig whose contact it is; none for figure 3.3.
    rig: Option<NamedRig>,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let case = case(args)?;
    let output = &args.output.about(&case.rig)?;
    let mut all = Vec::new();
    for (name, law) in &case.laws {
        all.extend(rows(name, *law, case.mass_kg, &case.speeds)?);
    }
    let picture = || output.picture(&figure(&case, &all)?);
    output.answer(&all, &all, picture, || text(&case, &all))
}

fn case(args: &Args) -> Result<Case, UserError> {
    let usual = if args.figure_3_3 {
        "0.1:0.5:0.1"
    } else {
        "0.02:0.3:0.02"
    };
    let speeds = speeds(args.speed.as_deref().unwrap_or(usual))?;
    if args.figure_3_3 {
        return Ok(Case {
            title: format!("{FIGURE_3_3_MASS_KG} kg against a wall, Hunt-Crossley (figure 3.3)"),
            mass_kg: FIGURE_3_3_MASS_KG,
            laws: vec![(FIGURE_3_3.kind().name(), FIGURE_3_3)],
            speeds,
            rig: None,
        });
    }
    let rig = args.rig.load()?;
    args.output.doubt(&rig);
    let own = rig.params.contact;
    Ok(Case {
        title: format!(
            "{} kg against a wall, contact of rig {}",
            rig.params.mass_kg, rig.name
        ),
        mass_kg: rig.params.mass_kg,
        laws: match args.law {
            Which::All => all_laws(own),
            Which::Own => vec![(own.kind().name(), own)],
        },
        speeds,
        rig: Some(rig),
    })
}

fn speeds(text: &str) -> Result<Vec<f64>, UserError> {
    const SLOWEST: f64 = 1e-6;
    const FASTEST: f64 = 100.0;
    let bad = |what: String| UserError::new(format!("--speed {text}: {what}"));
    let speeds = range_or_value(text).map_err(bad)?;
    match speeds.iter().find(|v| !(SLOWEST..=FASTEST).contains(*v)) {
        Some(v) => Err(bad(format!(
            "{v:?} m/s is not a speed from {SLOWEST:?} to {FASTEST} m/s"
        ))),
        None if speeds.len() > 10_000 => Err(bad(format!(
            "that is {} speeds, more than 10000; use a larger STEP",
            speeds.len()
        ))),
        None => Ok(speeds),
    }
}

/// At most five of the speeds, spread evenly, the last among them.
fn some(speeds: &[f64]) -> Vec<f64> {
    let every = speeds.len().div_ceil(5);
    let mut kept: Vec<f64> = speeds.iter().rev().step_by(every).copied().collect();
    kept.reverse();
    kept
}

fn figure(case: &Case, all: &[ContactFigures]) -> Result<plot::Figure, UserError> {
    let mut at = String::new();
    let drawn: Vec<_> = match case.laws.as_slice() {
        [(_, law)] => some(&case.speeds)
            .into_iter()
            .map(|v| (format!("{v:.3} m/s"), *law, v))
            .collect(),
        laws => {
            let v = middle(&case.speeds);
            at = format!(", approach at {v:.3} m/s");
            let named = |(name, law): &(&str, Law<f64>)| ((*name).to_owned(), *law, v);
            laws.iter().map(named).collect()
        }
    };
    let [plane, force] = blows(case.mass_kg, &drawn)?;
    let mut panels = vec![
        plane.titled(format!("Phase plane{at}")),
        force.titled(format!("Contact force{at}")),
    ];
    if case.speeds.len() > 1 {
        panels.extend(over_speed(all));
    }
    let note = "Nothing but the wall acts on the mass. A contact pushes, never pulls: it ends where F falls to 0. Dashed: the law with its pull, until the penetration is 0.";
    Ok(grid(case.title.clone(), note.to_owned(), panels))
}

fn middle(speeds: &[f64]) -> f64 {
    speeds[speeds.len() / 2]
}

fn text(case: &Case, all: &[ContactFigures]) -> String {
    let mut text = format!(
        "{}\n\n  law                  speed, m/s  time, ms  restitution    peak, N  lost, mJ  imbalance  would pull\n",
        case.title
    );
    let every = case.speeds.len().div_ceil(8);
    for (i, row) in all.iter().enumerate() {
        // The speed that the picture shows is among those listed.
        let k = i % case.speeds.len();
        if !k.is_multiple_of(every) && k != case.speeds.len() / 2 {
            continue;
        }
        let pull = if row.pull_share > 0.0 {
            format!(
                "{:.0} % of its contact, up to {:.1} N; restitution {:.3} then",
                100.0 * row.pull_share,
                row.pull_n,
                row.pulling_restitution
            )
        } else {
            "never".to_owned()
        };
        text += &format!(
            "  {:<20} {:>10.4} {:>9.4} {:>12.4} {:>10.2} {:>9.4} {:>10.0e}  {pull}\n",
            row.law,
            row.approach_speed_m_per_s,
            row.contact_time_ms,
            row.restitution,
            row.force_n,
            row.energy_lost_j * 1e3,
            row.energy_imbalance.abs(),
        );
    }
    text += "\nImbalance: work of the contact force less the kinetic energy lost, over the energy at onset.\n";
    text += "Would pull: the law alone, if a contact did not end where its force falls to 0.\n";
    if every > 1 {
        text += "Some speeds are left out; --format csv gives all.\n";
    }
    text
}
