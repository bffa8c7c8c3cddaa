//! The errors of the analyses in one line each: what is wrong, and the option that mends it. They stand here and not
//! with the command line because a conversion into [`UserError`] must stand in the package of one of the two types.

use numerics::Limits;
use numerics::engine::RATIOS;
use numerics::error::{
    BasinsError, DropTestError, Error, MapError, ModesError, MotionError, PickError, RecordError,
    Side, StartError,
};
use numerics::row::tidy;

use crate::UserError;
use crate::words::digits::significant;

impl From<Error> for UserError {
    fn from(error: Error) -> Self {
        Self::new(line(&error))
    }
}

macro_rules! from_part {
    ($($part:ty),*) => {$(
        impl From<$part> for UserError {
            fn from(part: $part) -> Self {
                Error::from(part).into()
            }
        }
    )*};
}

from_part!(MapError, StartError, MotionError);

fn line(error: &Error) -> String {
    match error {
        Error::Interrupted => "interrupted".to_owned(),
        Error::Parameter(error) => error.to_string(),
        Error::Drive(error) => error.to_string(),
        Error::Preset(name) => format!("there is no preset {name}"),
        Error::Frequency(hz) => {
            format!("the drive frequency is {hz} Hz, must be a positive number, and finite")
        }
        Error::FrequencyRatio {
            frequency_hz,
            ratio,
        } => format!(
            "the drive frequency is {frequency_hz} Hz, {ratio} times the natural frequency; it must be from {} to {} times",
            RATIOS.start(),
            RATIOS.end()
        ),
        Error::Start(error) => start(*error),
        Error::Motion(error) => motion(*error),
        Error::SectionPhase(phase) => {
            format!("the drive phase {phase} is not from 0 to below 1 turn")
        }
        Error::SectionPhaseOrder => {
            "the drive phases of the sections must rise, each given once".to_owned()
        }
        Error::LyapunovPeriods { periods, least } => format!(
            "{periods} drive periods are too few for a Lyapunov exponent; take at least {least}, better thousands"
        ),
        Error::SmoothingWidth(width_m) => {
            format!("the smoothing's width is {width_m} m, must be a positive number")
        }
        Error::Recoil(what) => format!("{what} moves the cart as prescribed only; use --cart prescribed"),
        Error::NoProgress { threshold_n } => format!("the ground holds at every frequency of the range: no force on it reaches {threshold_n} N; widen --ratio or lower --threshold-n"),
        Error::SmoothingLaw => "the smoothing method has no onset, which the Lankarani-Nikravesh law needs; choose another law".to_owned(),
        Error::Map(error) => map(error),
        Error::Basins(error) => basins(*error),
        Error::Modes(error) => modes(*error),
        Error::EndlessContact { law, speed_m_per_s } => format!(
            "{law}: at {speed_m_per_s} m/s the contact does not end; use less damping or a stiffer contact"
        ),
        Error::DropTest(error) => drop_test(*error),
        Error::Record { record, what } => in_record(record, what),
        Error::SearchLeftRange => "the search left the range of the parameters".to_owned(),
        Error::Pick { rig, what } => pick(rig, what),
    }
}

fn start(error: StartError) -> String {
    match error {
        StartError::OutOfReach { displacement_m } => format!(
            "the start displacement {} mm is out of the rig's reach; choose a smaller one",
            displacement_m * 1e3
        ),
        StartError::InsideSurface {
            displacement_m,
            depth_m,
        } => format!(
            "the start displacement {} mm is {} mm inside the impact surface; start at the gap or below",
            displacement_m * 1e3,
            depth_m * 1e3
        ),
        StartError::Phase(phase) => {
            format!("the drive phase at the start is {phase} turns, must be from 0 to below 1")
        }
        StartError::SwitchPhase => {
            "the switch engine starts at drive phase 0; use the event engine for other phases"
                .to_owned()
        }
    }
}

