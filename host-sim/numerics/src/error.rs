//! Why an analysis has no answer, as values: what is wrong, where, and in one line for a person how to mend it. What the line calls an
//! option is the command line's; others put their own name in its place.

mod words;

use shared::model::drive::DriveError;
use shared::model::params::ParamError;
use thiserror::Error;

use crate::engine::RATIOS;
use crate::limits::PickLimits;
use words::{in_record, mm, named, nearest_limits, only_noise, other_gap, share_left, short_of_us};

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Error {
    /// The work was asked to stop ([`crate::progress::Progress::interrupted`]).
    #[error("interrupted")]
    Interrupted,
    /// A parameter of the rig is out of range.
    #[error(transparent)]
    Parameter(#[from] ParamError),
    /// The switch model cannot be driven at this frequency and tick.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// There is no preset of this name.
    #[error("there is no preset {0}")]
    Preset(String),
    /// The drive frequency, Hz, is not a positive number.
    #[error("the drive frequency is {0} Hz, must be a positive number, and finite")]
    Frequency(f64),
    /// The drive frequency is too far from the natural frequency ([`crate::engine::RATIOS`]).
    #[error(
        "the drive frequency is {frequency_hz} Hz, {ratio} times the natural frequency; it must be from {} to {} times",
        RATIOS.start(),
        RATIOS.end()
    )]
    FrequencyRatio {
        /// Drive frequency, Hz.
        frequency_hz: f64,
        /// Drive frequency over the natural frequency, Ω/ω.
        ratio: f64,
    },
    /// A run cannot begin so.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The motion cannot be followed.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A number of a request is out of its range.
    #[error("--{option} is {value}, must be from {low} to {high}")]
    OutOfRange {
        /// The command line's option for it.
        option: &'static str,
        /// What it is.
        value: f64,
        /// The least it can be.
        low: f64,
        /// The most it can be.
        high: f64,
    },
    /// The release, mm, is no number.
    #[error("--release-mm is {0}, must be a number")]
    Release(f64),
    /// More random samples than there can be.
    #[error("--samples is {samples}, must be at most {most}")]
    Samples {
        /// How many were asked for.
        samples: u32,
        /// The most there can be.
        most: u32,
    },
    /// No cycle of a run would be recorded.
    #[error(
        "--transient {transient} leaves nothing of the {cycles} drive cycles of a run to record; give --cycles more than {transient}, or a smaller --transient"
    )]
    NothingLeft {
        /// How many of the first are not recorded.
        transient: u32,
        /// How many are run.
        cycles: u32,
    },
    /// A drive phase at which a section is taken, turns, is not from 0 to below 1.
    #[error("--phase is {0}, must be from 0 to below 1 turn")]
    SectionPhase(f64),
    /// The drive phases of the sections do not rise.
    #[error("the drive phases of the sections must rise, each given once")]
    SectionPhaseOrder,
    /// Too few drive periods for a Lyapunov exponent.
    #[error(
        "{periods} drive periods are too few for a Lyapunov exponent; take at least {least}, better thousands"
    )]
    LyapunovPeriods {
        /// How many were asked for.
        periods: u32,
        /// The least there can be.
        least: u32,
    },
    /// The width of the smoothing, m, is not a positive number.
    #[error("the smoothing's width is {0} m, must be a positive number")]
    SmoothingWidth(f64),
    /// The ground does not give way anywhere in the range of frequencies.
    #[error(
        "the ground holds at every frequency of the range: no force on it reaches {threshold_n} N; widen --ratio or lower --threshold-n"
    )]
    NoProgress {
        /// Threshold force Pf at which the ground gives way, N.
        threshold_n: f64,
    },
    /// This moves the cart as prescribed only; the rig's recoils.
    #[error("{0} moves the cart as prescribed only; use --cart prescribed")]
    Recoil(&'static str),
    /// The smoothing method has no onset, whose speed the contact law needs.
    #[error(
        "the smoothing method has no onset, whose speed this contact law needs; choose another contact_law"
    )]
    SmoothingLaw,
    /// The recorded cycles are none, or more than are run.
    #[error(
        "--recorded is {recorded}, must be from 1 to the {cycles} drive cycles of a run (--cycles)"
    )]
    Recorded {
        /// How many are to be recorded.
        recorded: u32,
        /// How many are run.
        cycles: u32,
    },
    /// A map cannot be made so.
    #[error(transparent)]
    Map(#[from] MapError),
    /// There is no such plane of two parameters.
    #[error(transparent)]
    Plane(#[from] PlaneError),
    /// Basins cannot be computed so.
    #[error(transparent)]
    Basins(#[from] BasinsError),
    /// A beam with several bending modes cannot be computed so.
    #[error(transparent)]
    Modes(#[from] ModesError),
    /// At this speed the contact of a free mass with a wall does not end.
    #[error(
        "{law}: at {speed_m_per_s} m/s the contact does not end; use less damping or a stiffer contact"
    )]
    EndlessContact {
        /// Name of the contact law.
        law: String,
        /// Speed of the mass into the wall at the onset, m/s.
        speed_m_per_s: f64,
    },
    /// A drop test cannot be made so.
    #[error(transparent)]
    DropTest(#[from] DropTestError),
    /// A record does not hold what is sought in it.
    #[error("{}", in_record(.record, .what))]
    Record {
        /// Name of the record.
        record: String,
        /// What the record lacks.
        what: RecordError,
    },
    /// The search for contact parameters ends outside their range.
    #[error("the search left the range of the parameters")]
    SearchLeftRange,
    /// There is no operating point.
    #[error("rig {rig}{what}")]
    Pick {
        /// Name of the rig.
        rig: String,
        /// Why there is no operating point.
        what: PickError,
    },
}

/// Why a run cannot begin.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum StartError {
    /// The rig cannot be displaced so far.
    #[error(
        "the start displacement {} mm is out of the rig's reach; choose a smaller one",
        .displacement_m * 1e3
    )]
    OutOfReach {
        /// Displacement relative to the cart, m.
        displacement_m: f64,
    },
    /// The hammer would begin inside the impact surface.
    #[error(
        "the start displacement {} mm is {} mm inside the impact surface; start at the gap or below",
        .displacement_m * 1e3,
        .depth_m * 1e3
    )]
    InsideSurface {
        /// Displacement relative to the cart, m.
        displacement_m: f64,
        /// How deep inside the surface that is, m.
        depth_m: f64,
    },
    /// The drive phase, turns, is not from 0 to below 1.
    #[error("the drive phase at the start is {0} turns, must be from 0 to below 1")]
    Phase(f64),
    /// The switch model begins at drive phase 0 only.
    #[error("the switch engine starts at drive phase 0; use the event engine for other phases")]
    SwitchPhase,
}

