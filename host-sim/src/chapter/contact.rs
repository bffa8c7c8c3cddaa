//! Sections 3.1 to 3.3.2: contact laws, the switch, the impact's parameters.

use shared::model::contact::{Law, LawKind, TABLE_3_1};

use super::{ChapterVerdict, Statement};
use crate::figures::Effort;
use crate::figures::section::{from_rest, rig};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::contact_law::{ContactFigures, FIGURE_3_3, FIGURE_3_3_MASS_KG, rows};
use numerics::poincare::against;

/// The hammer's mass and its approach speed in a drop from 3 mm, about.
const MASS_KG: f64 = 0.298;
const SPEED: f64 = 0.08;

pub fn statements(effort: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let mut all = laws()?;
    all.extend(smoothing(effort, progress)?);
    all.extend(identified()?);
    Ok(all)
}

fn one(law: Law<f64>) -> Result<ContactFigures, UserError> {
    let mut seen = rows("", law, MASS_KG, &[SPEED])?;
    seen.pop()
        .ok_or_else(|| UserError::new("a contact that was asked for was not made"))
}

fn laws() -> Result<Vec<Statement>, UserError> {
    let hertz = one(LawKind::Hertz.preset())?;
    let dashpot = one(TABLE_3_1)?;
    let onset = TABLE_3_1.onset_force(SPEED);
    let speeds = [0.1, 0.3, 0.5];
    let crossley = rows("", FIGURE_3_3, FIGURE_3_3_MASS_KG, &speeds)?;
    let never_pulls = crossley.iter().all(|row| row.pull_n == 0.0);
    let given = 0.3;
    let lankarani = one(Law::LankaraniNikravesh {
        stiffness: LawKind::LankaraniNikravesh.preset().stiffness(),
        exponent: 1.5,
        restitution: given,
    })?;
    Ok(vec![
        Statement::new(
            "3.1.2, Hertz",
            "\"its equivalent coefficient of restitution is 1\"",
            format!("restitution {:.4} at {SPEED} m/s", hertz.restitution),
            ChapterVerdict::of((hertz.restitution - 1.0).abs() < 1e-4),
        )
        .shown_by("contact laws"),
        Statement::new(
            "3.1.2, figure 3.2, point A",
            "force at the beginning \"is discontinuous, because of the damping term\"",
            format!(
                "Table 3.1 at {SPEED} m/s: the force begins at {onset:.1} N; its peak is {:.1} N",
                dashpot.force_n
            ),
            ChapterVerdict::of(onset > 0.1 * dashpot.force_n),
        ),
        Statement::new(
            "3.1.2, figure 3.2, point B",
            "\"a negative force is present that holds the objects\"",
            format!(
                "the law alone would pull with up to {:.1} N over {:.0} % of its contact (here a contact is let go at F = 0: restitution {:.3}, not {:.3})",
                dashpot.pull_n,
                100.0 * dashpot.pull_share,
                dashpot.restitution,
                dashpot.pulling_restitution
            ),
            ChapterVerdict::of(dashpot.pull_n > 0.0),
        ),
        Statement::new(
            "3.1.2, Hunt and Crossley",
            "force \"begins and ends with the correct value of zero\"",
            format!(
                "figure 3.3's law from {} to {} m/s: no pull at any speed, restitution {:.3} to {:.3}",
                speeds[0], speeds[2], crossley[0].restitution, crossley[2].restitution
            ),
            ChapterVerdict::of(never_pulls),
        )
        .shown_by("3.3"),
        Statement::measured(
            "3.1.2, figure 3.3",
            "\"for different velocities before impact\"",
            "the speeds are not printed, so no curve can be compared by itself",
        ),
        Statement::new(
            "3.1.2, Lankarani, (3-5)",
            "e is \"Newton's coefficient of restitution\"",
            format!(
                "given e = {given}, the law rebounds at {:.3} of the approach speed (at e = 0 at 0.66): it is not e",
                lankarani.restitution
            ),
            ChapterVerdict::of((lankarani.restitution - given).abs() < 0.05),
        )
        .shown_by("contact laws"),
    ])
}

fn smoothing(effort: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let rig = rig("wires", 1.0)?;
    let (points, widths) = effort.of((4000, 3), (300, 1));
    let request = from_rest(&rig, 2.7, 200, points);
    let found = against::against(&request, &against::WIDTHS_M[..widths], progress)?;
    let steps = found.smoothed.iter().map(|s| s.summary.steps_per_period);
    let most = steps.fold(0.0, f64::max);
    let carried = found.smoothed.iter().map(|s| s.summary.carried);
    let least = carried.fold(f64::INFINITY, f64::min);
    let switch = found.summary.steps_per_period;
    Ok(vec![
        Statement::new(
            "3.2.2",
            "the smoothing method \"yields stiff differential equations\"",
            format!(
                "wires, 1.0 mm, Ω/ω = 2.7: up to {most:.0} steps per drive period, the switch {switch:.0}"
            ),
            ChapterVerdict::of(most > 1.5 * switch),
        )
        .shown_by("3.4"),
        Statement::new(
            "3.2.2, figure 3.4",
            "in chaos \"the results using the smoothing method will probably be incorrect\"",
            format!(
                "there the clouds lie at least {least:.3} A0 from the switch's; two runs of the switch {:.4} A0 apart",
                found.again.carried
            ),
            ChapterVerdict::of(least > 3.0 * found.again.carried),
        ),
    ])
}

fn identified() -> Result<Vec<Statement>, UserError> {
    let table = one(TABLE_3_1)?;
    let hertz = one(LawKind::Hertz.preset())?;
    Ok(vec![
        Statement::measured(
            "3.3.2, figure 3.8",
            "\"no difference in the profiles of impact force and acceleration\"",
            "a measurement; here the hammer is rigid by assumption",
        ),
        Statement::measured(
            "3.3.2",
            "oscillation \"within the 3 kHz range\" from the cart's surface",
            "a measurement; the emulator's force sensor rings so, the model does not",
        )
        .shown_by("3.8"),
        Statement::new(
            "3.3.2",
            "Hertz discarded: \"does not take into account any loss of energy\"",
            format!(
                "energy lost per contact {:.1e} of what came in",
                (hertz.energy_lost_j / hertz.energy_in_j).abs()
            ),
            ChapterVerdict::of((hertz.energy_lost_j / hertz.energy_in_j).abs() < 1e-3),
        )
        .shown_by("contact laws"),
        Statement::measured(
            "3.3.2",
            "the spring-dashpot \"generated the best results\"",
            "needs the measured drop tests",
        )
        .shown_by("3.9, 3.10"),
        Statement::measured(
            "3.3.2, Table 3.1",
            "ki 5.5·10⁶ N/m, ci 1.2·10³ Ns/m",
            format!(
                "the value used; it means contacts of {:.3} ms and restitution {:.3}",
                table.contact_time_ms, table.restitution
            ),
        )
        .shown_by("3.9, 3.10"),
    ])
}