fn motion(error: MotionError) -> String {
    match error {
        MotionError::LeftModel { frequency_hz } => format!(
            "at {frequency_hz:.6} Hz the hammer leaves what the model describes (beyond 1 rad or 1 m); use a smaller amplitude or start, and with the switch engine a shorter tick"
        ),
        MotionError::Lost { frequency_hz } => format!(
            "at {frequency_hz:.6} Hz the motion cannot be followed; check contact stiffness, damping and amplitude, and with the switch engine use a shorter tick"
        ),
        MotionError::TickTooLong {
            frequency_hz,
            needed_s,
        } => format!(
            "at {frequency_hz:.6} Hz a contact under this nonlinear law is too short for the switch engine's tick; use --tick-us {} or less, or the event engine",
            short_of_us(needed_s)
        ),
        MotionError::LostOnSection { frequency_hz } => format!(
            "at {frequency_hz} Hz the hammer leaves what the model describes (beyond 1 rad or 1 m) or cannot be followed; use a smaller amplitude or start"
        ),
        MotionError::Forgotten { frequency_hz } => format!(
            "at {frequency_hz} Hz one drive period forgets the one before beyond what a number can hold (the hammer stays pressed on); there is no exponent to give"
        ),
        MotionError::LostTangent { frequency_hz } => {
            format!("at {frequency_hz} Hz the motion cannot be followed; check amplitude and start")
        }
        MotionError::LostSmoothed { width_m } => {
            format!("the smoothed motion of width {width_m} m cannot be followed; take a wider one")
        }
    }
}

/// The same in a few words, for a row of a table that has the frequency beside it.
pub fn failure(error: MotionError) -> &'static str {
    match error {
        MotionError::LeftModel { .. } => {
            "the hammer leaves what the model describes (beyond 1 rad or 1 m)"
        }
        MotionError::TickTooLong { .. } => "a contact is too short for the tick",
        MotionError::LostOnSection { .. } => {
            "the hammer leaves what the model describes, or cannot be followed"
        }
        MotionError::Forgotten { .. } => "a drive period forgets the one before",
        MotionError::Lost { .. }
        | MotionError::LostTangent { .. }
        | MotionError::LostSmoothed { .. } => "the motion cannot be followed",
    }
}

/// A time in microseconds, rounded down to two digits.
fn short_of_us(time_s: f64) -> f64 {
    let us = time_s * 1e6;
    let digit = 10.0_f64.powf(us.log10().floor() - 1.0);
    // Dividing by a whole number prints without a tail of digits.
    if digit < 1.0 {
        let per_us = (1.0 / digit).round();
        (us * per_us).floor() / per_us
    } else {
        (us / digit).floor() * digit
    }
}

fn map(error: &MapError) -> String {
    match error {
        MapError::Cells { cells, most } => format!(
            "the map has {cells} cells, must have from 1 to {most}; choose other ranges or steps"
        ),
        MapError::NoCycles => "--cycles is 0, must be at least 1".to_owned(),
        MapError::Recorded { recorded, cycles } => {
            format!("--recorded is {recorded}, must be from 1 to the {cycles} drive cycles of a run (--cycles)")
        }
        MapError::Settle { settle, cycles } => {
            format!("--settle is {settle}, must be more than the {cycles} drive cycles of a run (--cycles)")
        }
        MapError::AuditCarried => "--audit runs cells alone, and with --direction up or down each begins where its neighbour ended; leave one of the two out".to_owned(),
    }
}

