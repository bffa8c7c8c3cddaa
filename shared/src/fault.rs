//! Faults: what trips the drive, under stable numbers, and the record that survives a reset.
//!
//! Limits (clamp and report) are not faults; see [`crate::control`].

use serde::{Deserialize, Serialize};

use crate::control::Unfit;
use crate::crc_32::CRC_32;

/// A fault. The number is part of the link's protocol and of the stored record: it never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[repr(u8)]
pub enum Fault {
    /// The emergency-stop chain is open.
    EmergencyStop = 1,
    /// The measured contact force is above the trip level.
    OverForce = 2,
    /// Hammer or cart is beyond the trip level.
    OverTravel = 3,
    /// A sensor stays at a rail.
    SensorSaturated = 4,
    /// A sensor's wire is open.
    SensorOpen = 5,
    /// A sensor that must move with the drive does not.
    SensorFrozen = 6,
    /// Sensors contradict each other: force without the hammer at the surface, a cart that does not follow
    /// the drive, a pulse no contact can make.
    SensorOutOfFamily = 7,
    /// No contact where the forecast has one, after every attempt to find it.
    NoContact = 8,
    /// The regime stayed lost, after every attempt to regain it.
    RegimeLost = 9,
    /// The control task did not end before the next was due, too often.
    Overrun = 10,
    /// The samples did not arrive in time, or are the same block again.
    StaleSamples = 11,
    /// The link was silent for too long while it steered.
    LinkTimeout = 12,
    /// The stored settings are damaged.
    CorruptSettings = 13,
    /// The watchdog has reset the board.
    WatchdogReset = 14,
    /// The supply dropped and reset the board.
    BrownOut = 15,
    /// The program panicked or the processor faulted.
    Crash = 16,
    /// The cart moves although the drive is off.
    NotOff = 17,
    /// The board itself is not fit to drive a rig: clock, supply or reference ([`crate::control::Unfit`]).
    BoardUnfit = 18,
    /// The reset line, or a debugger, has reset the board while the drive was on.
    ResetWhileDriving = 19,
}

impl Fault {
    /// Every fault, in the order of its number.
    pub const ALL: [Self; 19] = [
        Self::EmergencyStop,
        Self::OverForce,
        Self::OverTravel,
        Self::SensorSaturated,
        Self::SensorOpen,
        Self::SensorFrozen,
        Self::SensorOutOfFamily,
        Self::NoContact,
        Self::RegimeLost,
        Self::Overrun,
        Self::StaleSamples,
        Self::LinkTimeout,
        Self::CorruptSettings,
        Self::WatchdogReset,
        Self::BrownOut,
        Self::Crash,
        Self::NotOff,
        Self::BoardUnfit,
        Self::ResetWhileDriving,
    ];

    /// The fault's number in protocol and stored record: it never changes.
    #[inline]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The fault of that number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.code() == code)
    }

    /// The fault's stable name, such as `over-force`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::EmergencyStop => "emergency-stop",
            Self::OverForce => "over-force",
            Self::OverTravel => "over-travel",
            Self::SensorSaturated => "sensor-saturated",
            Self::SensorOpen => "sensor-open",
            Self::SensorFrozen => "sensor-frozen",
            Self::SensorOutOfFamily => "sensor-out-of-family",
            Self::NoContact => "no-contact",
            Self::RegimeLost => "regime-lost",
            Self::Overrun => "overrun",
            Self::StaleSamples => "stale-samples",
            Self::LinkTimeout => "link-timeout",
            Self::CorruptSettings => "corrupt-settings",
            Self::WatchdogReset => "watchdog-reset",
            Self::BrownOut => "brown-out",
            Self::Crash => "crash",
            Self::NotOff => "not-off",
            Self::BoardUnfit => "board-unfit",
            Self::ResetWhileDriving => "reset-while-driving",
        }
    }
}

impl Fault {
    /// Whether the drive stays off until the fault is cleared by hand. A link timeout ends with the next packet.
    pub const fn latches(self) -> bool {
        !matches!(self, Self::LinkTimeout)
    }
}

/// Faults as a set: bit n stands for the fault with number n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FaultSet(u32);

