//! Beyond the chapter: the beam springs with more than one bending mode.

use super::{Effort, Page};
use crate::progress::ProgressLine;
use files::UserError;
use files::rigfile;
use numerics::NamedRig;
use numerics::engine::Plan as Cycles;
use numerics::modes::{Beam, ModesRequest, ModesRow, TipJoint};
use plot::{Axis, Color, Figure, Item, Panel};

/// Numbers of modes compared.
const COUNTS: [usize; 4] = [1, 2, 3, 5];
/// The fewest and the most of them.
const ENDS: [usize; 2] = [1, 5];

/// Springs' mass over the hammer's, as assumed where nothing else is said.
const MASS_RATIO: f64 = 0.1;

/// Step of the frequency ratio, and cycles.
fn resolution(effort: Effort) -> (f64, Cycles) {
    let (step, cycles) = effort.of((0.04, 400), (0.5, 120));
    let transient = cycles - 60;
    (step, Cycles { cycles, transient })
}

/// Each beam over frequency.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn beams(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let (step, cycles) = resolution(effort);
    let mut pages = Vec::new();
    for (beam, name, title) in [
        ("beam-170", "modes 170", "170"),
        ("beam-150", "modes 150", "150"),
        ("beam-135", "modes 135", "135"),
    ] {
        let rig = rigfile::load(beam, &[])?;
        let count = (1.6 / step) as usize;
        let natural = rig.params.natural_frequency_hz();
        let hz = (0..=count).map(|i| (1.0 + i as f64 * step) * natural);
        let hz: Vec<f64> = hz.collect();
        let rows = rows(&rig, assumed(MASS_RATIO), &COUNTS, &hz, cycles, progress)?;
        let title = format!("Bending modes, couplings {title} mm apart, gap 0.0 mm");
        let figure = over_frequency(&title, &rows);
        let command =
            format!("host-sim modes --rig {beam} --cart prescribed --ratio 1:2.6:0.04 --out DIR");
        pages.push(Page::new(name, title, command, &figure)?.table("", &rows));
    }
    Ok(pages)
}

fn assumed(mass_ratio: f64) -> Beam {
    Beam {
        tip: TipJoint::Guided,
        mass_ratio,
    }
}

fn rows(
    rig: &NamedRig,
    beam: Beam,
    counts: &[usize],
    frequencies_hz: &[f64],
    cycles: Cycles,
    progress: &ProgressLine,
) -> Result<Vec<ModesRow>, UserError> {
    let plan = ModesRequest {
        rig,
        beam,
        counts,
        frequencies_hz,
        cycles,
    };
    Ok(plan.run(progress)?)
}

/// How many modes, in words.
pub fn in_words(count: usize) -> String {
    match count {
        1 => "1 mode".into(),
        _ => format!("{count} modes"),
    }
}

fn over_frequency(title: &str, rows: &[ModesRow]) -> Figure {
    let panel = |axis: &str, column: fn(&ModesRow) -> f64| {
        let x = Axis::new("drive frequency over the first mode's");
        let mut panel = Panel::new(x, Axis::new(axis).with_zero());
        for (i, count) in COUNTS.into_iter().enumerate() {
            let rows = rows.iter().filter(|row| row.modes == count);
            let points = rows.map(|r| (r.frequency_ratio, column(r))).collect();
            panel = panel.item(Item::line(in_words(count), Color::series(i), points));
        }
        panel
    };
    Figure::new(title)
        .subtitle(format!(
            "From rest. Springs of {MASS_RATIO} times the hammer's mass, tip guided. Swing: largest less least displacement in the fixed frame."
        ))
        .size(1000, 1150)
        .panel(panel("largest force, N", |row| row.force_n))
        .panel(panel("swing, mm", |row| row.swing_mm).without_legend())
        .panel(
            panel("energy not in mode 1, %", |row| {
                100.0 * row.higher_energy_share
            })
            .without_legend(),
        )
}

/// Pairs of rows at the same frequency, with the most modes and with one, where both are 1/1.
fn pairs(rows: &[ModesRow]) -> Vec<(&ModesRow, &ModesRow)> {
    let most = COUNTS[COUNTS.len() - 1];
    rows.chunk_by(|a, b| a.frequency_hz == b.frequency_hz)
        .filter_map(|same| {
            let of = |count| same.iter().find(|row| row.modes == count);
            Some((of(most)?, of(1)?))
        })
        .filter(|(a, b)| a.regime.is(1, 1) && b.regime.is(1, 1))
        .collect()
}

/// Median change in percent of a column from one mode to the most.
fn change(pairs: &[(&ModesRow, &ModesRow)], column: fn(&ModesRow) -> f64) -> f64 {
    let ratios = pairs.iter().map(|(a, b)| column(a) / column(b) - 1.0);
    100.0 * median(ratios.collect())
}

/// The one in the middle; of none, not a number.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// What five modes change against one over the frequencies at which both are 1/1.
pub struct ModesChange {
    /// Median change of the largest force, %.
    pub force_percent: f64,
    /// Median change of the swing, %.
    pub swing_percent: f64,
    /// How far the section of a 1/1 with five modes spreads at most, mm.
    pub spread_mm: f64,
}

