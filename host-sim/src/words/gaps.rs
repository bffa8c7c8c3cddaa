//! The gaps beside each other as a table, and the sentence that says which to choose.

use files::UserError;
use numerics::pick::gaps::{AtGap, GapAdvice};
use serde::Serialize;

/// Largest 1/1 forces that differ by at most this share are called about the same.
const ABOUT_THE_SAME: f64 = 0.1;

/// One gap. Units are in the names; what a gap without a pick lacks is empty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GapRow {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Clearance at rest over the drive amplitude A0.
    pub gap_over_amplitude: f64,
    /// The frequency to run at, Hz.
    pub operating_frequency_hz: Option<f64>,
    /// The frequency to run at over the natural frequency, Ω/ω.
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
    /// The highest frequency at which the hammer jumps, Hz.
    pub jump_high_hz: Option<f64>,
    /// The regime a run from rest settles on at the operating frequency.
    pub from_rest: Option<String>,
    /// Share of the starts that end on the orbit picked, 0 to 1.
    pub basin_share: Option<f64>,
    /// Lower end of its 95 % interval.
    pub basin_share_low: Option<f64>,
    /// Upper end of the 95 % interval of `basin_share`.
    pub basin_share_high: Option<f64>,
    /// Share of the starts that end without impact.
    pub silent_share: Option<f64>,
    /// Why there is no pick.
    pub no_pick: Option<String>,
}

impl GapRow {
    /// The row of a gap of the rig `rig`.
    fn new(rig: &str, at: &AtGap) -> Self {
        let pick = at.pick.as_ref().ok();
        let answer = pick.map(|p| &p.answer);
        let jump = answer.and_then(|a| a.jump_range_hz);
        let basin = pick.and_then(|p| p.basin);
        Self {
            rig: rig.to_owned(),
            gap_mm: at.gap_mm,
            gap_over_amplitude: at.gap_over_amplitude,
            operating_frequency_hz: answer.map(|a| a.operating_frequency_hz),
            frequency_ratio: answer.map(|a| a.frequency_ratio),
            force_ratio: answer.map(|a| a.force_ratio),
            largest_force_ratio: answer.map(|a| a.nominal_optimum_force_ratio),
            safe_band_low_hz: answer.map(|a| a.safe_band_hz[0]),
            safe_band_high_hz: answer.map(|a| a.safe_band_hz[1]),
            safe_band_percent: pick.map(|p| p.safe_band_percent()),
            multiplier: answer.map(|a| a.multipliers),
            jumps: answer.map(|a| !a.jump_free),
            jump_low_hz: jump.map(|range| range[0]),
            jump_high_hz: jump.map(|range| range[1]),
            from_rest: answer.map(|a| a.regime_from_rest.to_string()),
            basin_share: basin.map(|s| s.value()),
            basin_share_low: basin.map(|s| s.low),
            basin_share_high: basin.map(|s| s.high),
            silent_share: pick.and_then(|p| p.silent).map(|s| s.value()),
            no_pick: at
                .pick
                .as_ref()
                .err()
                .map(|error| UserError::from(error.clone()).to_string()),
        }
    }
}

/// The gaps beside each other, and the one advised.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GapTable {
    /// A line per gap.
    pub gaps: Vec<GapRow>,
    /// The gap advised, mm; none if no gap has a pick.
    pub advised_gap_mm: Option<f64>,
    /// Why that gap is advised, or none is: a sentence with figures.
    pub why: String,
    /// Random starts per gap.
    pub starts: u32,
    /// Lowest displacement of those starts, mm; the highest is the gap.
    pub from_displacement_mm: f64,
    /// Lowest and highest velocity of those starts, m/s.
    pub velocity_m_per_s: [f64; 2],
}

impl From<&GapAdvice> for GapTable {
    fn from(advice: &GapAdvice) -> Self {
        let row = |at: &AtGap| GapRow::new(&advice.rig, at);
        let gaps: Vec<GapRow> = advice.gaps.iter().map(row).collect();
        let advised = advice.advised.map(|i| &gaps[i]);
        Self {
            advised_gap_mm: advised.map(|row| row.gap_mm),
            why: why(&gaps, advised),
            gaps,
            starts: advice.starts,
            from_displacement_mm: advice.from_displacement_mm,
            velocity_m_per_s: advice.velocity_m_per_s,
        }
    }
}

/// The sentence, made of the rows' figures.
fn why(rows: &[GapRow], advised: Option<&GapRow>) -> String {
    let Some(best) = advised else {
        return "No gap has a stable 1/1 that the uncertainty and the limits allow.".to_owned();
    };
    let picked: Vec<&GapRow> = rows.iter().filter(|r| r.no_pick.is_none()).collect();
    let others: Vec<&GapRow> = picked.iter().copied().filter(|r| *r != best).collect();
    format!(
        "Run at a gap of {:?} mm: {}{}{}{}.",
        best.gap_mm,
        largest_force(&picked),
        force_and_band(best, &others),
        jumps(best, &picked, &others),
        basin(best, &others)
    )
}