impl FaultSet {
    /// The empty set: no fault.
    pub const NONE: Self = Self(0);

    /// The set of this one fault.
    pub const fn of(fault: Fault) -> Self {
        Self(1 << fault.code())
    }

    /// The faults of either set.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The set without `fault`.
    #[must_use]
    pub const fn without(self, fault: Fault) -> Self {
        Self(self.0 & !Self::of(fault).0)
    }

    /// Whether `fault` is in the set.
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & Self::of(fault).0 != 0
    }

    /// Whether no fault is in the set.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The faults in the set, by number.
    pub fn faults(self) -> impl Iterator<Item = Fault> {
        let all = Fault::ALL.into_iter();
        all.filter(move |fault| self.contains(*fault))
    }

    /// Whether the drive stays off until the set is cleared by hand: one fault that latches is enough.
    pub fn latches(self) -> bool {
        self.faults().any(Fault::latches)
    }

    /// The set as a word.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// The set of a word; bits that stand for no fault are left out.
    pub fn from_bits(bits: u32) -> Self {
        let known = Fault::ALL.into_iter().map(Self::of);
        Self(bits & known.fold(0, |all, one| all | one.0))
    }
}

/// Which sensor a fault is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Origin {
    /// No sensor: the fault is the system's.
    #[default]
    System = 0,
    /// The force sensor.
    Force = 1,
    /// The hammer's displacement sensor.
    Hammer = 2,
    /// The cart's displacement sensor.
    Cart = 3,
}

/// The record of an episode of faults: from the first fault to the moment it is cleared. Written when a fault
/// trips, retained over a reset, reported after it. It describes the first fault of the episode, or the first that
/// latches if there is one; the others are in [`FaultRecord::episode`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// The fault described: the first of the episode, or the first that latches if there is one.
    pub fault: Fault,
    /// The sensor that this fault is about.
    pub origin: Origin,
    /// Control ticks since the start at which its condition was seen (wraps after 2.5 days).
    pub tick: u32,
    /// The value that tripped it: N, m, s, or a count, by fault.
    pub value: f32,
    /// Drive frequency then, Hz.
    pub frequency_hz: f32,
    /// Every fault of the episode, this one included.
    pub episode: FaultSet,
}

impl FaultRecord {
    /// The first record of an episode.
    pub const fn new(
        fault: Fault,
        origin: Origin,
        tick: u32,
        value: f32,
        frequency_hz: f32,
    ) -> Self {
        Self {
            fault,
            origin,
            tick,
            value,
            frequency_hz,
            episode: FaultSet::of(fault),
        }
    }

    /// A crash. Nothing else is known when it is written.
    pub const CRASH: Self = Self::new(Fault::Crash, Origin::System, 0, 0.0, 0.0);

    /// A board that is not fit to drive; its value is the sum of the reasons ([`Unfit::bits`]).
    pub fn unfit(why: Unfit) -> Self {
        let value = f32::from(why.bits());
        Self::new(Fault::BoardUnfit, Origin::System, 0, value, 0.0)
    }

    /// Whether the drive stays off until the episode is cleared by hand.
    pub fn latches(&self) -> bool {
        self.episode.latches()
    }

    /// The record of the episode of `before`, if there is one, that this fault belongs to as well. It keeps every
    /// fault of both.
    #[must_use]
    pub fn after(self, before: Option<Self>) -> Self {
        let Some(before) = before else {
            return self;
        };
        let first = if self.fault.latches() && !before.fault.latches() {
            self
        } else {
            before
        };
        Self {
            episode: self.episode.and(before.episode),
            ..first
        }
    }
}

/// Version of the layout of [`Persisted::words`]. A record of another layout is none.
const LAYOUT: u32 = 2;

/// A record as it lies in memory that survives a reset (no-init RAM or backup registers): words with a
/// check, so that the random contents after power-up are not taken for a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Persisted {
    /// The record, packed: number, origin and layout; tick; value; frequency; episode.
    pub words: [u32; 5],
    /// What [`Persisted::check_of`] gives for `words`; with another value there is no record.
    pub check: u32,
}

