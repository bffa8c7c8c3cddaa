//! The force curve over frequency (figures 3.12–3.14 and 3.40–3.42): from rest at each frequency, or
//! carried up or down, which shows the jumps.

use shared::model::params::RigParams;
use shared::model::regime::Regime;

use crate::engine::{CycleRecorder, Engine, Plan, Start, machine, observe, observe_settled};
use crate::error::Error;
use crate::lanes;
use crate::parallel;
use crate::progress::{Progress, step};
use crate::row::NamedRig;
use crate::row::RunRow;

/// In which order the frequencies are visited and what is carried from one to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Each frequency from rest.
    Rest,
    /// Upwards, each from where the last one ended.
    Up,
    /// Downwards, each from where the last one ended.
    Down,
}

impl Direction {
    /// What it means for a run, as a title says it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Rest => "from rest",
            Self::Up => "state carried up",
            Self::Down => "state carried down",
        }
    }

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Up => "up",
            Self::Down => "down",
        }
    }
}

/// The curve at `frequencies_hz` (rising); rows come back by rising frequency, whatever the direction.
/// Runs carried over start from rest at the first frequency visited, and behind one that failed. A hammer that leaves what
/// the model describes is a row that says so.
///
/// # Errors
/// If a parameter or frequency is out of range, if every run fails, or if the work is interrupted.
pub fn sweep(
    rig: &NamedRig,
    engine: Engine,
    frequencies_hz: &[f64],
    direction: Direction,
    plan: Plan,
    progress: &dyn Progress,
) -> Result<Vec<RunRow>, Error> {
    along(frequencies_hz, direction, |hz, start| {
        run_one(rig, engine, *hz, start, plan, progress)
    })
}

/// The runs of `points`, rows in the same order.
pub(crate) fn along<T: Sync>(
    points: &[T],
    direction: Direction,
    run: impl Fn(&T, Start) -> Result<Ran, Error> + Sync,
) -> Result<Vec<RunRow>, Error> {
    if direction == Direction::Rest {
        let rows = parallel::try_map(points, |point| run(point, Start::Rest))?;
        return unless_all_failed(rows);
    }
    let mut order: Vec<&T> = points.iter().collect();
    if direction == Direction::Down {
        order.reverse();
    }
    let mut start = Start::Rest;
    let mut rows = Vec::with_capacity(order.len());
    for point in order {
        let found = run(point, start)?;
        start = found.carried();
        rows.push(found);
    }
    if direction == Direction::Down {
        rows.reverse();
    }
    unless_all_failed(rows)
}

/// What became of a run: its row, and where it ended, or why it failed.
pub(crate) struct Ran {
    row: RunRow,
    end: Result<[f64; 2], Error>,
}

impl Ran {
    /// Where the next begins: behind a run that failed, from rest.
    fn carried(&self) -> Start {
        match self.end {
            Ok(section) => Start::Section(section),
            Err(_) => Start::Rest,
        }
    }
}

/// The rows; the first error if every run failed.
fn unless_all_failed(runs: Vec<Ran>) -> Result<Vec<RunRow>, Error> {
    if let Some(Err(error)) = runs.first().map(|ran| &ran.end)
        && runs.iter().all(|ran| ran.row.failed)
    {
        return Err(error.clone());
    }
    Ok(runs.into_iter().map(|ran| ran.row).collect())
}

/// The runs of several rigs, each at its own frequency (Hz); rows come back in the order given. `Up` carries the state from
/// each to the next, `Down` from each to the one before; runs carried over start from rest at the first visited.
///
/// # Errors
/// As [`sweep`].
pub fn over(
    runs: &[(NamedRig, f64)],
    engine: Engine,
    direction: Direction,
    plan: Plan,
    progress: &dyn Progress,
) -> Result<Vec<RunRow>, Error> {
    along(runs, direction, |(rig, hz), start| {
        run_one(rig, engine, *hz, start, plan, progress)
    })
}

/// A run for a picture: in a lane where the lanes can do it, whose row knows no contact's speed and duration, else by the
/// reference.
///
/// # Errors
/// If the rig, the frequency or the start is out of range, or if the work is interrupted.
pub(crate) fn drawn(
    rig: &NamedRig,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
    progress: &dyn Progress,
) -> Result<Ran, Error> {
    let from = machine(Engine::Event, &rig.params, frequency_hz, start)?.section();
    let Some(run) = lanes::settled(&rig.params, frequency_hz, from, plan) else {
        return run_one(rig, Engine::Event, frequency_hz, start, plan, progress);
    };
    step(progress, 1)?;
    Ok(Ran {
        row: RunRow::of_cell(&rig.name, &rig.params, frequency_hz, &run),
        end: Ok(run.section),
    })
}