/// The least and the largest value of the rows that have one.
fn ends(rows: &[&GapRow], value: impl Fn(&GapRow) -> Option<f64>) -> (f64, f64) {
    let values: Vec<f64> = rows.iter().filter_map(|r| value(r)).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(0.0, f64::max);
    (low, high)
}

fn largest_force(picked: &[&GapRow]) -> String {
    let (low, high) = ends(picked, |r| r.largest_force_ratio);
    let (same, so) = if high - low <= ABOUT_THE_SAME * high {
        ("about the same at every gap tried", "buys no force")
    } else {
        ("not the same at every gap tried", "matters for the force")
    };
    format!(
        "the largest 1/1 force is {same} ({low:.1} to {high:.1} times the weight), so a gap {so}"
    )
}

fn force_and_band(best: &GapRow, others: &[&GapRow]) -> String {
    let (Some(force), Some(band)) = (best.force_ratio, best.safe_band_percent) else {
        return String::new();
    };
    let text = format!(
        "; at {:?} mm it strikes with {force:.1} times the weight in a safe band {band:.1} % wide",
        best.gap_mm
    );
    if others.is_empty() {
        return text;
    }
    let (least, most) = ends(others, |r| r.safe_band_percent);
    text + &format!(" ({least:.1} to {most:.1} % at the others)")
}

fn jumps(best: &GapRow, picked: &[&GapRow], others: &[&GapRow]) -> String {
    let jumping: Vec<_> = picked.iter().filter(|r| r.jumps == Some(true)).collect();
    match (best.jumps, jumping.first(), jumping.last()) {
        (Some(false), Some(first), Some(last)) => format!(
            "; nothing jumps there, while the hammer jumps (sweeps differ, or the 1/1 ends in a fold) at {} of the other {} gaps ({:?} to {:?} mm)",
            jumping.len(),
            others.len(),
            first.gap_mm,
            last.gap_mm
        ),
        (Some(false), ..) => "; nothing jumps, there or at the others".to_owned(),
        _ => "; the hammer jumps there, as at every gap with as much force".to_owned(),
    }
}

fn basin(best: &GapRow, others: &[&GapRow]) -> String {
    let Some(share) = best.basin_share else {
        return String::new();
    };
    let text = format!(
        "; and {:.0} % of the starts end on that orbit",
        100.0 * share
    );
    if others.is_empty() {
        return text;
    }
    let (least, most) = ends(others, |r| r.basin_share);
    text + &format!(
        " ({:.0} to {:.0} % at the others)",
        100.0 * least,
        100.0 * most
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::Error;
    use numerics::basins::SampledShare;
    use numerics::pick::gaps::GapPick;
    use numerics::pick::{PickAnswer, Springs, pick_on};
    use numerics::{NamedRig, PickLimits};
    use shared::model::params::WIRES;
    use std::sync::LazyLock;

    /// What the made-up answers have in all else.
    static PICKED: LazyLock<PickAnswer> = LazyLock::new(|| {
        let rig = NamedRig::new("wires", WIRES);
        let limits = PickLimits::default();
        let found = pick_on(&rig, Springs::default(), None, limits, &());
        found.unwrap().answer
    });

    fn made_up(gap_mm: f64, force: f64, jumps: bool, basin: u64) -> GapRow {
        let answer = PickAnswer {
            operating_frequency_hz: 10.0,
            force_ratio: force,
            nominal_optimum_force_ratio: force,
            safe_band_hz: [9.5, 10.5],
            jump_free: !jumps,
            jump_range_hz: None,
            ..PICKED.clone()
        };
        let pick = GapPick {
            answer,
            basin: Some(SampledShare::wilson(basin, 10)),
            silent: None,
        };
        let at = AtGap {
            gap_mm,
            gap_over_amplitude: gap_mm,
            pick: Ok(pick),
        };
        GapRow::new("wires", &at)
    }

    #[test]
    fn a_gap_without_a_pick_says_why() {
        let at = AtGap {
            gap_mm: 1.0,
            gap_over_amplitude: 1.0,
            pick: Err(Error::Frequency(-1.0)),
        };
        let row = GapRow::new("wires", &at);
        assert!(row.no_pick.unwrap().contains("-1 Hz"));
        assert_eq!(row.force_ratio, None);
    }

    #[test]
    fn the_sentence_says_what_the_rows_say_and_nothing_else() {
        let rows = [made_up(0.0, 20.0, false, 9), made_up(2.0, 21.0, true, 3)];
        let text = why(&rows, Some(&rows[0]));
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
        let rows = [made_up(1.0, 20.0, true, 2), made_up(2.0, 30.0, true, 3)];
        let text = why(&rows, Some(&rows[1]));
        assert!(
            text.contains("not the same at every gap") && text.contains("2.0 mm"),
            "{text}"
        );
        assert!(text.contains("the hammer jumps there"), "{text}");
        assert!(why(&[], None).starts_with("No gap"));
    }
}