fn basins(error: BasinsError) -> String {
    match error {
        BasinsError::Window { side, from, to } => {
            let what = match side {
                Side::Displacement => "displacement",
                Side::Velocity => "velocity",
            };
            format!(
                "the window's {what} goes from {from} to {to} (m or m/s); the second must be the larger"
            )
        }
        BasinsError::Phase(phase) => start(StartError::Phase(phase)),
        BasinsError::Cells {
            columns,
            rows,
            most,
        } => format!(
            "a grid of {columns} by {rows} has {} cells; it must have from 1 to {most}",
            columns.saturating_mul(rows)
        ),
        BasinsError::Recorded { recorded, cycles } => {
            format!(
                "--recorded is {recorded}, must be from 1 to the {cycles} drive cycles of a run (--cycles)"
            )
        }
        BasinsError::Until { until, cycles } => {
            format!(
                "--until is {until}, must be at least the {cycles} drive cycles of a run (--cycles)"
            )
        }
    }
}

fn modes(error: ModesError) -> String {
    match error {
        ModesError::NotBeams => {
            "bending modes are those of beam springs; use --rig beam-170, beam-150 or beam-135"
                .to_owned()
        }
        ModesError::Law => {
            "the beam with modes knows one contact law; leave it at spring-dashpot".to_owned()
        }
        ModesError::Gap(gap_m) => format!(
            "gap_mm is {}; the beam with modes starts at rest, free of the surface: 0 or more",
            gap_m * 1e3
        ),
        ModesError::Cubic => {
            "the beam with modes is linear; leave cubic_stiffness_n_per_m3 out".to_owned()
        }
        ModesError::Count { count, most } => {
            format!("{count} modes are asked for; choose from 1 to {most}")
        }
        ModesError::MassRatio { ratio, allowed } => format!(
            "the beam springs' mass is {ratio} of the hammer's; it must be from {} to {}",
            allowed.0, allowed.1
        ),
        ModesError::Lost { frequency_hz } => format!(
            "at {frequency_hz} Hz the motion cannot be followed; check contact stiffness, damping and amplitude"
        ),
    }
}

fn drop_test(error: DropTestError) -> String {
    let mm = |metres: f64| tidy(metres * 1e3);
    match error {
        DropTestError::OutOfReach { release_m } => format!(
            "a release at {} mm is out of the rig's reach; choose a smaller one",
            mm(release_m)
        ),
        DropTestError::NotClear { release_m, gap_m } => format!(
            "a release at {} mm is not clear of the surface, which is at {} mm; let go further out (negative: away from it)",
            mm(release_m),
            mm(gap_m)
        ),
        DropTestError::NoContact => {
            "the hammer never strikes: let go further out, or choose a smaller gap".to_owned()
        }
        DropTestError::NoContactAt { release_m } => format!(
            "let go at {} mm, this rig's hammer never strikes: check --release-mm and --gap",
            mm(release_m)
        ),
        DropTestError::Samples { count, most } => format!(
            "that is {count:.0} samples, more than {most:.0}; use fewer impacts or a lower sampling rate"
        ),
        DropTestError::Lost => {
            "the motion cannot be followed; check contact stiffness, damping and release".to_owned()
        }
    }
}

fn in_record(name: &str, what: &RecordError) -> String {
    match what {
        RecordError::Samples {
            count,
            part_s: (from, to),
            whole_s: (begin, end),
        } => format!(
            "{name}: samples from {from} to {to} s: {count}, at least 16 are needed; it goes from {begin} to {end} s"
        ),
        RecordError::NoForce => {
            format!("{name}: there is no column force_n; a drop test is identified from its force")
        }
        RecordError::NothingToCompare => {
            format!("{name}: neither displacement_mm nor force_n is there to compare")
        }
        RecordError::UnsteadyCart => format!(
            "{name}: the cart does not move at one frequency and phase throughout; cut out a part where it does with --from-s and --to-s, or give --frequency"
        ),
        RecordError::NoContacts => "no contact in the record".to_owned(),
        RecordError::FewContacts(count) => format!(
            "{name}: {count} contacts are too few to find the drive from; give --frequency or --ratio"
        ),
        RecordError::NoFrequency => "no drive frequency to try".to_owned(),
        RecordError::ShorterThanPeriod {
            span_s,
            frequency_hz,
        } => format!(
            "{name}: {span_s:.3} s are less than a drive period at {frequency_hz:.4} Hz; record longer, or give --frequency"
        ),
        RecordError::OnlyNoise { largest_n, .. } if *largest_n == 0.0 => format!(
            "{name}: the force is the same in every sample: no impact to identify from; was the record cut before the first impact?"
        ),
        RecordError::OnlyNoise { largest_n, noise_n } => format!(
            "{name}: the largest force, {} N, does not stand out of the noise of {} N: no impact to identify from",
            significant(*largest_n, 3),
            significant(*noise_n, 3)
        ),
        RecordError::NothingBeforeContact => {
            format!("{name}: no impact has a sample before it; begin the record at the release")
        }
        RecordError::NothingToSearch => "there is nothing to search for".to_owned(),
    }
}

