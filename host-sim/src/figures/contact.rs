//! Figures 3.3 (impacts of a mass on a wall), 3.9 and 3.10 (contact parameters from drop tests), and the contact laws over
//! approach speed.

use shared::model::contact::{LawKind, TABLE_3_1};
use shared::model::params::{RigParams, WIRES};

use super::{Effort, Page};
use crate::pictures;
use crate::pictures::contact_law::{blows, grid, over_speed};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::contact_law::{ContactFigures, FIGURE_3_3, FIGURE_3_3_MASS_KG, all_laws, rows};
use numerics::drop_test::{DropTest, record};
use numerics::identify::{IdentifiedFit, MeasuredImpacts, Misfit, SearchSettings, fit, measure};
use numerics::signal::Signal;
use plot::Figure;

/// Figures 3.2 and 3.3, and the contact laws beside each other.
///
/// # Errors
/// If a picture cannot be drawn.
pub fn law_pages(_: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let pages = vec![figure_3_2()?, figure_3_3()?, laws()?];
    progress.inc(1);
    Ok(pages)
}

/// Figures 3.9 and 3.10: the drop tests.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn drop_pages(_: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let first = std::iter::once(figure_3_8());
    let pages = first.chain(TESTS.iter().map(drop_page)).collect();
    progress.inc(1);
    pages
}

/// The force of the spring-dashpot over an impact, which the chapter draws by hand.
fn figure_3_2() -> Result<Page, UserError> {
    let seen = rows("spring-dashpot", TABLE_3_1, WIRES.mass_kg, &[USUAL_SPEED])?;
    let drawn = ("spring-dashpot".to_owned(), TABLE_3_1, USUAL_SPEED);
    let figure = grid(
        "Spring-dashpot: force over an impact".into(),
        format!(
            "The hammer's mass at {USUAL_SPEED} m/s, Table 3.1. Dashed: what the law would do if it could pull, to where the indentation is 0."
        ),
        blows(WIRES.mass_kg, &[drawn])?,
    );
    let page = Page::new(
        "3.2",
        "Spring-dashpot: the force over an impact",
        "host-sim contact --law own --speed 0.08:0.08:0.01",
        &figure,
    )?;
    Ok(page.table("", &seen))
}

/// Force and acceleration of a first impact, which the chapter measured: a synthetic one.
fn figure_3_8() -> Result<Page, UserError> {
    let test = DropTest {
        impacts: 1,
        ringing_share: 0.5,
        ..DropTest::default()
    };
    let rows = record(&WIRES, &test)?;
    let onset = rows.iter().find(|row| row.force_n > 1.0);
    let onset_s = onset.map_or(0.0, |row| row.time_s);
    let near = rows
        .iter()
        .filter(|row| (-5e-4..4e-3).contains(&(row.time_s - onset_s)));
    let near: Vec<_> = near.collect();
    let over = |axis: &str, of: fn(&numerics::drop_test::DropSample) -> f64| {
        let points = near
            .iter()
            .map(|row| ((row.time_s - onset_s) * 1e3, of(row)));
        let x = plot::Axis::new("time since the onset, ms");
        plot::Panel::new(x, plot::Axis::new(axis).with_zero())
            .without_legend()
            .item(plot::Item::line(axis, plot::Color::BLUE, points.collect()))
    };
    let title = "First impact of a drop test: force and acceleration";
    let figure = Figure::new(title)
        .subtitle("Synthetic: wires, let go at -3 mm, Table 3.1, the surface ringing at 3 kHz with half the peak. Not measured.")
        .columns(2)
        .size(1200, 560)
        .panel(over("force, N", |row| row.force_n))
        .panel(over("acceleration, m/s²", |row| row.acceleration_m_per_s2));
    let command = "host-sim drop --impacts 1 --ringing 0.5";
    Ok(Page::new("3.8", title, command, &figure)?.table("", &rows))
}

/// Assumed, as the chapter does not print the speeds of its curves.
const SPEEDS_3_3: [f64; 5] = [0.1, 0.2, 0.3, 0.4, 0.5];

fn figure_3_3() -> Result<Page, UserError> {
    let seen = rows("hunt-crossley", FIGURE_3_3, FIGURE_3_3_MASS_KG, &SPEEDS_3_3)?;
    let blows_drawn: Vec<_> = SPEEDS_3_3
        .iter()
        .map(|v| (format!("{v} m/s"), FIGURE_3_3, *v))
        .collect();
    let figure = grid(
        "Rigid mass on a wall, Hunt-Crossley, several approach speeds".into(),
        "m = 2 kg, ki = 2.1e8, n = 1.6, λ = 0.6 s/m. Onset is at the top of the phase plane, release at its bottom.".into(),
        blows(FIGURE_3_3_MASS_KG, &blows_drawn)?,
    );
    let title = "Impact of a rigid mass on a rigid wall, Hunt-Crossley";
    Ok(Page::new("3.3", title, "host-sim contact --figure-3-3", &figure)?.table("", &seen))
}

/// A typical approach speed of the rig.
const USUAL_SPEED: f64 = 0.08;