/// The change on a beam rig, with the assumed mass of its springs.
///
/// # Errors
/// If a motion cannot be followed.
pub fn change_over(
    beam: &str,
    effort: Effort,
    progress: &ProgressLine,
) -> Result<ModesChange, UserError> {
    let rig = rigfile::load(beam, &[])?;
    let count: u32 = effort.of(80, 40);
    let natural = rig.params.natural_frequency_hz();
    let hz = (0..=count).map(|i| natural * (1.0 + 1.6 * f64::from(i) / f64::from(count)));
    let hz: Vec<f64> = hz.collect();
    let (_, cycles) = resolution(Effort::Full);
    let rows = rows(&rig, assumed(MASS_RATIO), &ENDS, &hz, cycles, progress)?;
    let pairs = pairs(&rows);
    let spread = pairs.iter().map(|(a, _)| a.section_spread_mm);
    Ok(ModesChange {
        force_percent: change(&pairs, |row| row.force_n),
        swing_percent: change(&pairs, |row| row.swing_mm),
        spread_mm: spread.fold(0.0, f64::max),
    })
}

/// Force and swing with five modes over those with one, for springs of other masses.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn mass(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let (curves, all) = mass_curves(effort, progress)?;
    let title = "How much the assumed mass of the beam springs matters";
    let figure = Figure::new(title)
        .subtitle("Couplings 170 mm apart, gap 0.0 mm, median over the frequencies from 1.2 to 2.6 times the first mode's at which both are 1/1.")
        .panel(mass_panel(&curves));
    let ends = |curve: &[(f64, f64)]| match (curve.first(), curve.last()) {
        (Some(a), Some(b)) => format!("{:+.1} % at {} to {:+.1} % at {}", a.1, a.0, b.1, b.0),
        _ => "no 1/1".into(),
    };
    let found = curves.iter().map(|curve| {
        let tip = match curve.tip {
            TipJoint::Guided => "guided",
            TipJoint::Free => "free",
        };
        format!(
            "tip {tip}: force {}, swing {}",
            ends(&curve.force),
            ends(&curve.swing)
        )
    });
    let page = Page::new(
        "modes mass",
        title,
        "host-sim modes --rig beam-170 --cart prescribed --ratio 1.2:2.6:0.02 --modes 1,5 --springs-mass 0.3",
        &figure,
    )?;
    Ok(vec![page.table("", &all).noted(format!(
        "The chapter gives no dimensions of the springs. Five modes against one: {}.",
        found.collect::<Vec<_>>().join("; ")
    ))])
}

/// Change from one mode to five, %, over the mass of the springs over the hammer's.
struct MassCurves {
    tip: TipJoint,
    force: Vec<(f64, f64)>,
    swing: Vec<(f64, f64)>,
}

/// The curves of both tips, and every row they come from.
fn mass_curves(
    effort: Effort,
    progress: &ProgressLine,
) -> Result<(Vec<MassCurves>, Vec<ModesRow>), UserError> {
    let (_, cycles) = resolution(effort);
    const MASSES: [f64; 8] = [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5];
    let (count, masses) = effort.of((35u32, &MASSES[..]), (4, &[0.05, 0.3][..]));
    let rig = rigfile::load("beam-170", &[])?;
    let natural = rig.params.natural_frequency_hz();
    let (mut curves, mut all) = (Vec::new(), Vec::new());
    for tip in [TipJoint::Guided, TipJoint::Free] {
        let (mut force, mut swing) = (Vec::new(), Vec::new());
        for mass_ratio in masses {
            let beam = Beam {
                tip,
                mass_ratio: *mass_ratio,
            };
            let hz = (0..=count).map(|i| natural * (1.2 + 1.4 * f64::from(i) / f64::from(count)));
            let hz: Vec<f64> = hz.collect();
            let rows = rows(&rig, beam, &ENDS, &hz, cycles, progress)?;
            let pairs = pairs(&rows);
            if !pairs.is_empty() {
                force.push((*mass_ratio, change(&pairs, |row| row.force_n)));
                swing.push((*mass_ratio, change(&pairs, |row| row.swing_mm)));
            }
            all.extend(rows);
        }
        curves.push(MassCurves { tip, force, swing });
    }
    Ok((curves, all))
}

fn mass_panel(curves: &[MassCurves]) -> Panel {
    let panel = Panel::new(
        Axis::new("springs' mass over the hammer's").with_zero(),
        Axis::new("five modes against one, %").with_zero(),
    );
    curves.iter().enumerate().fold(panel, |panel, (i, curve)| {
        let tip = match curve.tip {
            TipJoint::Guided => "tip guided",
            TipJoint::Free => "tip free to turn",
        };
        panel
            .item(Item::line(
                format!("force, {tip}"),
                Color::series(2 * i),
                curve.force.clone(),
            ))
            .item(Item::dashed(
                format!("swing, {tip}"),
                Color::series(2 * i + 1),
                curve.swing.clone(),
            ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_beam_has_its_page_and_names_are_unique() {
        let progress = ProgressLine::new("figures", 0, true);
        let mut pages = beams(Effort::Coarse, &progress).unwrap();
        pages.extend(mass(Effort::Coarse, &progress).unwrap());
        assert_eq!(pages.len(), 4);
        let mut names: Vec<_> = pages
            .iter()
            .flat_map(|p| &p.files)
            .map(|(n, _)| n)
            .collect();
        assert_eq!(names.len(), 12);
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 12);
        assert!(names.iter().all(|name| name.starts_with("figure-modes-")));
        assert!(pages.iter().all(|page| !page.note.contains("NaN")));
    }
}
