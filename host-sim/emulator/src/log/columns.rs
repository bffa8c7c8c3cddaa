//! The columns of the Parquet file: their names, kinds and packing, where each has values, and what changed from
//! version to version.

use files::columns::{ColumnField, ColumnKind, Packing};

/// The version of the columns. 1 called the impulse `impulse_ns`; from 3 on every byte is under a check sum; from 4 on
/// there is the episode, from 5 on the events that were dropped, and settings with the shaker's loop.
pub(super) const VERSION: u32 = 5;

#[cfg(feature = "disk")]
/// The first version whose bytes are under check sums.
pub(super) const CHECKED: u32 = 3;

/// The first version with the episode.
const WITH_EPISODE: u32 = 4;

/// The first version with the events that were dropped, the last column.
const WITH_EVENTS_DROPPED: u32 = 5;

/// The value of the key `format`, before the version's number.
pub(super) const FORMAT: &str = "vibro-impact run ";

/// Where a column has values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fill {
    Tick,
    /// At every tick of an emulated run, nowhere in a board's recording.
    Truth,
    /// At every tick whose block has a status.
    State,
    /// At a block's first tick.
    Block,
}

/// A column: name with unit, kind, where it has values.
pub(super) struct Spec {
    pub name: &'static str,
    pub kind: ColumnKind,
    pub fill: Fill,
}

macro_rules! columns {
    ($($id:ident $name:literal $kind:ident $fill:ident;)*) => {
        /// Every column, in the order of the file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Col { $($id),* }

        impl Col {
            pub(super) const ALL: &[Self] = &[$(Self::$id),*];
        }

        pub(super) const COLUMNS: &[Spec] = &[
            $(Spec { name: $name, kind: ColumnKind::$kind, fill: Fill::$fill }),*
        ];
    };
}

columns! {
    Tick "tick" Long Tick;
    TimeUs "time_us" Long Tick;
    Force "force_code" Int Tick;
    Hammer "hammer_code" Int Tick;
    Cart "cart_code" Int Tick;
    Emergency "emergency" Flag Tick;
    Dac "dac_code" Int Tick;
    FrequencySet "frequency_set_hz" Float Tick;
    Enable "enable" Flag Tick;
    TrueForce "true_force_n" Float Truth;
    TrueHammer "true_hammer_mm" Float Truth;
    TrueCart "true_cart_mm" Float Truth;
    State "state" Text State;
    BlockTicks "block_ticks" Int Block;
    Slices "slices" Int Block;
    Samples "samples" Text Block;
    Forecast "forecast_delivered" Flag Block;
    Inputs "inputs" Text Block;
    InputsPostcard "inputs_postcard" Bytes Block;
    StatusTick "status_tick" Long Block;
    Fault "fault" Text Block;
    FaultOrigin "fault_origin" Text Block;
    FaultTick "fault_tick" Long Block;
    FaultValue "fault_value" Float Block;
    FaultFrequency "fault_frequency_hz" Float Block;
    Limits "limits" Long Block;
    Frequency "frequency_hz" Float Block;
    Amplitude "amplitude_m" Float Block;
    MeasuredAmplitude "measured_amplitude_m" Float Block;
    Lag "lag_rad" Float Block;
    Regime "regime" Text Block;
    Peak "peak_n" Float Block;
    Impulse "impulse_n_s" Float Block;
    Target "target_hz" Float Block;
    TargetForce "target_n" Float Block;
    Basin "basin" Text Block;
    Reseeks "reseeks" Long Block;
    Overruns "overruns" Long Block;
    Episode "episode" Text Block;
    EventsDropped "events_dropped" Long Block;
}

impl Col {
    /// The column's name in the file, with the unit.
    pub fn name(self) -> &'static str {
        COLUMNS[self as usize].name
    }
}

/// The columns as `version` has them.
pub(super) fn fields(version: u32) -> Vec<ColumnField> {
    let mut fields: Vec<ColumnField> = COLUMNS.iter().map(Spec::field).collect();
    if version == 1 {
        fields[Col::Impulse as usize].name = "impulse_ns".into();
    }
    if version < WITH_EPISODE {
        fields.truncate(Col::Episode as usize);
    } else if version < WITH_EVENTS_DROPPED {
        fields.truncate(Col::EventsDropped as usize);
    }
    fields
}

impl Spec {
    /// Counters and codes are packed as differences, true values as split floats, all others, which repeat, by
    /// dictionary.
    fn field(&self) -> ColumnField {
        ColumnField {
            name: self.name.into(),
            kind: self.kind,
            optional: self.fill != Fill::Tick,
            packing: match (self.kind, self.fill) {
                (ColumnKind::Int | ColumnKind::Long, Fill::Tick) | (ColumnKind::Long, _) => {
                    Packing::Differences
                }
                (ColumnKind::Float, Fill::Truth) => Packing::Split,
                _ => Packing::Dictionary,
            },
        }
    }
}
