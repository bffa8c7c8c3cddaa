//! Which gap to run at: the pick of every gap beside the others, with the share of starts that get onto the
//! orbit picked.

use serde::Serialize;

use super::{Limits, Pick, Uncertainty, pick, steps};
use crate::basins::start::{self, Drive, Fate, Window};
use crate::basins::{Query, Share};
use crate::engine::Engine;
use crate::error::UserError;
use crate::progress::Progress;
use crate::rigfile::{NamedRig, with_number};
use crate::table::tidy;

/// A run ends on the orbit picked when the middle of its section is this near to the orbit's, in A0 and A0 Ω.
const ON_ORBIT: f64 = 0.05;
/// A gap whose force is below this share of the largest is not advised.
const FORCE_SHARE: f64 = 0.8;
/// Largest 1/1 forces that differ by at most this share are called about the same.
const ABOUT_THE_SAME: f64 = 0.1;

/// One gap. Units are in the names; what a gap without a pick lacks is empty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GapRow {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// The same over A0.
    pub gap_over_amplitude: f64,
    /// The frequency to run at, Hz.
    pub operating_frequency_hz: Option<f64>,
    /// The same over the natural frequency.
    pub frequency_ratio: Option<f64>,
    /// Contact force over m g there.
    pub force_ratio: Option<f64>,
    /// Force ratio of the strongest stable 1/1 of the nominal rig, no limits.
    pub largest_force_ratio: Option<f64>,
    /// The safe band, Hz: 1/1 stable over the uncertainty, force above 90 %, limits kept.
    pub safe_band_low_hz: Option<f64>,
    /// Its upper end, Hz.
    pub safe_band_high_hz: Option<f64>,
    /// Its width over the operating frequency, %.
    pub safe_band_percent: Option<f64>,
    /// Largest modulus of a multiplier at the operating point.
    pub multiplier: Option<f64>,
    /// Whether the hammer jumps: up and down sweeps across the stable 1/1 differ, or the stable 1/1 ends in a fold.
    pub jumps: Option<bool>,
    /// The lowest frequency at which it does, Hz.
    pub jump_low_hz: Option<f64>,
    /// The highest, Hz.
    pub jump_high_hz: Option<f64>,
    /// The regime a run from rest settles on at the operating frequency.
    pub from_rest: Option<String>,
    /// Share of the starts that end on the orbit picked, 0 to 1.
    pub basin_share: Option<f64>,
    /// Lower end of its 95 % interval.
    pub basin_share_low: Option<f64>,
    /// Upper end.
    pub basin_share_high: Option<f64>,
    /// Share of the starts that end without impact.
    pub silent_share: Option<f64>,
    /// Why there is no pick.
    pub no_pick: Option<String>,
}

/// The gaps beside each other, and the one advised.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GapAdvice {
    /// A line per gap.
    pub gaps: Vec<GapRow>,
    /// The gap advised, mm; none if no gap has a pick.
    pub advised_gap_mm: Option<f64>,
    /// Why, with figures.
    pub why: String,
    /// Random starts per gap.
    pub starts: u32,
    /// Their displacements, mm; the upper end is the gap.
    pub from_displacement_mm: f64,
    /// Their velocities, m/s.
    pub velocity_m_per_s: [f64; 2],
}

/// Steps of progress that [`advise`] reports for `gaps` gaps.
pub fn gap_steps(gaps: usize, uncertainty: Option<Uncertainty>, starts: u32) -> u64 {
    gaps as u64 * (steps(uncertainty) + u64::from(starts))
}