/// Why a motion cannot be followed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MotionError {
    /// The hammer leaves what the model describes: beyond 1 rad or 1 m.
    #[error(
        "at {frequency_hz:.6} Hz the hammer leaves the model's range (1 rad or 1 m); use a smaller amplitude or start, and with the switch engine a shorter tick"
    )]
    LeftModel {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The state is no longer a number.
    #[error(
        "at {frequency_hz:.6} Hz the motion cannot be followed; check contact stiffness, damping and amplitude, and with the switch engine use a shorter tick"
    )]
    Lost {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The switch model's tick is too long for a contact under a nonlinear law.
    #[error(
        "at {frequency_hz:.6} Hz a contact under this nonlinear law is too short for the switch engine's tick; use --tick-us {} or less, or the event engine",
        short_of_us(*.needed_s)
    )]
    TickTooLong {
        /// Drive frequency, Hz.
        frequency_hz: f64,
        /// A tick that is short enough, s.
        needed_s: f64,
    },
    /// The hammer leaves what the model describes, or cannot be followed, while a section is collected.
    #[error(
        "at {frequency_hz} Hz the hammer leaves the model's range (1 rad or 1 m) or cannot be followed; use a smaller amplitude or start"
    )]
    LostOnSection {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// A drive period forgets the one before beyond what a number can hold: there is no Lyapunov exponent.
    #[error(
        "at {frequency_hz} Hz a disturbance vanishes within one drive period (the hammer stays pressed on); there is no exponent"
    )]
    Forgotten {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The state is no longer a number while a Lyapunov exponent is computed.
    #[error("at {frequency_hz} Hz the motion cannot be followed; check amplitude and start")]
    LostTangent {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The smoothed motion cannot be followed at this width.
    #[error("the smoothed motion of width {width_m} m cannot be followed; take a wider one")]
    LostSmoothed {
        /// Width of the smoothing, m.
        width_m: f64,
    },
}

/// Why a plane of two parameters cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlaneError {
    /// Both are the same.
    #[error("--curve {0}: the two parameters must differ")]
    Same(&'static str),
    /// The rig has no such numbers.
    #[error(
        "--curve: this rig's support, contact law or cart has no {0}; change the rig or the parameter"
    )]
    NotOfRig(String),
    /// There is no rig at a corner.
    #[error("--curve: {0}")]
    Parameter(#[from] ParamError),
}

