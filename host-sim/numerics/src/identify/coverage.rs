//! How often the 95 % intervals hold the truth, with sensors as they are: each case is a fault of the sensor, or a
//! law that is not the record's, and each is tried on many drop tests made from the model.

use serde::Serialize;
use shared::model::contact::{LAWS, Law, LawKind};
use shared::model::number::Number;
use shared::model::params::{RigParams, WIRES};

use super::quiet::median;
use super::{IdentifiedFit, Misfit, SearchSettings, fit, measure};
use crate::drop_test::{Converter, DropTest, record};
use crate::error::Error;
use crate::noise::Noise;
use crate::parallel;
use crate::progress::Progress;
use crate::signal::Signal;

/// Peak of the nominal drop test (wires, released at −3 mm), N: shares of the peak are shares of this.
pub const PEAK_N: f64 = 41.5;

/// The noise of cases about something else, as a share of [`PEAK_N`].
const USUAL_NOISE: f64 = 0.002;

/// Releases are drawn evenly up to this share about the nominal one, so that no two records are sampled alike.
const RELEASE_SPREAD: f64 = 0.1;

/// A sensor and a law on which the intervals are tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverageCase {
    /// Name of the case in the table.
    pub name: &'static str,
    /// The sensor; release and seed are drawn.
    pub test: DropTest,
    /// The law the record is made with.
    pub truth: Law<f64>,
    /// The law that is fitted.
    pub family: LawKind,
}

impl CoverageCase {
    /// Whether the fitted law is the record's.
    pub fn law_is_right(&self) -> bool {
        self.truth.kind() == self.family
    }

    /// What the parameters should be.
    fn sought(&self) -> Vec<f64> {
        let mut truth = self.truth;
        let sought = truth.kind().without_exponent();
        sought
            .filter_map(|number| truth.number_mut(number.key).copied())
            .collect()
    }
}

/// All cases, in the order of the table: each is the usual test with what is said of it changed.
pub fn cases() -> Vec<CoverageCase> {
    let dashpot = |name, change: fn(&mut DropTest)| {
        let mut test = DropTest {
            noise_n: USUAL_NOISE * PEAK_N,
            ..DropTest::default()
        };
        change(&mut test);
        CoverageCase {
            name,
            test,
            truth: LAWS[0].1,
            family: LawKind::SpringDashpot,
        }
    };
    let crossley = |name, family| CoverageCase {
        truth: LAWS[2].1,
        family,
        ..dashpot(name, |_| ())
    };
    vec![
        dashpot("noise-0.1-percent", |test| test.noise_n = 0.001 * PEAK_N),
        dashpot("noise-0.2-percent", |_| ()),
        dashpot("noise-0.5-percent", |test| test.noise_n = 0.005 * PEAK_N),
        dashpot("noise-1-percent", |test| test.noise_n = 0.01 * PEAK_N),
        dashpot("noise-2-percent", |test| test.noise_n = 0.02 * PEAK_N),
        dashpot("noise-5-percent", |test| test.noise_n = 0.05 * PEAK_N),
        dashpot("gain-2-percent", |test| test.force_gain_percent = 2.0),
        dashpot("ringing-3-khz", |test| test.ringing_share = 0.5),
        dashpot("bits-10", |test| {
            test.bits = 10;
            test.noise_n = 0.0;
        }),
        dashpot("bits-10-noise", |test| test.bits = 10),
        dashpot("filter-10-khz", |test| test.filter_hz = 10e3),
        dashpot("filter-6-khz", |test| test.filter_hz = 6e3),
        dashpot("filter-3-khz", |test| test.filter_hz = 3e3),
        dashpot("release-1-percent", |test| {
            test.displacement_gain_percent = 1.0;
        }),
        dashpot("drift", |test| test.drift_n_per_s = 0.5),
        dashpot("everything", |test| {
            test.force_gain_percent = 2.0;
            test.ringing_share = 0.2;
            test.bits = 10;
            test.filter_hz = 6e3;
            test.displacement_gain_percent = 1.0;
            test.offset_n = 1.0;
            test.drift_n_per_s = 0.5;
        }),
        dashpot("digital-filter", |test| test.converter = Converter::Iir),
        dashpot("linear-phase-filter", |test| {
            test.converter = Converter::Fir;
        }),
        dashpot("mean-of-three", |test| test.converter = Converter::Mean),
        dashpot("delta-sigma", |test| {
            test.converter = Converter::DeltaSigma;
        }),
        dashpot("clock-1-percent", |test| test.clock_fast_percent = 1.0),
        dashpot("steps", |test| test.step_n = 0.5),
        crossley("hunt-crossley-as-dashpot", LawKind::SpringDashpot),
        crossley("hunt-crossley", LawKind::HuntCrossley),
    ]
}