/// Picks at every one of `gaps_mm`, and tells which gap to run at.
///
/// The starts are drawn from the basins' usual window, at drive phase 0, with `seed`; they run for 300 drive cycles.
///
/// # Errors
/// A gap the rig cannot have; starts that cannot be run. A gap without a pick is a row that says why.
pub fn advise(
    rig: &NamedRig,
    gaps_mm: &[f64],
    uncertainty: Option<Uncertainty>,
    limits: Limits,
    (starts, seed): (u32, u64),
    progress: &Progress,
) -> Result<GapAdvice, UserError> {
    let at_gap = |gap_mm: &f64| {
        let params =
            with_number(&rig.params, "gap_mm", tidy(*gap_mm)).map_err(|e| e.at("--gaps"))?;
        let name = rig.name.clone();
        Ok(NamedRig { name, params })
    };
    let rigs: Vec<NamedRig> = gaps_mm
        .iter()
        .map(at_gap)
        .collect::<Result<_, UserError>>()?;
    let mut rows = Vec::with_capacity(rigs.len());
    for rig in &rigs {
        rows.push(match pick(rig, uncertainty, limits, progress) {
            Ok(found) => row(rig, &found, starts, seed, progress)?,
            Err(why) => nothing(rig, why.to_string()),
        });
    }
    let advised = advised(&rows);
    let window = Window::usual(&rig.params, 1, 1);
    Ok(GapAdvice {
        advised_gap_mm: advised.map(|row| row.gap_mm),
        why: why(&rows, advised),
        gaps: rows,
        starts,
        from_displacement_mm: tidy(window.displacement_m[0] * 1e3),
        velocity_m_per_s: window.velocity_m_per_s,
    })
}

fn nothing(rig: &NamedRig, why: String) -> GapRow {
    GapRow {
        rig: rig.name.clone(),
        gap_mm: tidy(rig.params.gap_m * 1e3),
        gap_over_amplitude: tidy(rig.params.gap_m / rig.params.amplitude_m),
        operating_frequency_hz: None,
        frequency_ratio: None,
        force_ratio: None,
        largest_force_ratio: None,
        safe_band_low_hz: None,
        safe_band_high_hz: None,
        safe_band_percent: None,
        multiplier: None,
        jumps: None,
        jump_low_hz: None,
        jump_high_hz: None,
        from_rest: None,
        basin_share: None,
        basin_share_low: None,
        basin_share_high: None,
        silent_share: None,
        no_pick: Some(why),
    }
}

fn row(
    rig: &NamedRig,
    found: &Pick,
    starts: u32,
    seed: u64,
    progress: &Progress,
) -> Result<GapRow, UserError> {
    let a = &found.answer;
    let hz = a.operating_frequency_hz;
    let fates = fates(rig, hz, starts, seed, progress)?;
    let share = |is: &dyn Fn(&Fate) -> bool| {
        let count = fates.iter().filter(|fate| is(fate)).count();
        Share::wilson(count as u64, fates.len() as u64)
    };
    let basin = (starts > 0).then(|| share(&|fate| ends_on(fate, found.section)));
    let silent = (starts > 0).then(|| share(&|fate| !fate.impacts()));
    let [low, high] = a.safe_band_hz;
    Ok(GapRow {
        operating_frequency_hz: Some(hz),
        frequency_ratio: Some(a.frequency_ratio),
        force_ratio: Some(a.force_ratio),
        largest_force_ratio: Some(a.nominal_optimum_force_ratio),
        safe_band_low_hz: Some(low),
        safe_band_high_hz: Some(high),
        safe_band_percent: Some(100.0 * (high - low) / hz),
        multiplier: Some(a.multipliers),
        jumps: Some(!a.jump_free),
        jump_low_hz: a.jump_range_hz.map(|range| range[0]),
        jump_high_hz: a.jump_range_hz.map(|range| range[1]),
        from_rest: Some(a.regime_from_rest.clone()),
        basin_share: basin.map(|s| s.value()),
        basin_share_low: basin.map(|s| s.low),
        basin_share_high: basin.map(|s| s.high),
        silent_share: silent.map(|s| s.value()),
        no_pick: None,
        ..nothing(rig, String::new())
    })
}