/// Why a map cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MapError {
    /// No cells, or too many.
    #[error("the map has {cells} cells, must have from 1 to {most}; choose other ranges or steps")]
    Cells {
        /// How many cells the map would have.
        cells: usize,
        /// The most there can be.
        most: usize,
    },
    /// No cycles to run.
    #[error("--cycles is 0, must be at least 1")]
    NoCycles,
    /// Cells that have not settled would run no further than the others.
    #[error(
        "--settle is {settle}, must be more than the {cycles} drive cycles of a run (--cycles)"
    )]
    Settle {
        /// Cycles they run to.
        settle: u32,
        /// Cycles all run to.
        cycles: u32,
    },
    /// Single cells cannot be audited where each begins as its neighbour ended.
    #[error(
        "--audit runs cells alone, and with --direction up or down each begins where its neighbour ended; leave one of the two out"
    )]
    AuditCarried,
}

/// Why basins cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BasinsError {
    /// A side of the window of starts does not rise.
    #[error(
        "the window's {side} goes from {from} to {to} (m or m/s); the second must be the larger"
    )]
    Window {
        /// Side of the window that does not rise: "displacement" or "velocity".
        side: &'static str,
        /// Value at which the side begins, m or m/s.
        from: f64,
        /// Value at which the side ends, m or m/s.
        to: f64,
    },
    /// The grid has no cells, or too many.
    #[error(
        "a grid of {columns} by {rows} has {} cells; it must have from 1 to {most}",
        .columns.saturating_mul(*.rows)
    )]
    Cells {
        /// Columns of the grid.
        columns: usize,
        /// Rows of the grid.
        rows: usize,
        /// The most cells there can be.
        most: usize,
    },
    /// The random starts would run no further than the grid's.
    #[error("--until is {until}, must be at least the {cycles} drive cycles of a run (--cycles)")]
    Until {
        /// Cycles they run to.
        until: u32,
        /// Cycles all run to.
        cycles: u32,
    },
}

/// Why a beam with several bending modes cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ModesError {
    /// The rig hangs on wires.
    #[error("bending modes are those of beam springs; use --rig beam-170, beam-150 or beam-135")]
    NotBeams,
    /// The contact law is not the spring-dashpot.
    #[error(
        "the beam with modes has only the spring-dashpot law; leave contact_law at spring-dashpot"
    )]
    Law,
    /// The gap, m, is negative: the hammer would rest pressed against the surface.
    #[error(
        "gap_mm is {}; the beam with modes starts at rest, free of the surface: 0 or more",
        .0 * 1e3
    )]
    Gap(f64),
    /// The beam has a cubic stiffness.
    #[error("the beam with modes is linear; leave cubic_stiffness_n_per_m3 out")]
    Cubic,
    /// So many modes cannot be computed.
    #[error("the number of modes is {count}; choose from 1 to {most}")]
    Count {
        /// How many were asked for.
        count: usize,
        /// The most there can be.
        most: usize,
    },
    /// The mass of the beam springs over the hammer's is out of range.
    #[error(
        "the beam springs' mass is {ratio} of the hammer's; it must be from {} to {}",
        .allowed.0,
        .allowed.1
    )]
    MassRatio {
        /// Mass of the beam springs over the hammer's.
        ratio: f64,
        /// The least and the largest.
        allowed: (f64, f64),
    },
    /// The motion cannot be followed.
    #[error(
        "at {frequency_hz} Hz the motion cannot be followed; check contact stiffness, damping and amplitude"
    )]
    Lost {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
}

/// Why a drop test cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum DropTestError {
    /// The rig cannot be displaced so far.
    #[error("a release at {} mm is out of the rig's reach; choose a smaller one", mm(*.release_m))]
    OutOfReach {
        /// Displacement at the release, m.
        release_m: f64,
    },
    /// The release is not clear of the surface.
    #[error(
        "a release at {} mm is not clear of the surface, which is at {} mm; release it farther out (negative: away from it)",
        mm(*.release_m),
        mm(*.gap_m)
    )]
    NotClear {
        /// Displacement at the release, m.
        release_m: f64,
        /// Displacement at which the surface begins: the gap, m.
        gap_m: f64,
    },
    /// The hammer never reaches the surface.
    #[error("the hammer never strikes: release it farther out, or choose a smaller gap")]
    NoContact,
    /// The hammer of the identification never reaches the surface.
    #[error(
        "released at {} mm, this rig's hammer never strikes: check --release-mm and --gap",
        mm(*.release_m)
    )]
    NoContactAt {
        /// Displacement at the release, m.
        release_m: f64,
    },
    /// The record would have too many samples.
    #[error(
        "that is {count:.0} samples, more than {most:.0}; use fewer impacts or a lower sampling rate"
    )]
    Samples {
        /// How many it would be.
        count: f64,
        /// The most there can be.
        most: f64,
    },
    /// The motion cannot be followed.
    #[error("the motion cannot be followed; check contact stiffness, damping and release")]
    Lost,
}

