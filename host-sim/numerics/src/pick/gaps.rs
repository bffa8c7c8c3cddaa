//! Which gap to run at: the pick of every gap beside the others, with the share of starts that get onto the
//! orbit picked.

use super::{Pick, PickAnswer, Springs, pick_on, steps};
use crate::basins::start::{self, BasinDrive, Fate, StartWindow};
use crate::basins::{BasinsRequest, SampledShare};
use crate::engine::Engine;
use crate::error::Error;
use crate::limits::PickLimits;
use crate::progress::Progress;
use crate::row::NamedRig;
use crate::row::tidy;
use crate::uncertainty::Uncertainty;

/// A run ends on the orbit picked when the middle of its section is this near to the orbit's, in A0 and A0 Ω.
const ON_ORBIT: f64 = 0.05;
/// A gap whose force is below this share of the largest is not advised.
const FORCE_SHARE: f64 = 0.8;

/// A gap, and the operating point there.
#[derive(Clone, Debug)]
pub struct AtGap {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Clearance at rest over the cart amplitude A0.
    pub gap_over_amplitude: f64,
    /// The operating point there, or why there is none.
    pub pick: Result<GapPick, Error>,
}

/// The operating point at a gap, and what leads to it.
#[derive(Clone, Debug)]
pub struct GapPick {
    /// The operating point, with all that tables and text say of it.
    pub answer: PickAnswer,
    /// Share of the starts that end on the orbit picked; `None` without starts.
    pub basin: Option<SampledShare>,
    /// Share of the starts that end without impact; `None` without starts.
    pub silent: Option<SampledShare>,
}

impl GapPick {
    /// Width of the safe band over the operating frequency, %.
    pub fn safe_band_percent(&self) -> f64 {
        let [low, high] = self.answer.safe_band_hz;
        100.0 * (high - low) / self.answer.operating_frequency_hz
    }
}

/// The gaps beside each other, and the one advised.
#[derive(Clone, Debug)]
pub struct GapAdvice {
    /// Name of the rig.
    pub rig: String,
    /// One entry per gap, in the order asked for.
    pub gaps: Vec<AtGap>,
    /// Index of the gap advised; `None` if no gap has an operating point.
    pub advised: Option<usize>,
    /// Random starts per gap.
    pub starts: u32,
    /// Their lowest displacement, mm; the upper end is the gap.
    pub from_displacement_mm: f64,
    /// Lowest and highest velocity of the starts, relative to the cart, m/s.
    pub velocity_m_per_s: [f64; 2],
}

/// Steps of progress that [`advise`] reports for `gaps` gaps.
pub fn gap_steps(gaps: usize, uncertainty: Option<Uncertainty>, starts: u32) -> u64 {
    gaps as u64 * (steps(uncertainty) + u64::from(starts))
}

/// Picks at every one of `gaps_mm`, and advises the gap to run at.
///
/// The starts are drawn from the basins' usual window, at drive phase 0, with `seed`; they run for 300 drive cycles.
///
/// # Errors
/// If the rig cannot have a gap, if a start cannot be run, or if the work is interrupted. A gap without an operating
/// point is no error: its entry has the reason.
pub fn advise(
    rig: &NamedRig,
    gaps_mm: &[f64],
    (uncertainty, springs): (Option<Uncertainty>, Springs),
    limits: PickLimits,
    (starts, seed): (u32, u64),
    progress: &dyn Progress,
) -> Result<GapAdvice, Error> {
    let at_gap = |gap_mm: &f64| {
        let params = rig.params.with_gap_mm(tidy(*gap_mm))?;
        let there = rig.clone();
        Ok(NamedRig { params, ..there })
    };
    let rigs: Vec<NamedRig> = gaps_mm.iter().map(at_gap).collect::<Result<_, Error>>()?;
    let mut gaps = Vec::with_capacity(rigs.len());
    for rig in &rigs {
        let found = match pick_on(rig, springs, uncertainty, limits, progress) {
            Ok(found) => Ok(gap_pick(rig, found, starts, seed, progress)?),
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(why) => Err(why),
        };
        gaps.push(AtGap {
            gap_mm: tidy(rig.params.gap_m * 1e3),
            gap_over_amplitude: tidy(rig.params.gap_m / rig.params.amplitude_m),
            pick: found,
        });
    }
    let window = StartWindow::usual(&rig.params, 1, 1);
    Ok(GapAdvice {
        rig: rig.name.clone(),
        advised: advised(&gaps),
        gaps,
        starts,
        from_displacement_mm: tidy(window.displacement_m[0] * 1e3),
        velocity_m_per_s: window.velocity_m_per_s,
    })
}