/// What becomes of hammers let go all over the usual window.
fn fates(
    rig: &NamedRig,
    frequency_hz: f64,
    starts: u32,
    seed: u64,
    progress: &Progress,
) -> Result<Vec<Fate>, UserError> {
    let Query {
        window,
        phase,
        cycles,
        recorded,
        ..
    } = Query::usual(rig.clone(), frequency_hz, 1, 1);
    let drive = Drive {
        params: rig.params,
        frequency_hz,
        phase,
    };
    let starts = window.sample(starts, seed);
    start::fates(Engine::Event, &drive, &starts, cycles, recorded, progress)
}

/// Whether `fate` is the 1/1 through `section` (in A0 and A0 Ω).
fn ends_on(fate: &Fate, section: [f64; 2]) -> bool {
    let near = |middle: [f64; 2]| (0..2).all(|i| (middle[i] - section[i]).abs() < ON_ORBIT);
    fate.regime.is(1, 1) && fate.middle.is_some_and(near)
}

/// Of the gaps with at least [`FORCE_SHARE`] of the largest force, and without a jump if there are such, the one most
/// starts lead to; of equal ones the one with the wider safe band.
fn advised(rows: &[GapRow]) -> Option<&GapRow> {
    let force = |row: &GapRow| row.force_ratio.unwrap_or(0.0);
    let largest = rows.iter().map(force).fold(0.0, f64::max);
    let strong = rows
        .iter()
        .filter(|row| row.force_ratio.is_some_and(|f| f >= FORCE_SHARE * largest));
    let strong: Vec<_> = strong.collect();
    let calm: Vec<_> = strong
        .iter()
        .copied()
        .filter(|r| r.jumps == Some(false))
        .collect();
    let among = if calm.is_empty() { strong } else { calm };
    let key = |row: &GapRow| {
        (
            row.basin_share.unwrap_or(0.0),
            row.safe_band_percent.unwrap_or(0.0),
        )
    };
    among.into_iter().reduce(|best, row| {
        let (a, b) = (key(best), key(row));
        if b.0 > a.0 || (b.0 == a.0 && b.1 > a.1) {
            row
        } else {
            best
        }
    })
}

