//! Sections 3.3.3 to 3.3.6 and 3.5: the hammer on wires, one motion at a time and over frequency.

use super::{ChapterVerdict, Statement};
use crate::figures::force_curves::curves;
use crate::figures::section::{SHOWN, Said, from_rest, rig};
use crate::figures::{Effort, bifurcation};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::PickLimits;
use numerics::branch::BranchEnd;
use numerics::pick::{PickAnswer, pick};
use numerics::poincare::portrait;
use numerics::sweep::jumps;
use shared::model::regime::Regime;

pub fn statements(_: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let mut all = modelling()?;
    all.extend(sections(progress)?);
    all.extend(bifurcations(progress)?);
    Ok(all)
}

fn modelling() -> Result<Vec<Statement>, UserError> {
    let length_m: f64 = 0.075;
    let hz = (9.81 / length_m).sqrt() / std::f64::consts::TAU;
    Ok(vec![
        Statement::new(
            "3.3.3, (3-15)",
            "\"no impact, i.e., l sin θ − gap > 0\"",
            "contact is where the penetration l sin θ − gap (3-17) is 0 or more; (3-21) and (3-22) say so, too: the sign is misprinted".into(),
            ChapterVerdict::Differs,
        ),
        Statement::new(
            "3.3.3, (3-16)",
            "torque of the contact: −F l",
            "it is −F l cos θ; used as printed, or corrected with --set torque=cosine".into(),
            ChapterVerdict::Differs,
        ),
        Statement::new(
            "3.3.3, Table 3.2",
            "natural frequency 1.82 Hz, wire length 75 mm",
            format!("a pendulum of {:.0} mm: {hz:.4} Hz", 1e3 * length_m),
            ChapterVerdict::of((hz - 1.82).abs() < 0.005),
        ),
        Statement::measured(
            "3.3.4, figures 3.12 to 3.14",
            "measured and computed force over frequency",
            "the measured points are not public",
        ),
    ])
}

fn sections(progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let mut all = Vec::new();
    for (figure, gap_mm, ratio, said) in SHOWN {
        let rig = rig("wires", gap_mm)?;
        let regime = portrait(&from_rest(&rig, ratio, 500, 100), progress)?.regime;
        let verdict = match (said.regime(), said) {
            (Some((p, n)), _) => ChapterVerdict::of(regime.is(p, n)),
            (None, Said::Nothing) => ChapterVerdict::CannotBeTold,
            // After a band's bifurcation neither band's motion is left.
            _ => ChapterVerdict::of(!regime.is(1, 1) && !regime.is(1, 2)),
        };
        let ours = format!("from rest z = {regime}");
        let section = format!("3.3.5, figure {figure}");
        let words = said.words(gap_mm, ratio);
        all.push(Statement::new(section, &words, ours, verdict));
    }
    all.push(Statement::measured(
        "3.3.5, figures 3.16 to 3.23",
        "\"good agreement\" with the measured curves",
        "they are not public",
    ));
    Ok(all)
}

/// The strongest 1/1 with the cart as prescribed and the parameters as printed.
pub(super) fn nominal(
    name: &str,
    gap_mm: f64,
    progress: &ProgressLine,
) -> Result<PickAnswer, UserError> {
    let rig = rig(name, gap_mm)?;
    Ok(pick(&rig, None, PickLimits::default(), progress)?.answer)
}

fn bifurcations(progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let zero = nominal("wires", 0.0, progress)?;
    let natural_hz = zero.operating_frequency_hz / zero.frequency_ratio;
    let doubles = zero.stable_one_one_ends[1] == BranchEnd::PeriodDoubling;
    let mut all = vec![Statement::new(
        "3.3.6, figure 3.27",
        "\"pitch-fork bifurcation (for gap 0.0 mm)\"",
        format!(
            "the 1/1 ends at Ω/ω = {:.4} by a {}; a pitchfork has the multiplier +1 and leaves two 1/1",
            zero.stable_one_one_hz[1] / natural_hz,
            if doubles {
                "period doubling: the multiplier is −1, and 2/2 follows"
            } else {
                "change that is no period doubling"
            }
        ),
        ChapterVerdict::Differs,
    )
    .shown_by("3.27, 3.28, 3.29, orbits at 0.0 mm")];
    for (gap_mm, section, words, shown_by) in [
        (
            1.0,
            "3.3.6, figure 3.30",
            "\"chaotic behavior\" at 1.0 mm",
            "3.30, 3.31, 3.32, orbits at 1.0 mm",
        ),
        (
            2.4,
            "3.3.6, figure 3.33",
            "\"chaotic behavior\" at 2.4 mm",
            "3.33, 3.34, 3.35, orbits at 2.4 mm",
        ),
    ] {
        let (end, chaos) = bifurcation::end_and_chaos(gap_mm, progress)?;
        let (ours, verdict) = match chaos {
            Some((ratio, meaning, exponent)) => (
                format!(
                    "from rest the 1/1 ends at Ω/ω = {end:.3}; at {ratio:.2} the largest Lyapunov exponent is {exponent:+.2} per drive period ({meaning})"
                ),
                ChapterVerdict::of(meaning == "chaotic"),
            ),
            None => (
                format!("the 1/1 ends at Ω/ω = {end:.3}; every motion repeats"),
                ChapterVerdict::Differs,
            ),
        };
        all.push(Statement::new(section, words, ours, verdict).shown_by(shown_by));
    }
    Ok(all)
}