fn pick(rig: &str, what: &PickError) -> String {
    match what {
        PickError::NoOneOne {
            gap_m,
            ratios,
            nearest_gap_m,
        } => {
            let mend = match nearest_gap_m {
                Some(gap_m) => format!("there is one at {:.3} mm", gap_m * 1e3),
                None => "try a larger amplitude".to_owned(),
            };
            format!(
                "rig {rig} has no stable 1/1 at a gap of {:?} mm between {} and {} times its natural frequency; {mend}",
                tidy(gap_m * 1e3),
                ratios.0,
                ratios.1
            )
        }
        PickError::NoneRobust { share } => {
            let nearest = match share {
                Some(share) => format!(
                    "{:.0} % of that uncertainty still allows one",
                    100.0 * share
                ),
                None => "not even a hundredth of it allows one".to_owned(),
            };
            format!(
                "rig {rig}: no frequency gives a stable 1/1 for every rig within the uncertainty; {nearest}: narrow it (--amplitude-percent and the like) or use --nominal"
            )
        }
        PickError::MemberLost { frequency_hz } => format!(
            "rig {rig}: at {frequency_hz:.4} Hz a rig within the uncertainty has no stable 1/1; narrow the uncertainty"
        ),
        PickError::NoAmplitude { wanted_n } => format!(
            "rig {rig}: no amplitude of the cart gives {wanted_n} N with a stable 1/1; ask for another force, or change the gap"
        ),
        PickError::Limits {
            range_hz,
            limits,
            feasible,
        } => format!(
            "rig {rig}: no frequency with a stable 1/1 ({:.4} to {:.4} Hz) keeps {}; {}",
            range_hz.0,
            range_hz.1,
            named(*limits).join(" and "),
            nearest_limits(**feasible)
        ),
    }
}

/// What the limits would have to be at least, four digits, rounded up so that they can be kept.
fn nearest_limits(feasible: Limits) -> String {
    let up = |x: f64| {
        let scale = 10f64.powi(3 - x.abs().log10().floor() as i32);
        (x * scale).ceil() / scale
    };
    let least = named(Limits {
        max_force_n: feasible.max_force_n.map(up),
        max_frequency_hz: feasible.max_frequency_hz.map(up),
        max_shaker_force_n: feasible.max_shaker_force_n.map(up),
        rig_shaker_force_n: feasible.rig_shaker_force_n.map(up),
    });
    match least.as_slice() {
        [] => "relax one of them".to_owned(),
        least => format!("the nearest that can be kept: {}", least.join(" and ")),
    }
}

fn named(limits: Limits) -> Vec<String> {
    let one = |name: &str, limit: Option<f64>| limit.map(|limit| format!("{name} = {limit}"));
    [
        one("max_force_n", limits.max_force_n),
        one("max_frequency_hz", limits.max_frequency_hz),
        one("max_shaker_force_n", limits.max_shaker_force_n),
        one("shaker_max_force_n", limits.rig_shaker_force_n),
    ]
    .into_iter()
    .flatten()
    .collect()
}