/// The sentence, made of the rows' figures.
fn why(rows: &[GapRow], advised: Option<&GapRow>) -> String {
    let Some(best) = advised else {
        return "No gap has a stable 1/1 that the uncertainty and the limits allow.".to_owned();
    };
    let picked: Vec<&GapRow> = rows.iter().filter(|r| r.no_pick.is_none()).collect();
    let others: Vec<&GapRow> = picked.iter().copied().filter(|r| *r != best).collect();
    let ends = |value: &dyn Fn(&GapRow) -> Option<f64>, of: &[&GapRow]| {
        let values: Vec<f64> = of.iter().filter_map(|r| value(r)).collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        (low, high)
    };
    let mut text = format!("Run at a gap of {:?} mm", best.gap_mm);
    let (low, high) = ends(&|r| r.largest_force_ratio, &picked);
    let same = high - low <= ABOUT_THE_SAME * high;
    text += &format!(
        ": the largest 1/1 force is {} ({low:.1} to {high:.1} times the weight), so a gap {}",
        if same {
            "about the same at every gap tried"
        } else {
            "not the same at every gap tried"
        },
        if same {
            "buys no force"
        } else {
            "matters for the force"
        }
    );
    if let (Some(force), Some(band)) = (best.force_ratio, best.safe_band_percent) {
        let (least, most) = ends(&|r| r.safe_band_percent, &others);
        text += &format!(
            "; at {:?} mm it strikes with {force:.1} times the weight in a safe band {band:.1} % wide",
            best.gap_mm
        );
        if !others.is_empty() {
            text += &format!(" ({least:.1} to {most:.1} % at the others)");
        }
    }
    let jumping: Vec<_> = picked.iter().filter(|r| r.jumps == Some(true)).collect();
    text += &match (best.jumps, jumping.first(), jumping.last()) {
        (Some(false), Some(first), Some(last)) => format!(
            "; nothing jumps there, while the hammer jumps (sweeps differ, or the 1/1 ends in a fold) at {} of the other {} gaps ({:?} to {:?} mm)",
            jumping.len(),
            others.len(),
            first.gap_mm,
            last.gap_mm
        ),
        (Some(false), ..) => "; nothing jumps, there or at the others".to_owned(),
        _ => "; the hammer jumps there, as at every gap with as much force".to_owned(),
    };
    if let Some(share) = best.basin_share {
        let (least, most) = ends(&|r| r.basin_share, &others);
        text += &format!(
            "; and {:.0} % of the starts end on that orbit",
            100.0 * share
        );
        if !others.is_empty() {
            text += &format!(
                " ({:.0} to {:.0} % at the others)",
                100.0 * least,
                100.0 * most
            );
        }
    }
    text + "."
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::params::WIRES;

    fn made_up(gap_mm: f64, force: f64, jumps: bool, basin: f64) -> GapRow {
        let mut params = WIRES;
        params.gap_m = gap_mm * 1e-3;
        let rig = NamedRig {
            name: "wires".to_owned(),
            params,
        };
        GapRow {
            force_ratio: Some(force),
            largest_force_ratio: Some(force),
            safe_band_percent: Some(10.0),
            jumps: Some(jumps),
            basin_share: Some(basin),
            no_pick: None,
            ..nothing(&rig, String::new())
        }
    }

    #[test]
    fn force_first_then_no_jump_then_the_basin() {
        let at = |rows: &[GapRow]| advised(rows).map(|r| r.gap_mm);
        let weak = made_up(0.0, 7.0, false, 1.0);
        let strong = made_up(1.0, 10.0, false, 0.5);
        let wider = made_up(2.0, 9.5, false, 0.6);
        let jumping = made_up(3.0, 11.0, true, 0.9);
        let rows = [weak, strong, wider, jumping];
        assert_eq!(at(&rows), Some(2.0));
        assert_eq!(at(&rows[3..]), Some(3.0));
        assert_eq!(at(&[]), None);
    }

    #[test]
    fn the_sentence_says_what_the_rows_say_and_nothing_else() {
        let rows = [
            made_up(0.0, 20.0, false, 0.9),
            made_up(2.0, 21.0, true, 0.3),
        ];
        let text = why(&rows, advised(&rows));
        assert!(text.starts_with("Run at a gap of 0.0 mm"), "{text}");
        assert!(
            text.contains("about the same at every gap tried (20.0 to 21.0"),
            "{text}"
        );
        assert!(
            text.contains("the hammer jumps (sweeps differ, or the 1/1 ends in a fold) at 1 of the other 1 gaps (2.0 to 2.0 mm)"),
            "{text}"
        );
        assert!(
            text.contains("90 % of the starts") && text.contains("30 to 30 %"),
            "{text}"
        );
        let rows = [made_up(1.0, 20.0, true, 0.2), made_up(2.0, 30.0, true, 0.3)];
        let text = why(&rows, advised(&rows));
        assert!(
            text.contains("not the same at every gap") && text.contains("2.0 mm"),
            "{text}"
        );
        assert!(text.contains("the hammer jumps there"), "{text}");
        assert!(why(&[], None).starts_with("No gap"));
    }

    /// The chapter: 0.0 mm does not jump, and has about the largest force over a wider range of frequency.
    #[test]
    fn the_field_s_gap_is_advised_on_wires() {
        let rig = NamedRig {
            name: "wires".to_owned(),
            params: WIRES,
        };
        let quiet = Progress::new("", 1, true);
        let found = advise(&rig, &[0.0, 2.4], None, Limits::default(), (40, 1), &quiet).unwrap();
        assert_eq!(found.advised_gap_mm, Some(0.0), "{found:?}");
        let [none, large] = [&found.gaps[0], &found.gaps[1]];
        assert_eq!((none.jumps, large.jumps), (Some(false), Some(true)));
        assert_eq!(none.basin_share, Some(1.0));
        assert!(none.safe_band_percent > large.safe_band_percent);
        let bad = advise(&rig, &[70.0], None, Limits::default(), (1, 1), &quiet);
        assert!(bad.unwrap_err().to_string().starts_with("--gaps"));
    }
}