fn gap_pick(
    rig: &NamedRig,
    found: Pick,
    starts: u32,
    seed: u64,
    progress: &dyn Progress,
) -> Result<GapPick, Error> {
    let hz = found.answer.operating_frequency_hz;
    let fates = fates(rig, hz, starts, seed, progress)?;
    let share = |is: &dyn Fn(&Fate) -> bool| {
        let count = fates.iter().filter(|fate| is(fate)).count();
        SampledShare::wilson(count as u64, fates.len() as u64)
    };
    Ok(GapPick {
        answer: found.answer,
        basin: (starts > 0).then(|| share(&|fate| ends_on(fate, found.section))),
        silent: (starts > 0).then(|| share(&|fate| !fate.impacts())),
    })
}

/// What random starts in the usual window end in.
fn fates(
    rig: &NamedRig,
    frequency_hz: f64,
    starts: u32,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Vec<Fate>, Error> {
    let BasinsRequest {
        window,
        phase,
        cycles,
        recorded,
        ..
    } = BasinsRequest::usual(rig.clone(), frequency_hz, 1, 1);
    let drive = BasinDrive {
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
fn advised(gaps: &[AtGap]) -> Option<usize> {
    let picked = gaps.iter().enumerate();
    let picked: Vec<(usize, &GapPick)> = picked
        .filter_map(|(i, gap)| Some((i, gap.pick.as_ref().ok()?)))
        .collect();
    let largest = picked
        .iter()
        .map(|(_, p)| p.answer.force_ratio)
        .fold(0.0, f64::max);
    let strong = |p: &GapPick| p.answer.force_ratio >= FORCE_SHARE * largest;
    let calm = picked.iter().any(|(_, p)| strong(p) && p.answer.jump_free);
    let among = picked
        .into_iter()
        .filter(|(_, p)| strong(p) && (p.answer.jump_free || !calm));
    let key = |p: &GapPick| (p.basin.map_or(0.0, |s| s.value()), p.safe_band_percent());
    let best = among.reduce(|best, next| {
        let (a, b) = (key(best.1), key(next.1));
        if b.0 > a.0 || (b.0 == a.0 && b.1 > a.1) {
            next
        } else {
            best
        }
    });
    best.map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;
    use shared::model::params::WIRES;

    /// What the made-up answers have in all else.
    static PICKED: LazyLock<PickAnswer> = LazyLock::new(|| {
        let rig = NamedRig::new("wires", WIRES);
        let limits = PickLimits::default();
        let found = pick_on(&rig, Springs::default(), None, limits, &());
        found.unwrap().answer
    });

    fn made_up(gap_mm: f64, force: f64, jumps: bool, basin: u64) -> AtGap {
        AtGap {
            gap_mm,
            gap_over_amplitude: gap_mm,
            pick: Ok(GapPick {
                answer: PickAnswer {
                    operating_frequency_hz: 10.0,
                    force_ratio: force,
                    safe_band_hz: [9.5, 10.5],
                    jump_free: !jumps,
                    ..PICKED.clone()
                },
                basin: Some(SampledShare::wilson(basin, 10)),
                silent: None,
            }),
        }
    }

    #[test]
    fn force_first_then_no_jump_then_the_basin() {
        let at = |gaps: &[AtGap]| advised(gaps).map(|i| gaps[i].gap_mm);
        let weak = made_up(0.0, 7.0, false, 10);
        let strong = made_up(1.0, 10.0, false, 5);
        let wider = made_up(2.0, 9.5, false, 6);
        let jumping = made_up(3.0, 11.0, true, 9);
        let none = AtGap {
            pick: Err(Error::Interrupted),
            ..made_up(4.0, 0.0, false, 0)
        };
        let gaps = [weak, strong, wider, jumping, none];
        assert_eq!(at(&gaps), Some(2.0));
        assert_eq!(at(&gaps[3..]), Some(3.0));
        assert_eq!(at(&gaps[4..]), None);
        assert_eq!(at(&[]), None);
    }

    /// The chapter: 0.0 mm does not jump, and has about the largest force over a wider range of frequency.
    #[test]
    fn the_field_s_gap_is_advised_on_wires() {
        let rig = NamedRig::new("wires", WIRES);
        let found = advise(
            &rig,
            &[0.0, 2.4],
            (None, Springs::default()),
            PickLimits::default(),
            (40, 1),
            &(),
        )
        .unwrap();
        assert_eq!(found.advised, Some(0), "{found:?}");
        let [none, large] = [0, 1].map(|i| found.gaps[i].pick.as_ref().unwrap());
        assert!(none.answer.jump_free && !large.answer.jump_free);
        assert_eq!(none.basin.unwrap().value(), 1.0);
        assert!(none.safe_band_percent() > large.safe_band_percent());
        let bad = advise(
            &rig,
            &[70.0],
            (None, Springs::default()),
            PickLimits::default(),
            (1, 1),
            &(),
        );
        assert!(matches!(bad, Err(Error::Parameter(_))), "{bad:?}");
    }

    #[test]
    fn of_equal_basins_the_wider_band_is_advised_and_of_equal_bands_the_first_gap() {
        let at = |gaps: &[AtGap]| advised(gaps).map(|i| gaps[i].gap_mm);
        let mut wide = made_up(1.0, 10.0, false, 5);
        if let Ok(pick) = &mut wide.pick {
            pick.answer.safe_band_hz = [9.4, 10.5];
        }
        let narrow = |gap_mm: f64| made_up(gap_mm, 10.0, false, 5);
        assert_eq!(at(&[narrow(0.0), wide.clone()]), Some(1.0));
        assert_eq!(at(&[wide.clone(), narrow(0.0)]), Some(1.0));
        assert_eq!(at(&[narrow(3.0), narrow(2.0)]), Some(3.0));
        // A larger basin comes before a wider band.
        assert_eq!(at(&[wide, made_up(2.0, 10.0, false, 6)]), Some(2.0));
    }

    #[test]
    fn the_width_of_the_safe_band_is_a_percentage_of_the_operating_frequency() {
        let at = made_up(0.0, 10.0, false, 5);
        assert_eq!(at.pick.unwrap().safe_band_percent(), 10.0);
    }

    #[test]
    fn four_fifths_of_the_largest_force_are_enough_and_weak_gaps_do_not_make_jumps_matter() {
        let at = |gaps: &[AtGap]| advised(gaps).map(|i| gaps[i].gap_mm);
        let strong = made_up(0.0, 10.0, false, 1);
        assert_eq!(
            at(&[strong.clone(), made_up(1.0, 8.0, false, 9)]),
            Some(1.0)
        );
        assert_eq!(at(&[strong, made_up(1.0, 7.99, false, 9)]), Some(0.0));
        // The only gap without jumps is too weak: the others are judged by their basins.
        let weak = made_up(0.0, 5.0, false, 9);
        let jumping = [made_up(1.0, 10.0, true, 2), made_up(2.0, 10.0, true, 3)];
        let [a, b] = jumping;
        assert_eq!(at(&[weak, a, b]), Some(2.0));
    }
}