fn laws() -> Result<Page, UserError> {
    let speeds: Vec<f64> = (1..=30).map(|i| f64::from(i) * 0.01).collect();
    let laws = all_laws(TABLE_3_1);
    let mut seen: Vec<ContactFigures> = Vec::new();
    for (name, law) in &laws {
        seen.extend(rows(name, *law, WIRES.mass_kg, &speeds)?);
    }
    let blows_drawn: Vec<_> = laws
        .iter()
        .map(|(name, law)| ((*name).to_owned(), *law, USUAL_SPEED))
        .collect();
    let mut panels = blows(WIRES.mass_kg, &blows_drawn)?.to_vec();
    panels.extend(over_speed(&seen));
    let figure = grid(
        "The rig's hammer on a wall under each contact law".into(),
        format!(
            "0.298 kg; above at {USUAL_SPEED} m/s. The spring-dashpot is Table 3.1's, the others are made for the same contact as far as they can. Dashed: if the law could pull."
        ),
        panels,
    );
    let page = Page::new(
        "contact laws",
        "The contact laws: force, pull, restitution over speed",
        "host-sim contact --speed 0.01:0.3:0.01",
        &figure,
    )?;
    Ok(page.table("", &seen))
}

/// Number, release in mm, seed of the two drop tests. The chapter releases at "3 mm (approximately)", and once more
/// at a displacement that it does not print.
const TESTS: [(&str, f64, u64); 2] = [("3.9", -3.0, 39), ("3.10", -2.0, 310)];

/// The noise of the synthetic records, N.
const NOISE_N: f64 = 0.1;

fn drop_page(&(number, release_mm, seed): &(&'static str, f64, u64)) -> Result<Page, UserError> {
    let test = DropTest {
        release_m: release_mm * 1e-3,
        noise_n: NOISE_N,
        ringing_share: 0.5,
        seed,
        ..DropTest::default()
    };
    let settings = SearchSettings {
        release_m: test.release_m,
        impacts: test.impacts,
        ..SearchSettings::DEFAULT
    };
    let measured = synthetic(&WIRES, &test, &settings)?;
    let law = LawKind::SpringDashpot;
    let peaks = fit(&measured, &WIRES, law, Misfit::Peaks, &settings)?;
    let force = fit(&measured, &WIRES, law, Misfit::Force, &settings)?;
    let calm = DropTest {
        ringing_share: 0.0,
        ..test
    };
    let calm = synthetic(&WIRES, &calm, &settings)?;
    let calm = fit(&calm, &WIRES, law, Misfit::Peaks, &settings)?;
    let note = found(&peaks, &force, &calm);
    let impacts = peaks.impacts.clone();
    let figure = pictures::identify::figure(
        format!("Drop test from {release_mm} mm, spring-dashpot"),
        format!(
            "The \"measurement\" is synthetic: the model with Table 3.1, noise {NOISE_N} N, and the surface ringing at 3 kHz with half the peak. The chapter's raw data are not public."
        ),
        &measured,
        &[peaks, force],
    );
    let page = Page::new(
        number,
        format!("Contact parameters from a drop test, let go at {release_mm} mm"),
        format!(
            "host-sim drop --release-mm {release_mm} --noise-n {NOISE_N} --ringing 0.5 --seed {seed} --format csv > drop.csv; host-sim identify drop.csv"
        ),
        &figure,
    )?;
    Ok(page.table("", &impacts).noted(note))
}

fn synthetic(
    params: &RigParams,
    test: &DropTest,
    settings: &SearchSettings,
) -> Result<MeasuredImpacts, UserError> {
    let rows = record(params, test)?;
    let signal = Signal {
        name: "synthetic drop test".into(),
        time_s: rows.iter().map(|r| r.time_s).collect(),
        force_n: Some(rows.iter().map(|r| r.force_n).collect()),
        ..Signal::default()
    };
    Ok(measure(&signal, settings)?)
}

fn found(peaks: &IdentifiedFit, force: &IdentifiedFit, calm: &IdentifiedFit) -> String {
    let put_in = [5.5e6, 1.2e3];
    let off = |fit: &IdentifiedFit, i: usize| 100.0 * (fit.parameters[i].value / put_in[i] - 1.0);
    let worst = (0..2).fold(0.0_f64, |m, i| m.max(off(peaks, i).abs()));
    let ringing = force.ring.map_or("not seen".to_owned(), |ring| {
        format!("{:.0} Hz, {:.2} ms", ring.frequency_hz, ring.decay_ms)
    });
    format!(
        "Synthetic measurement (the chapter's raw data are not public). By the peaks, as the chapter, with the ringing as the whole force shows it ({ringing}): ki {:.3e} N/m ({:+.1} % of what was put in), ci {:.3e} N s/m ({:+.1} %): {}. By the whole force, law and ringing fitted together: {:+.1} % and {:+.1} %. Without the ringing the peaks give {:+.1} % and {:+.1} %.",
        peaks.parameters[0].value,
        off(peaks, 0),
        peaks.parameters[1].value,
        off(peaks, 1),
        if worst < 5.0 {
            "the chapter's way gives its parameters back"
        } else {
            "the chapter's way does not give its parameters back under this ringing"
        },
        off(force, 0),
        off(force, 1),
        off(calm, 0),
        off(calm, 1),
    )
}

#[cfg(test)]
mod tests {
    use super::super::stem;
    use super::*;

    #[test]
    fn the_files_of_a_figure_bear_its_name() {
        let quiet = ProgressLine::new("", 2, true);
        let mut pages = law_pages(Effort::Coarse, &quiet).unwrap();
        pages.push(drop_page(&TESTS[0]).unwrap());
        let numbers: Vec<_> = pages.iter().map(|p| p.figure).collect();
        assert_eq!(numbers, ["3.2", "3.3", "contact laws", "3.9"]);
        for page in &pages {
            let prefix = stem(page.figure);
            assert!(page.files.iter().all(|(name, _)| name.starts_with(&prefix)));
        }
        assert!(pages[3].note.contains("Synthetic"));
    }
}
