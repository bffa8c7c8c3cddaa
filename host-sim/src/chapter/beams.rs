//! Sections 3.4.1 to 3.4.3: the hammer on beam springs.

use super::{ChapterVerdict, Statement};
use crate::figures::Effort;
use crate::figures::force::strongest;
use crate::figures::force_curves::{SweepCurves, curves};
use crate::figures::modes::{ModesChange, change_over};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::NamedRig;
use numerics::sweep::jumps;

/// The figures of the bending modes.
const PICTURES: &str = "modes 170, modes 150, modes 135, modes mass";

const RIGS: [&str; 3] = ["beam-170", "beam-150", "beam-135"];

pub fn statements(effort: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let mut all = modelling()?;
    all.extend(force(progress)?);
    all.extend(modes(effort, progress)?);
    Ok(all)
}

fn modelling() -> Result<Vec<Statement>, UserError> {
    let mut all = vec![
        Statement::new(
            "3.4.1, (3-30)",
            "\"no impact, i.e., x − (y + gap) > 0\"",
            "contact is where this, the penetration (3-33), is 0 or more: the sign is misprinted"
                .into(),
            ChapterVerdict::Differs,
        ),
        Statement::new(
            "3.4.1, (3-35)",
            "h_α = A0 sin(Ωt) + gap",
            "the penetration is x − y − gap (3-33)".into(),
            ChapterVerdict::Differs,
        ),
    ];
    for (name, printed, words) in [
        ("beam-170", 0.06, "damping coefficient 0.06 Ns/m (170 mm)"),
        ("beam-150", 0.08, "damping coefficient 0.08 Ns/m (150 mm)"),
        ("beam-135", 0.09, "damping coefficient 0.09 Ns/m (135 mm)"),
    ] {
        let params = NamedRig::preset(name)?.params;
        let omega = std::f64::consts::TAU * params.natural_frequency_hz();
        let c: f64 = 2.0 * 0.004 * params.mass_kg * omega;
        all.push(Statement::new(
            "3.4.1, Table 3.3",
            words,
            format!("2 ζ m ω with the table's ζ = 0.004: {c:.4} N·s/m"),
            ChapterVerdict::of((c - printed).abs() < 0.005),
        ));
    }
    Ok(all)
}

fn force(progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let curves = curves(&RIGS, &[0.0, 1.0, 3.0], (0.6, 4.0), Effort::Full, progress)?;
    let jumping = |c: &SweepCurves| {
        let apart = jumps(&c.up, &c.down, c.params.weight_n(), 0.1);
        let natural = c.params.natural_frequency_hz();
        let ends = apart.first().zip(apart.last());
        ends.map(|(a, b)| (apart.len(), a / natural, b / natural))
    };
    let words = |found: Option<(usize, f64, f64)>| match found {
        Some((n, low, high)) => {
            format!("carried up and down differ at {n} frequencies, Ω/ω {low:.2} to {high:.2}")
        }
        None => "carried up and down agree everywhere".to_owned(),
    };
    let best = |c: &SweepCurves| strongest(&c.up).map_or(0.0, |row| row.force_ratio);
    let [zero, one, three] = [0, 1, 2].map(|k| best(&curves[k]));
    Ok(vec![
        Statement::new(
            "3.4.2, figure 3.40c",
            "\"the presence of the nonlinear jump, for the 3.0 mm gap\" (170 mm)",
            words(jumping(&curves[2])),
            ChapterVerdict::of(jumping(&curves[2]).is_some()),
        ),
        Statement::measured(
            "3.4.2, figure 3.40",
            "\"captures well the maximum impact force\" (170 mm)",
            format!(
                "computed, carried up: {zero:.1}, {one:.1}, {three:.1} m g at 0.0, 1.0, 3.0 mm; the measured is not public"
            ),
        ),
        Statement::new(
            "3.4.2, figure 3.40b",
            "force at 1.0 mm expected \"in between 0.0 mm and 3.0 mm gap\"",
            format!("largest 1/1 force, carried up: {zero:.1}, {one:.1}, {three:.1} m g"),
            ChapterVerdict::of((zero.min(three)..=zero.max(three)).contains(&one)),
        ),
        Statement::measured(
            "3.4.2, figure 3.41c",
            "jump detected \"with a 10 % error in frequency\" (150 mm)",
            words(jumping(&curves[5])),
        ),
        Statement::measured(
            "3.4.2, figures 3.41 and 3.42",
            "agreement up to twice the natural frequency, or \"up to a non-dimensional frequency of 1.7\"",
            "needs the measured force",
        ),
    ])
}

fn modes(effort: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let changes = RIGS.map(|rig| change_over(rig, effort, progress));
    let [a, b, c] = changes;
    let changes: [ModesChange; 3] = [a?, b?, c?];
    let list = |of: fn(&ModesChange) -> f64| {
        changes
            .iter()
            .map(|c| format!("{:+.1} %", of(c)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let swing = list(|c| c.swing_percent);
    let force = list(|c| c.force_percent);
    let spread = changes.iter().map(|c| c.spread_mm).fold(0.0, f64::max);
    let falls = changes.iter().all(|c| c.swing_percent < -1.0);
    let steady = changes
        .iter()
        .all(|c| c.force_percent.abs() < 0.5 * c.swing_percent.abs());
    let grows = changes
        .windows(2)
        .all(|w| w[1].swing_percent < w[0].swing_percent - 0.1);
    Ok(vec![
        Statement::measured(
            "3.4.3, figures 3.43 to 3.45",
            "simulated amplitude \"always higher than the experimental data\"",
            "needs the measured displacement",
        ),
        Statement::new(
            "3.4.3 and 3.5",
            "cause: \"only the first bending vibration mode\" is modelled",
            format!(
                "from one mode to five the swing changes by {swing} (170, 150, 135 mm; medians, springs of 0.1 of the hammer's mass assumed)"
            ),
            ChapterVerdict::of(falls),
        )
        .shown_by(PICTURES),
        Statement::new(
            "3.4.3 and 3.5",
            "amplitude too high \"even when the impact force is presenting equivalent values\"",
            format!("the force changes by {force}, the swing by {swing}"),
            ChapterVerdict::of(falls && steady),
        )
        .shown_by(PICTURES),
        Statement::new(
            "3.4.3 and 3.5",
            "\"dispersion of the experimental points\" in steady motion, from the modes",
            format!("with five modes the section of a 1/1 spreads over {spread:.4} mm at most"),
            ChapterVerdict::of(spread > 0.01),
        )
        .shown_by(PICTURES),
        Statement::new(
            "3.4.3 and 3.5",
            "the difference is \"higher as the beam springs stiffness increases\"",
            format!("change of the swing: {swing} from soft to stiff"),
            ChapterVerdict::of(grows),
        )
        .shown_by(PICTURES),
    ])
}
