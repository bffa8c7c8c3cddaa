//! The switch model at work, figures 3.5 and 3.6: a mass on a spring with a shaken base and a stop, by the chapter's
//! band with Runge–Kutta steps, and the four subspaces during one impact.

use serde::Serialize;
use shared::model::params::{BEAM_170, RigParams};
use shared::model::rig::Rig;
use shared::model::switch::{Band, Subspace, classify};

use super::{Effort, Page};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::engine::{
    CycleRecorder, Engine, Machine, Method, Precision, RecordedSample, Setting, Start, machine,
};
use plot::{Color, Figure, Item, Mark, Panel, Shape};

/// A mass on a spring: the beam rig at 170 mm, its stop 1 mm away, driven at 1.5 times its own frequency.
const STOP: RigParams = RigParams {
    gap_m: 1e-3,
    ..BEAM_170
};
const RATIO: f64 = 1.5;

/// Band widths that can be seen in a picture of one impact (some 20 µm deep), and narrow ones that do not matter.
const WIDE: (f64, f64) = (1e-6, 5.0);
const NARROW: (f64, f64) = (5e-8, 0.01);

/// What one width of the band gave.
struct Run {
    band: (f64, f64),
    samples: Vec<RecordedSample>,
    /// Contacts that began in the period.
    onsets: u16,
    peak_n: f64,
}

/// Figures 3.5 and 3.6.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn pages(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let (periods, tick_s) = effort.of((12, 5e-8), (2, 1e-6));
    let frequency_hz = RATIO * STOP.natural_frequency_hz();
    // The settled orbit by the event-located reference: where all runs start, and what they are held to.
    let mut exact = machine(Engine::Event, &STOP, frequency_hz, Start::Rest)?;
    let settle = effort.of(600, 60);
    for _ in 0..settle {
        exact.period(None);
    }
    let section = exact.section();
    let truth = one_period(exact.as_mut(), (0.0, 0.0), 1, 100_000);
    progress.inc(1);
    let run = |band: (f64, f64)| -> Result<Run, UserError> {
        let setting = Setting {
            method: Method::Banded {
                eta_alpha_m: band.0,
                eta_beta_n: band.1,
            },
            precision: Precision::F64,
            tick_s,
        };
        let start = Start::Section(section);
        let mut hammer = machine(Engine::Switch(setting), &STOP, frequency_hz, start)?;
        let run = one_period(hammer.as_mut(), band, periods, 100_000);
        progress.inc(1);
        Ok(run)
    };
    let (wide, narrow) = rayon::join(|| run(WIDE), || run(NARROW));
    let (wide, narrow) = (wide?, narrow?);
    Ok(vec![
        trajectory(&narrow, &truth, frequency_hz)?,
        transition(&wide, &narrow, &truth, tick_s)?,
    ])
}

/// The last of `periods` drive periods, with `samples` of it.
fn one_period(hammer: &mut dyn Machine, band: (f64, f64), periods: u32, samples: usize) -> Run {
    let mut recorder = CycleRecorder {
        samples_per_period: samples,
        ..CycleRecorder::default()
    };
    for _ in 1..periods {
        hammer.period(None);
    }
    let last = hammer.period(Some(&mut recorder));
    Run {
        band,
        samples: recorder.samples,
        onsets: last.onsets,
        peak_n: last.peak_force,
    }
}

/// Penetration δ of the stop, m; negative while the mass is clear of it.
fn depth_m(sample: &RecordedSample) -> f64 {
    sample.relative_displacement_mm * 1e-3 - STOP.gap_m
}

fn subspace(rig: &Rig<f64>, sample: &RecordedSample, band: &Band<f64>) -> Subspace {
    let (delta, rate) = (depth_m(sample), sample.relative_velocity_m_per_s);
    // The spring-dashpot does not ask for the approach speed.
    classify(delta, rig.law().force(delta, rate, 0.0), band)
}