fn run_one(
    rig: &NamedRig,
    engine: Engine,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
    progress: &dyn Progress,
) -> Result<Ran, Error> {
    let mut hammer = machine(engine, &rig.params, frequency_hz, start)?;
    let seen = match engine {
        Engine::Event => observe_settled(hammer.as_mut(), plan),
        Engine::Switch(_) => observe(hammer.as_mut(), plan, &mut CycleRecorder::default()),
    };
    step(progress, 1)?;
    match seen {
        Ok(seen) => Ok(Ran {
            row: RunRow::new(&rig.name, &rig.params, &seen),
            end: Ok(hammer.section()),
        }),
        Err(Error::Motion(why)) => Ok(Ran {
            row: RunRow {
                failure: Some(why),
                ..RunRow::failed(&rig.name, &rig.params, frequency_hz)
            },
            end: Err(Error::Motion(why)),
        }),
        Err(error) => Err(error),
    }
}

/// The frequencies (Hz, rising) at which the up and the down sweep differ by more than `share` of force:
/// two attractors over one frequency, between which the hammer jumps. Frequencies at which neither repeats
/// are passed over: the largest force of an aperiodic run depends on how long the run is.
pub fn jumps(up: &[RunRow], down: &[RunRow], weight_n: f64, share: f64) -> Vec<f64> {
    let differs = |(a, b): (&RunRow, &RunRow)| {
        // Against at least the hammer's weight: two nearly silent runs are alike.
        let scale = a.force_n.max(b.force_n).max(weight_n);
        if a.failed || b.failed {
            return None;
        }
        let repeats = |r: &RunRow| r.periods.is_some() || r.regime == Regime::None;
        let differs = (repeats(a) || repeats(b)) && (a.force_n - b.force_n).abs() > share * scale;
        differs.then_some(a.frequency_hz)
    };
    up.iter().zip(down).filter_map(differs).collect()
}

/// `count` frequencies from `from_hz` to `to_hz`, both included.
pub fn spread(from_hz: f64, to_hz: f64, count: usize) -> Vec<f64> {
    let step = (to_hz - from_hz) / (count.max(2) - 1) as f64;
    (0..count).map(|i| from_hz + step * i as f64).collect()
}

/// A measured force curve.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredCurve {
    /// (frequency in Hz, force in N), as read.
    pub points: Vec<(f64, f64)>,
}

/// How far a simulated curve is from a measured one.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct MeasuredError {
    /// Measured points inside the simulated range.
    pub points_compared: usize,
    /// Measured points outside it, not compared.
    pub points_outside: usize,
    /// Root mean square of simulated − measured, N.
    pub rms_n: f64,
    /// Mean of (simulated − measured)/measured, %.
    pub mean_percent: f64,
    /// Largest |simulated − measured|/measured, %.
    pub largest_percent: f64,
}

impl MeasuredCurve {
    /// The error of `rows` (by rising frequency) against this measurement, interpolated linearly.
    pub fn error(&self, rows: &[RunRow]) -> MeasuredError {
        let rows: Vec<&RunRow> = rows.iter().filter(|r| !r.failed).collect();
        let simulated = |frequency_hz: f64| {
            let above = rows.partition_point(|r| r.frequency_hz < frequency_hz);
            let b = rows.get(above)?;
            if b.frequency_hz == frequency_hz {
                return Some(b.force_n);
            }
            let a = rows.get(above.checked_sub(1)?)?;
            let s = (frequency_hz - a.frequency_hz) / (b.frequency_hz - a.frequency_hz);
            Some(a.force_n + s * (b.force_n - a.force_n))
        };
        let pairs: Vec<_> = self
            .points
            .iter()
            .filter_map(|(f, measured)| Some((simulated(*f)?, *measured)))
            .collect();
        let n = pairs.len() as f64;
        let relative = || {
            pairs
                .iter()
                .filter(|p| p.1 != 0.0)
                .map(|(s, m)| (s - m) / m)
        };
        MeasuredError {
            points_compared: pairs.len(),
            points_outside: self.points.len() - pairs.len(),
            rms_n: (pairs.iter().map(|(s, m)| (s - m).powi(2)).sum::<f64>() / n).sqrt(),
            mean_percent: 100.0 * relative().sum::<f64>() / relative().count() as f64,
            largest_percent: 100.0 * relative().fold(0.0, |worst: f64, e| worst.max(e.abs())),
        }
    }
}