/// What a record lacks.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordError {
    /// Too few samples in the chosen part.
    #[error(
        "samples from {} to {} s: {count}, at least 16 are needed; it goes from {} to {} s",
        .part_s.0, .part_s.1, .whole_s.0, .whole_s.1
    )]
    Samples {
        /// How many there are.
        count: usize,
        /// Beginning and end of the part, s.
        part_s: (f64, f64),
        /// Beginning and end of the record, s.
        whole_s: (f64, f64),
    },
    /// The contact force, from which impacts are found.
    #[error("there is no column force_n; a drop test is identified from its force")]
    NoForce,
    /// Displacement or force: one of them at least is compared.
    #[error("the record has neither displacement_mm nor force_n to compare")]
    NothingToCompare,
    /// A cart that moves at one frequency and phase throughout.
    #[error(
        "the cart's frequency or phase changes in the record; choose a part without a change with --from-s and --to-s, or give --frequency"
    )]
    UnsteadyCart,
    /// Any contact to find the drive frequency from.
    #[error("no contact in the record")]
    NoContacts,
    /// Enough contacts to find the drive frequency from.
    #[error(
        "{0} contacts are too few to determine the drive frequency; give --frequency or --ratio"
    )]
    FewContacts(usize),
    /// A drive frequency to try.
    #[error("no drive frequency to try")]
    NoFrequency,
    /// A whole drive period.
    #[error(
        "{span_s:.3} s are less than a drive period at {frequency_hz:.4} Hz; record longer, or give --frequency"
    )]
    ShorterThanPeriod {
        /// Length of the record, s.
        span_s: f64,
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// A contact that stands out of the noise.
    #[error("{}", only_noise(*.largest_n, *.noise_n))]
    OnlyNoise {
        /// Largest force in the record over its zero, N.
        largest_n: f64,
        /// Standard deviation of the force without contact, at least that of its rounding, N.
        noise_n: f64,
    },
    /// A sample before the first contact.
    #[error("no impact has a sample before it; begin the record at the release")]
    NothingBeforeContact,
    /// Parameters to search for.
    #[error("there is nothing to search for")]
    NothingToSearch,
}

/// Why there is no operating point.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PickError {
    /// There is no stable 1/1.
    #[error(
        " has no stable 1/1 at a gap of {:?} mm between {} and {} times its natural frequency; {}",
        mm(*.gap_m),
        .ratios.0,
        .ratios.1,
        other_gap(*.nearest_gap_m)
    )]
    NoOneOne {
        /// Clearance at rest, m.
        gap_m: f64,
        /// The ratios Ω/ω that were searched.
        ratios: (f64, f64),
        /// A gap at which there is one, m: the nearest on the way to 0 that was tried. None if there is none at 0 either.
        nearest_gap_m: Option<f64>,
    },
    /// No frequency has a stable 1/1 for every rig within the uncertainty.
    #[error(
        ": no frequency gives a stable 1/1 for every rig within the uncertainty; {}: narrow it (--amplitude-percent and the like) or use --nominal",
        share_left(*.share)
    )]
    NoneRobust {
        /// With this share of the uncertainty there is one. None if there is none even for a hundredth of it.
        share: Option<f64>,
    },
    /// A rig within the uncertainty has no stable 1/1.
    #[error(
        ": at {frequency_hz:.4} Hz a rig within the uncertainty has no stable 1/1; narrow the uncertainty"
    )]
    MemberLost {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// No amplitude gives the force wanted.
    #[error(
        ": no amplitude of the cart gives {wanted_n} N with a stable 1/1; ask for another force, or change the gap"
    )]
    NoAmplitude {
        /// Contact force that is wanted, N.
        wanted_n: f64,
    },
    /// No frequency keeps the limits.
    #[error(
        ": no frequency with a stable 1/1 ({:.4} to {:.4} Hz) keeps {}; {}",
        .range_hz.0,
        .range_hz.1,
        named(*.limits).join(" and "),
        nearest_limits(**.feasible)
    )]
    Limits {
        /// Where a stable 1/1 is, Hz.
        range_hz: (f64, f64),
        /// Limits that were asked for.
        limits: PickLimits,
        /// What those of them that cannot be kept would have to be at least.
        feasible: Box<PickLimits>,
    },
}

impl MotionError {
    /// What went wrong in a few words, for a row of a table that has the frequency beside it.
    pub fn in_few_words(self) -> &'static str {
        match self {
            MotionError::LeftModel { .. } => "the hammer leaves the model's range (1 rad or 1 m)",
            MotionError::TickTooLong { .. } => "a contact is too short for the tick",
            MotionError::LostOnSection { .. } => {
                "the hammer leaves the model's range, or its motion cannot be followed"
            }
            MotionError::Forgotten { .. } => "a disturbance vanishes within a drive period",
            MotionError::Lost { .. }
            | MotionError::LostTangent { .. }
            | MotionError::LostSmoothed { .. } => "the motion cannot be followed",
        }
    }
}
