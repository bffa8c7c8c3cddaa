//! A status as cells of the log, one by one, so that two can be compared and the one that differs named.

use std::borrow::Cow;
use std::fmt;

use shared::control::Status;
use shared::fault::{Fault, FaultSet};

use super::columns::Col;
use crate::names::{basin_name, state_name};

/// One value of a status.
#[derive(Clone, Debug)]
pub enum StatusCell {
    /// No value: that of a fault where there is none, or of a cell that was left empty.
    Null,
    /// A count, a tick, bits.
    Int(i64),
    /// A number in SI units, as the controller has it.
    Float(f32),
    /// A name (of a state, a sensor, a basin), several (faults), or a regime.
    Text(Cow<'static, str>),
}

impl PartialEq for StatusCell {
    /// Bit for bit: a NaN equals itself, 0 and −0 differ.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Null, Self::Null) => true,
            (Self::Int(a), Self::Int(b)) => a == b,
            (Self::Float(a), Self::Float(b)) => a.to_bits() == b.to_bits(),
            (Self::Text(a), Self::Text(b)) => a == b,
            _ => false,
        }
    }
}

impl fmt::Display for StatusCell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("none"),
            Self::Int(value) => write!(f, "{value}"),
            Self::Float(value) => write!(f, "{value:?} ({:#010x})", value.to_bits()),
            Self::Text(value) => f.write_str(value),
        }
    }
}

/// The columns of a status, in the order of [`cells`]: the state, then those from its tick to the last. Logs of versions
/// before 5 lack the last, those before 4 the one before it too.
pub(super) const STATUS: [Col; 22] = {
    let mut columns = [Col::State; 22];
    let (_, of_block) = Col::ALL.split_at(Col::StatusTick as usize);
    columns.split_at_mut(1).1.copy_from_slice(of_block);
    columns
};

/// The names of the cells of a status, with units, as the log's columns are called.
pub fn names() -> [&'static str; STATUS.len()] {
    STATUS.map(Col::name)
}

/// The name of a variant, in lower case and with hyphens.
fn kebab(variant: &impl fmt::Debug) -> String {
    let mut name = String::new();
    for letter in format!("{variant:?}").chars() {
        if letter.is_uppercase() && !name.is_empty() {
            name.push('-');
        }
        name.extend(letter.to_lowercase());
    }
    name
}

/// The names of the faults of an episode, by number.
fn episode(faults: FaultSet) -> String {
    let names: Vec<_> = faults.faults().map(Fault::name).collect();
    names.join(" ")
}

/// The cells of a status.
pub fn cells(status: &Status) -> [StatusCell; STATUS.len()] {
    let Status {
        tick,
        state,
        fault,
        limits,
        frequency_hz,
        amplitude_m,
        measured_amplitude_m,
        lag_rad,
        regime,
        peak_n,
        impulse_n_s,
        target_hz,
        target_n,
        basin,
        reseeks,
        overruns,
        events_dropped,
    } = *status;
    let text = |name: String| StatusCell::Text(Cow::Owned(name));
    let of_fault = |f: &dyn Fn(&shared::fault::FaultRecord) -> StatusCell| {
        fault.as_ref().map_or(StatusCell::Null, f)
    };
    [
        StatusCell::Text(Cow::Borrowed(state_name(state))),
        StatusCell::Int(i64::from(tick)),
        of_fault(&|record| StatusCell::Text(Cow::Borrowed(record.fault.name()))),
        of_fault(&|record| text(kebab(&record.origin))),
        of_fault(&|record| StatusCell::Int(i64::from(record.tick))),
        of_fault(&|record| StatusCell::Float(record.value)),
        of_fault(&|record| StatusCell::Float(record.frequency_hz)),
        StatusCell::Int(i64::from(limits.bits())),
        StatusCell::Float(frequency_hz),
        StatusCell::Float(amplitude_m),
        StatusCell::Float(measured_amplitude_m),
        StatusCell::Float(lag_rad),
        text(regime.to_string()),
        StatusCell::Float(peak_n),
        StatusCell::Float(impulse_n_s),
        StatusCell::Float(target_hz),
        StatusCell::Float(target_n),
        StatusCell::Text(Cow::Borrowed(basin_name(basin))),
        StatusCell::Int(i64::from(reseeks)),
        StatusCell::Int(i64::from(overruns)),
        of_fault(&|record| text(episode(record.episode))),
        StatusCell::Int(i64::from(events_dropped)),
    ]
}