/// A line of the table: one parameter of one case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoverageRow {
    /// Name of the case.
    pub case: &'static str,
    /// What was made small.
    pub misfit: Misfit,
    /// The parameter, as rig files name it.
    pub parameter: &'static str,
    /// Drop tests tried, those that failed included.
    pub tests: usize,
    /// Tests with the right answer: the interval holds the truth; or the law is not the record's and is refused.
    pub right: usize,
    /// Tests in which the law was refused as one that does not fit, or no interval was given.
    pub refused: usize,
    /// Tests in which the interval has no end on one side or both.
    pub unbounded: usize,
    /// Tests that ended with an error.
    pub failed: usize,
    /// Median of the error of the value, %; none if the law is not the record's.
    pub median_error_percent: Option<f64>,
    /// Median of half the interval's width over the truth, %, of the bounded ones.
    pub median_half_width_percent: Option<f64>,
}

/// The answer of one drop test: of each parameter error and interval over the truth; `None` if there is no interval.
type Outcome = Result<Option<Vec<Seen>>, ()>;

#[derive(Clone, Copy)]
struct Seen {
    error: f64,
    low: Option<f64>,
    high: Option<f64>,
}

/// The table of `cases`, `tests` drop tests each, for each of `misfits`; a step of `progress` is a drop test by one
/// misfit. The same for any number of threads.
///
/// # Errors
/// If the work was interrupted.
pub fn table(
    cases: &[CoverageCase],
    misfits: &[Misfit],
    tests: usize,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Vec<CoverageRow>, Error> {
    let numbers: Vec<usize> = (0..tests).collect();
    let mut rows = Vec::new();
    for case in cases {
        for misfit in misfits {
            let outcomes = parallel::try_map(&numbers, |number| {
                crate::progress::check(progress)?;
                let outcome = one(case, *misfit, seed, *number);
                progress.advance(1);
                Ok(outcome)
            })?;
            rows.extend(summary(case, *misfit, &outcomes));
        }
    }
    Ok(rows)
}

/// One drop test and its fit.
fn one(case: &CoverageCase, misfit: Misfit, seed: u64, number: usize) -> Outcome {
    let own = seed.wrapping_mul(1_000_003).wrapping_add(number as u64);
    let drawn = Noise::new(own ^ 0x5eed).even();
    let test = DropTest {
        release_m: case.test.release_m * (1.0 + RELEASE_SPREAD * (2.0 * drawn - 1.0)),
        seed: own,
        ..case.test
    };
    let fitted = identified(case, &test, misfit).map_err(|_| ())?;
    if !fitted.intervals {
        return Ok(None);
    }
    let sought = case.sought();
    let over = |(estimate, truth): (&super::ProfileEstimate, &f64)| {
        let off = |x: f64| x / truth - 1.0;
        Seen {
            error: off(estimate.value),
            low: estimate.low.map(off),
            high: estimate.high.map(off),
        }
    };
    Ok(Some(
        fitted.parameters.iter().zip(&sought).map(over).collect(),
    ))
}

/// What `identify` makes of such a record.
///
/// # Errors
/// If the record cannot be made or shows no impact.
pub fn identified(
    case: &CoverageCase,
    test: &DropTest,
    misfit: Misfit,
) -> Result<IdentifiedFit, Error> {
    let params = RigParams {
        contact: case.truth,
        ..WIRES
    };
    let rows = record(&params, test)?;
    let read = 1.0 + 0.01 * test.displacement_gain_percent;
    let settings = SearchSettings {
        release_m: test.release_m * read,
        impacts: 6,
        // A clock that is off is stated to be.
        clock_percent: test
            .clock_fast_percent
            .abs()
            .max(SearchSettings::DEFAULT.clock_percent),
        ..SearchSettings::default()
    };
    let signal = Signal {
        name: case.name.into(),
        time_s: rows.iter().map(|r| r.time_s).collect(),
        force_n: Some(rows.iter().map(|r| r.force_n).collect()),
        ..Signal::default()
    };
    // The rig of the identification knows nothing of the contact.
    fit(
        &measure(&signal, &settings)?,
        &WIRES,
        case.family,
        misfit,
        &settings,
    )
}

fn summary(case: &CoverageCase, misfit: Misfit, outcomes: &[Outcome]) -> Vec<CoverageRow> {
    let right_law = case.law_is_right();
    let row = |(i, number): (usize, Number)| {
        let seen: Vec<Seen> = outcomes
            .iter()
            .filter_map(|o| o.as_ref().ok()?.as_ref()?.get(i).copied())
            .collect();
        let refused = outcomes.iter().filter(|o| matches!(o, Ok(None))).count();
        let holds =
            |s: &&Seen| s.low.is_none_or(|low| low <= 0.0) && s.high.is_none_or(|high| high >= 0.0);
        let widths = seen.iter().filter_map(|s| Some(50.0 * (s.high? - s.low?)));
        CoverageRow {
            case: case.name,
            misfit,
            parameter: number.key,
            tests: outcomes.len(),
            right: if right_law {
                seen.iter().filter(holds).count()
            } else {
                refused
            },
            refused,
            unbounded: seen
                .iter()
                .filter(|s| s.low.is_none() || s.high.is_none())
                .count(),
            failed: outcomes.iter().filter(|o| o.is_err()).count(),
            median_error_percent: median(seen.iter().map(|s| 100.0 * s.error))
                .filter(|_| right_law),
            median_half_width_percent: median(widths).filter(|_| right_law),
        }
    };
    case.family
        .without_exponent()
        .enumerate()
        .map(row)
        .collect()
}
