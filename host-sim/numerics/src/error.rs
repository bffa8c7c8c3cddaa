//! Why an analysis has no answer, as values: what is wrong, and where. The words for people are the caller's.

use std::fmt;

use shared::model::drive::DriveError;
use shared::model::params::ParamError;

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Error {
    /// The work was asked to stop ([`crate::progress::Progress::interrupted`]).
    Interrupted,
    /// A parameter of the rig is out of range.
    Parameter(ParamError),
    /// The switch model cannot be driven at this frequency and tick.
    Drive(DriveError),
    /// There is no preset of this name.
    Preset(String),
    /// The drive frequency, Hz, is not a positive number.
    Frequency(f64),
    /// The drive frequency is too far from the natural frequency ([`crate::engine::RATIOS`]).
    FrequencyRatio {
        /// Hz.
        frequency_hz: f64,
        /// Ω/ω.
        ratio: f64,
    },
    /// A run cannot begin so.
    Start(StartError),
    /// The motion cannot be followed.
    Motion(MotionError),
    /// A drive phase at which a section is taken, turns, is not from 0 to below 1.
    SectionPhase(f64),
    /// The drive phases of the sections do not rise.
    SectionPhaseOrder,
    /// Too few drive periods for a Lyapunov exponent.
    LyapunovPeriods {
        /// How many were asked for.
        periods: u32,
        /// The least there can be.
        least: u32,
    },
    /// The width of the smoothing, m, is not a positive number.
    SmoothingWidth(f64),
    /// The ground does not give way anywhere in the range of frequencies.
    NoProgress {
        /// Pf, N.
        threshold_n: f64,
    },
    /// This moves the cart as prescribed only; the rig's recoils.
    Recoil(&'static str),
    /// The smoothing method has no onset, which the Lankarani–Nikravesh law needs.
    SmoothingLaw,
    /// A map cannot be made so.
    Map(MapError),
    /// Basins cannot be computed so.
    Basins(BasinsError),
    /// A beam with several bending modes cannot be computed so.
    Modes(ModesError),
    /// At this speed the contact of a free mass with a wall does not end.
    EndlessContact {
        /// Name of the contact law.
        law: String,
        /// Approach speed, m/s.
        speed_m_per_s: f64,
    },
    /// A drop test cannot be made so.
    DropTest(DropTestError),
    /// A record does not hold what is sought in it.
    Record {
        /// Name of the record.
        record: String,
        /// What is missing.
        what: RecordError,
    },
    /// The search for contact parameters ends outside their range.
    SearchLeftRange,
    /// There is no operating point.
    Pick {
        /// Name of the rig.
        rig: String,
        /// Why.
        what: PickError,
    },
}

/// Why a run cannot begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartError {
    /// The rig cannot be displaced so far.
    OutOfReach {
        /// Displacement relative to the cart, m.
        displacement_m: f64,
    },
    /// The hammer would begin inside the impact surface.
    InsideSurface {
        /// Displacement relative to the cart, m.
        displacement_m: f64,
        /// How deep, m.
        depth_m: f64,
    },
    /// The drive phase, turns, is not from 0 to below 1.
    Phase(f64),
    /// The switch model begins at drive phase 0 only.
    SwitchPhase,
}