fn trajectory(run: &Run, truth: &Run, frequency_hz: f64) -> Result<Page, UserError> {
    let from = run.samples.first().map_or(0.0, |s| s.time_s);
    let turns = |s: &RecordedSample| (s.time_s - from) * frequency_hz;
    let over_time = |value: fn(&RecordedSample) -> f64| -> Vec<(f64, f64)> {
        run.samples.iter().map(|s| (turns(s), value(s))).collect()
    };
    let wall = |s: &RecordedSample| {
        // The stop rides on the base.
        s.displacement_mm - s.relative_displacement_mm + STOP.gap_m * 1e3
    };
    let phase = |run: &Run| -> Vec<(f64, f64)> {
        let at = |s: &RecordedSample| (s.relative_displacement_mm, s.relative_velocity_m_per_s);
        run.samples.iter().map(at).collect()
    };
    let title = "A mass on a spring, a shaken base and a stop, by the switch model";
    let picture = Figure::new(title)
        .subtitle(format!(
            "Gap 1.0 mm, Ω/ω = {RATIO}; band of η_α = {:.0e} m and η_β = {} N. One drive period of the settled motion.",
            run.band.0, run.band.1
        ))
        .columns(2)
        .size(1300, 560)
        .panel(
            Panel::new("time, drive periods", "displacement in the fixed frame, mm")
            .titled("a) Motion")
            .item(Item::line("mass", Color::BLUE, over_time(|s| s.displacement_mm)))
            .item(Item::dashed("stop", Color::RED, over_time(wall))),
        )
        .panel(
            Panel::new("displacement relative to the base, mm", "relative velocity, m/s")
            .titled("b) Phase plane")
            .item(Item::line("switch model", Color::BLUE, phase(run)))
            .item(Item::dashed("event-located reference", Color::ORANGE, phase(truth)))
            .item(Item::mark_x("Σ: the stop", STOP.gap_m * 1e3)),
        );
    let page = Page::new(
        "3.5",
        title,
        "host-sim figures --only 3.5 --out figures",
        &picture,
    )?;
    let sparse: Vec<_> = run.samples.iter().step_by(50).collect();
    Ok(page.table("", &sparse).noted(format!(
        "With a band of {:.0e} m the switch model gives {} contact(s) in the period and a peak of {:.3} N; the event-located reference {} and {:.3} N: {:+.2} %.",
        run.band.0,
        run.onsets,
        run.peak_n,
        truth.onsets,
        truth.peak_n,
        100.0 * (run.peak_n / truth.peak_n - 1.0)
    )))
}

/// A sample of the impact and where it lies.
#[derive(Serialize)]
struct Crossing {
    eta_alpha_m: f64,
    time_us: f64,
    penetration_um: f64,
    rate_m_per_s: f64,
    force_n: f64,
    subspace: &'static str,
}

const NAMES: [(Subspace, &str, Color); 4] = [
    (Subspace::Flight, "Γ−, free", Color::BLUE),
    (Subspace::Entering, "Σα, entering", Color::ORANGE),
    (Subspace::Contact, "Γ+, contact", Color::RED),
    (Subspace::Leaving, "Σβ, leaving", Color::GREEN),
];

/// The samples around the deepest point.
fn crossing(run: &Run) -> Result<Vec<Crossing>, UserError> {
    let rig = Rig::<f64>::new(&STOP)?;
    let band = Band::new(run.band.0, run.band.1);
    let near = |s: &&RecordedSample| depth_m(s) > -4e-6;
    let pushes = |s: &&RecordedSample| s.force_n > 0.0;
    let first = run.samples.iter().find(pushes).map_or(0.0, |s| s.time_s);
    let crossing = |s: &RecordedSample| {
        let here = subspace(&rig, s, &band);
        let name = NAMES.iter().find(|n| n.0 == here).map_or("", |n| n.1);
        Crossing {
            eta_alpha_m: run.band.0,
            time_us: (s.time_s - first) * 1e6,
            penetration_um: depth_m(s) * 1e6,
            rate_m_per_s: s.relative_velocity_m_per_s,
            force_n: s.force_n,
            subspace: name,
        }
    };
    Ok(run.samples.iter().filter(near).map(crossing).collect())
}