/// One run by the reference: for a single figure beside a curve.
///
/// # Errors
/// If a parameter or frequency is out of range, or if the hammer leaves what the model describes, or if the work is
/// interrupted.
pub fn single(
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
) -> Result<RunRow, Error> {
    let rig = NamedRig::new(String::new(), *params);
    let ran = run_one(&rig, Engine::Event, frequency_hz, start, plan, &())?;
    ran.end.map(|_| ran.row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
    use shared::model::params::WIRES;

    const PLAN: Plan = Plan {
        cycles: 160,
        transient: 140,
    };

    fn curve(gap_m: f64, frequencies: &[f64], direction: Direction) -> Vec<RunRow> {
        let rig = NamedRig::new("wires", RigParams { gap_m, ..WIRES });
        sweep(&rig, Engine::Event, frequencies, direction, PLAN, &()).unwrap()
    }

    #[test]
    fn a_large_gap_jumps_and_no_gap_does_not() {
        let frequencies = spread(2.4, 4.0, 33);
        let found = |gap: f64, share: f64| {
            let up = curve(gap, &frequencies, Direction::Up);
            let down = curve(gap, &frequencies, Direction::Down);
            jumps(&up, &down, WIRES.weight_n(), share)
        };
        assert!(found(0.0, 0.02).is_empty());
        let differing = found(2.4e-3, 0.2);
        assert!(differing.len() > 5 && differing[0] > 2.7, "{differing:?}");
    }

    #[test]
    fn what_the_lanes_draw_is_the_references_curve() {
        let frequencies = spread(2.2, 5.2, 25);
        for cart in [CartDrive::Prescribed, CartDrive::Loop(ASSUMED_SHAKER)] {
            let params = RigParams {
                gap_m: 0.5e-3,
                cart,
                ..WIRES
            };
            let rig = NamedRig::new("wires", params);
            for direction in [Direction::Up, Direction::Down] {
                let exact = sweep(&rig, Engine::Event, &frequencies, direction, PLAN, &()).unwrap();
                let in_lanes = |hz: &f64, start| drawn(&rig, *hz, start, PLAN, &());
                let drawn = along(&frequencies, direction, in_lanes).unwrap();
                for (a, b) in exact
                    .iter()
                    .zip(&drawn)
                    .filter(|(a, _)| a.periods.is_some())
                {
                    assert_eq!((a.frequency_hz, a.regime), (b.frequency_hz, b.regime));
                    let off = a.force_n / b.force_n - 1.0;
                    assert!(off.abs() < 1e-3, "{} Hz: {off}", a.frequency_hz);
                }
                assert!(drawn.iter().any(|row| row.contact_time_ms.is_none()));
            }
        }
    }

    #[test]
    fn rows_come_by_rising_frequency_and_do_not_depend_on_threads() {
        let frequencies = spread(2.0, 3.0, 5);
        for direction in [Direction::Rest, Direction::Up, Direction::Down] {
            let rows = curve(0.0, &frequencies, direction);
            let hz: Vec<_> = rows.iter().map(|r| r.frequency_hz).collect();
            assert_eq!(hz, frequencies);
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        let alone = pool.install(|| curve(0.0, &frequencies, Direction::Rest));
        assert_eq!(alone, curve(0.0, &frequencies, Direction::Rest));
    }

    #[test]
    fn the_error_against_a_measurement_made_from_the_curve_is_what_was_put_in() {
        let rows = curve(0.0, &spread(2.0, 3.0, 11), Direction::Rest);
        let points = rows.iter().map(|r| (r.frequency_hz, r.force_n / 1.1));
        let measured = MeasuredCurve {
            points: points.chain([(9.0, 1.0)]).collect(),
        };
        let error = measured.error(&rows);
        assert_eq!((error.points_compared, error.points_outside), (11, 1));
        assert!((error.mean_percent - 10.0).abs() < 1e-9);
        assert!((error.largest_percent - 10.0).abs() < 1e-9);
    }
}