/// Why a motion cannot be followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionError {
    /// The hammer leaves what the model describes: beyond 1 rad or 1 m.
    LeftModel {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The state is no longer a number.
    Lost {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The switch model's tick is too long for a contact under a nonlinear law.
    TickTooLong {
        /// Drive frequency, Hz.
        frequency_hz: f64,
        /// A tick that is short enough, s.
        needed_s: f64,
    },
    /// The same two, where the section is collected.
    LostOnSection {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// A drive period forgets the one before beyond what a number can hold: there is no Lyapunov exponent.
    Forgotten {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The state is no longer a number while a Lyapunov exponent is computed.
    LostTangent {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// The smoothed motion cannot be followed at this width.
    LostSmoothed {
        /// Width of the smoothing, m.
        width_m: f64,
    },
}

/// Why a map cannot be made.
#[derive(Clone, Debug, PartialEq)]
pub enum MapError {
    /// No cells, or too many.
    Cells {
        /// How many.
        cells: usize,
        /// The most there can be.
        most: usize,
    },
    /// No cycles to run.
    NoCycles,
    /// The recorded cycles are none, or more than are run.
    Recorded {
        /// How many are to be recorded.
        recorded: u32,
        /// How many are run.
        cycles: u32,
    },
    /// Cells that have not settled would run no further than the others.
    Settle {
        /// Cycles they run to.
        settle: u32,
        /// Cycles all run to.
        cycles: u32,
    },
    /// Single cells cannot be audited where each begins as its neighbour ended.
    AuditCarried,
}

/// Why basins cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BasinsError {
    /// A side of the window of starts does not rise.
    Window {
        /// Which.
        side: Side,
        /// From which value, m or m/s.
        from: f64,
        /// To which.
        to: f64,
    },
    /// The drive phase at the start, turns, is not from 0 to below 1.
    Phase(f64),
    /// The grid has no cells, or too many.
    Cells {
        /// Columns.
        columns: usize,
        /// Rows.
        rows: usize,
        /// The most cells there can be.
        most: usize,
    },
    /// The recorded cycles are none, or more than are run.
    Recorded {
        /// How many are to be recorded.
        recorded: u32,
        /// How many are run.
        cycles: u32,
    },
    /// The random starts would run no further than the grid's.
    Until {
        /// Cycles they run to.
        until: u32,
        /// Cycles all run to.
        cycles: u32,
    },
}

/// A side of the window of starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Displacements.
    Displacement,
    /// Velocities.
    Velocity,
}

/// Why a beam with several bending modes cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModesError {
    /// The rig hangs on wires.
    NotBeams,
    /// The contact law is not the spring-dashpot.
    Law,
    /// The gap, m, is negative: the hammer would rest pressed against the surface.
    Gap(f64),
    /// The beam has a cubic stiffness.
    Cubic,
    /// So many modes cannot be computed.
    Count {
        /// How many were asked for.
        count: usize,
        /// The most there can be.
        most: usize,
    },
    /// The mass of the beam springs over the hammer's is out of range.
    MassRatio {
        /// The ratio.
        ratio: f64,
        /// The least and the largest.
        allowed: (f64, f64),
    },
    /// The motion cannot be followed.
    Lost {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
}

/// Why a drop test cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DropTestError {
    /// The rig cannot be displaced so far.
    OutOfReach {
        /// Displacement at the release, m.
        release_m: f64,
    },
    /// The release is not clear of the surface.
    NotClear {
        /// Displacement at the release, m.
        release_m: f64,
        /// The gap, m.
        gap_m: f64,
    },
    /// The hammer never reaches the surface.
    NoContact,
    /// The hammer of the identification never reaches the surface.
    NoContactAt {
        /// Displacement at the release, m.
        release_m: f64,
    },
    /// Too many samples.
    Samples {
        /// How many it would be.
        count: f64,
        /// The most there can be.
        most: f64,
    },
    /// The motion cannot be followed.
    Lost,
}

/// What a record lacks.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordError {
    /// Too few samples in the chosen part.
    Samples {
        /// How many there are.
        count: usize,
        /// Beginning and end of the part, s.
        part_s: (f64, f64),
        /// Beginning and end of the record, s.
        whole_s: (f64, f64),
    },
    /// The contact force.
    NoForce,
    /// Displacement and force.
    NothingToCompare,
    /// A cart that moves at one frequency and phase throughout.
    UnsteadyCart,
    /// Any contact.
    NoContacts,
    /// Enough contacts to find the drive frequency from.
    FewContacts(usize),
    /// A drive frequency to try.
    NoFrequency,
    /// A whole drive period.
    ShorterThanPeriod {
        /// Length of the record, s.
        span_s: f64,
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// A contact that stands out of the noise.
    OnlyNoise {
        /// Largest force, N.
        largest_n: f64,
        /// Noise, N.
        noise_n: f64,
    },
    /// A sample before the first contact.
    NothingBeforeContact,
    /// Parameters to search for.
    NothingToSearch,
}

/// Why there is no operating point.
#[derive(Clone, Debug, PartialEq)]
pub enum PickError {
    /// There is no stable 1/1.
    NoOneOne {
        /// Clearance at rest, m.
        gap_m: f64,
        /// The ratios Ω/ω that were searched.
        ratios: (f64, f64),
        /// A gap at which there is one, m: the nearest on the way to 0 that was tried. None if there is none at 0 either.
        nearest_gap_m: Option<f64>,
    },
    /// No frequency has a stable 1/1 for every rig within the uncertainty.
    NoneRobust {
        /// With this share of the uncertainty there is one. None if there is none even for a hundredth of it.
        share: Option<f64>,
    },
    /// A rig within the uncertainty has no stable 1/1.
    MemberLost {
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// No amplitude gives the force wanted.
    NoAmplitude {
        /// That force, N.
        wanted_n: f64,
    },
    /// No frequency keeps the limits.
    Limits {
        /// Where a stable 1/1 is, Hz.
        range_hz: (f64, f64),
        /// The limits.
        limits: crate::limits::Limits,
        /// What those of them that cannot be kept would have to be at least.
        feasible: Box<crate::limits::Limits>,
    },
}

impl fmt::Display for Error {
    /// The variant and its values. The words for people are the caller's.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl std::error::Error for Error {}

macro_rules! from {
    ($($source:ty => $variant:ident),* $(,)?) => {$(
        impl From<$source> for Error {
            fn from(error: $source) -> Self {
                Self::$variant(error)
            }
        }
    )*};
}

from!(
    ParamError => Parameter,
    DriveError => Drive,
    StartError => Start,
    MotionError => Motion,
    MapError => Map,
    BasinsError => Basins,
    ModesError => Modes,
    DropTestError => DropTest,
);