fn transition(wide: &Run, narrow: &Run, truth: &Run, tick_s: f64) -> Result<Page, UserError> {
    let mut steps = crossing(wide)?;
    let title = "One impact: from free flight through the band into contact and out again";
    let [plane, force] = transition_panels(&steps, &crossing(truth)?);
    let picture = Figure::new(title)
        .subtitle(format!(
            "Band of η_α = {:.0e} m (shaded) and η_β = {} N, wide enough to be seen; Runge–Kutta steps of {:.2} µs. Dashed: no band, events located.",
            WIDE.0,
            WIDE.1,
            tick_s * 1e6
        ))
        .columns(2)
        .size(1300, 600)
        .panel(plane)
        .panel(force);
    let count = |name: &str| steps.iter().filter(|s| s.subspace == name).count();
    let counts: Vec<String> = NAMES[1..]
        .iter()
        .map(|(_, name, _)| format!("{} steps in {name}", count(name)))
        .collect();
    let off = |run: &Run| 100.0 * (run.peak_n / truth.peak_n - 1.0);
    let note = format!(
        "The impact passes Γ−, Σα, Γ+ and leaves through Σβ: {}. The band changes the peak force: by {:+.2} % at η_α = {:.0e} m and by {:+.2} % at {:.0e} m, against the event-located reference ({:.3} N). So η must be chosen far smaller than what can be seen in a picture.",
        counts.join(", "),
        off(wide),
        WIDE.0,
        off(narrow),
        NARROW.0,
        truth.peak_n
    );
    steps.extend(crossing(narrow)?);
    let page = Page::new(
        "3.6",
        title,
        "host-sim figures --only 3.6 --out figures",
        &picture,
    )?;
    Ok(page.table("", &steps).noted(note))
}

/// Phase plane and force of one impact, the steps by sub-space, over the reference.
fn transition_panels(steps: &[Crossing], exact: &[Crossing]) -> [Panel; 2] {
    let mut plane = Panel::new("penetration h_α = δ, µm", "its rate, m/s")
        .titled("a) Phase plane")
        .item(band_x(WIDE.0 * 1e6));
    let mut force =
        Panel::new("time since the force began, µs", "contact force, N").titled("b) Force");
    for (_, name, color) in NAMES {
        let of: Vec<_> = steps.iter().filter(|s| s.subspace == name).collect();
        let points = |f: fn(&Crossing) -> (f64, f64)| of.iter().map(|s| f(s)).collect();
        let dots = |points| Item::marks(name, color, (Mark::Circle, 1.4), points);
        plane = plane.item(dots(points(|s| (s.penetration_um, s.rate_m_per_s))));
        force = force.item(dots(points(|s| (s.time_us, s.force_n))));
    }
    let curve = exact.iter().map(|s| (s.penetration_um, s.rate_m_per_s));
    let plane = plane.item(Item::dashed("reference", Color::INK, curve.collect()));
    let curve = exact.iter().map(|s| (s.time_us, s.force_n));
    let force = force.item(Item::dashed("reference", Color::INK, curve.collect()));
    [plane, force]
}

/// The band around the surface, as a shade.
fn band_x(half_um: f64) -> Item {
    let band = Shape::BandX {
        from: -half_um,
        to: half_um,
    };
    Item::new("band |h_α| < η_α", Color::ORANGE, band)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impact_passes_the_subspaces_in_their_order() {
        let pages = pages(Effort::Coarse, &ProgressLine::new("", 1, true)).unwrap();
        let table = &pages[1].files[2].1;
        let mut seen: Vec<String> = Vec::new();
        for row in csv::Reader::from_reader(&table[..]).records() {
            let row = row.unwrap();
            if row[0].parse::<f64>().unwrap() == WIDE.0
                && seen.last().map(String::as_str) != Some(&row[5])
            {
                seen.push(row[5].to_owned());
            }
        }
        let order: Vec<&str> = seen.iter().map(String::as_str).collect();
        assert_eq!(order[..3], ["Γ−, free", "Σα, entering", "Γ+, contact"]);
        assert!(order.contains(&"Σβ, leaving"), "{order:?}");
    }
}