/// Section 3.5: what is recommended, and why.
pub fn conclusion(_: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let gaps = [0.0, 1.0, 2.4];
    let picks = gaps.map(|gap| nominal("wires", gap, progress));
    let [zero, one, two] = picks;
    let (zero, one, two) = (zero?, one?, two?);
    let curves = curves(&["wires"], &gaps, (0.6, 5.0), Effort::Full, progress)?;
    let apart = |k: usize| {
        let c = &curves[k];
        jumps(&c.up, &c.down, c.params.weight_n(), 0.1).len()
    };
    let width = |a: &PickAnswer| 100.0 * (a.band_hz[1] - a.band_hz[0]) / a.operating_frequency_hz;
    let less = |a: &PickAnswer| a.force_ratio / a.force_ratio_at_natural_frequency;
    let at_natural = [&zero, &one, &two].map(less);
    let (least, most) = (
        zero.force_ratio.min(one.force_ratio).min(two.force_ratio),
        zero.force_ratio.max(one.force_ratio).max(two.force_ratio),
    );
    let force_same = least > 0.9 * most;
    let wider = width(&zero) > width(&one).max(width(&two));
    let still = apart(0) == 0 && zero.jump_free;
    Ok(vec![
        Statement::new(
            "3.3.6, figure 3.26",
            "at the natural frequency \"3 times smaller in magnitude than the maximum force\"",
            format!(
                "largest 1/1 force over that at the natural frequency: {:.2} at 0.0 mm ({:.1} and {:.1} m g), {:.2} at 1.0, {:.2} at 2.4; 3 to a whole number at {} of the three gaps",
                at_natural[0],
                zero.force_ratio,
                zero.force_ratio_at_natural_frequency,
                at_natural[1],
                at_natural[2],
                at_natural.iter().filter(|x| x.round() == 3.0).count()
            ),
            ChapterVerdict::of(at_natural.iter().all(|x| x.round() == 3.0)),
        ),
        Statement::new(
            "3.3.6 and 3.5",
            "force at 0.0 mm \"in the same range\" as at higher gaps",
            format!(
                "largest 1/1 force at 0.0, 1.0, 2.4 mm: {:.1}, {:.1}, {:.1} m g",
                zero.force_ratio, one.force_ratio, two.force_ratio
            ),
            ChapterVerdict::of(force_same),
        )
        .shown_by("conclusion"),
        Statement::new(
            "3.3.6 and 3.5",
            "\"non-zero gap values are known to present nonlinear jumps\"",
            format!(
                "carried up and down differ by more than 10 % of force at {} of {} frequencies at 1.0 mm and at {} at 2.4 mm",
                apart(1),
                curves[1].up.len(),
                apart(2)
            ),
            ChapterVerdict::of(apart(1) > 0 && apart(2) > 0),
        )
        .shown_by("conclusion, 3.13, 3.14"),
        Statement::new(
            "3.5",
            "nonlinear jump \"is not the case for the 0.0 mm gap\"",
            format!(
                "at 0.0 mm at {} of {} frequencies",
                apart(0),
                curves[0].up.len()
            ),
            ChapterVerdict::of(still),
        )
        .shown_by("conclusion, 3.12"),
        Statement::new(
            "3.5",
            "at 0.0 mm about the maximum force \"for a wider frequency range\"",
            format!(
                "1/1 with 90 % of the force or more, over the frequency: {:.1} % at 0.0 mm, {:.1} % at 1.0, {:.1} % at 2.4",
                width(&zero),
                width(&one),
                width(&two)
            ),
            ChapterVerdict::of(wider),
        )
        .shown_by("conclusion"),
        Statement::new(
            "3.3.6 and 3.5",
            "\"recommended to operate with 0.0 mm gap\"",
            "as the four lines above".into(),
            ChapterVerdict::of(
                force_same
                    && still
                    && wider
                    && zero.regime
                        == Regime::Periodic {
                            impacts: 1,
                            periods: 1,
                        },
            ),
        )
        .shown_by("conclusion"),
        Statement::measured(
            "3.5",
            "comparison with the experiment \"satisfactory\" in both rigs",
            "the measurements are not public",
        ),
    ])
}