impl Persisted {
    /// No record: its check is wrong on purpose.
    pub const EMPTY: Self = Self {
        words: [0; 5],
        check: 0,
    };

    /// Packs a record and adds its check.
    pub fn new(record: &FaultRecord) -> Self {
        let words = [
            u32::from(record.fault.code()) | (record.origin as u32) << 8 | LAYOUT << 16,
            record.tick,
            record.value.to_bits(),
            record.frequency_hz.to_bits(),
            record.episode.bits(),
        ];
        Self {
            words,
            check: Self::check_of(&words),
        }
    }

    /// The record, if it is whole.
    pub fn record(&self) -> Option<FaultRecord> {
        if self.check != Self::check_of(&self.words) {
            return None;
        }
        let [head, tick, value, frequency_hz, episode] = self.words;
        if head >> 16 != LAYOUT {
            return None;
        }
        let origin = match (head >> 8) & 0xff {
            0 => Origin::System,
            1 => Origin::Force,
            2 => Origin::Hammer,
            3 => Origin::Cart,
            _ => return None,
        };
        let fault = Fault::from_code((head & 0xff) as u8)?;
        Some(FaultRecord {
            fault,
            origin,
            tick,
            value: f32::from_bits(value),
            frequency_hz: f32::from_bits(frequency_hz),
            episode: FaultSet::from_bits(episode).and(FaultSet::of(fault)),
        })
    }

    /// A check over the words that neither all zeros nor all ones satisfy.
    pub fn check_of(words: &[u32; 5]) -> u32 {
        let mut digest = CRC_32.digest();
        for word in words {
            digest.update(&word.to_le_bytes());
        }
        digest.finalize() ^ 0x5a5a_a5a5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_stable_and_names_unique() {
        for (i, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(fault.code()), i + 1);
            assert_eq!(Fault::from_code(fault.code()), Some(fault));
            let same = Fault::ALL.into_iter().filter(|f| f.name() == fault.name());
            assert_eq!(same.count(), 1);
        }
        assert_eq!(Fault::from_code(0), None);
    }

    #[test]
    fn an_episode_latches_if_one_of_its_faults_does_and_shows_that_one() {
        let record = |fault| FaultRecord::new(fault, Origin::System, 1, 2.0, 3.0);
        let pure = record(Fault::LinkTimeout);
        assert!(!pure.latches());
        let both = record(Fault::EmergencyStop).after(Some(pure));
        assert!(both.latches());
        assert_eq!(both.fault, Fault::EmergencyStop);
        assert!(both.episode.contains(Fault::LinkTimeout));
        assert_eq!(pure.after(Some(both)).fault, Fault::EmergencyStop);
        assert_eq!(
            FaultSet::from_bits(u32::MAX).faults().count(),
            Fault::ALL.len()
        );
    }

    #[test]
    fn a_record_of_an_older_layout_is_none() {
        let record = FaultRecord::new(Fault::OverForce, Origin::Force, 1, 2.0, 3.0);
        let mut old = Persisted::new(&record);
        old.words[0] &= 0xffff;
        old.check = Persisted::check_of(&old.words);
        assert_eq!(old.record(), None);
    }

    #[test]
    fn a_record_survives_and_a_damaged_one_is_none() {
        let second = FaultRecord::new(Fault::BrownOut, Origin::System, 0, 0.0, 0.0);
        let record = second.after(Some(FaultRecord::new(
            Fault::OverForce,
            Origin::Force,
            123_456,
            401.5,
            3.66,
        )));
        assert_eq!(record.fault, Fault::OverForce);
        let both = FaultSet::of(Fault::OverForce).and(FaultSet::of(Fault::BrownOut));
        assert_eq!(record.episode, both);
        let kept = Persisted::new(&record);
        assert_eq!(kept.record(), Some(record));
        for word in 0..5 {
            let mut damaged = kept;
            damaged.words[word] ^= 1 << 7;
            assert_eq!(damaged.record(), None);
        }
        for fill in [0, u32::MAX] {
            let blank = Persisted {
                words: [fill; 5],
                check: fill,
            };
            assert_eq!(blank.record(), None);
        }
    }
}
