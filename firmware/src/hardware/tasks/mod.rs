//! What the tasks do, the same on every board that a rig hangs on. No register of a part is touched here: what a
//! board does in its own way is in its folder, under the names that this table has. Its `app.rs` says which interrupt
//! starts which task.
//!
//! | name in a board's `mod.rs` | what |
//! |---|---|
//! | `NAME` | the board's name, as the link gives it |
//! | `Peripherals` | all the part's registers |
//! | [`Board`] | is put together by `set_up` |
//! | `AdcSampler`, `SetPoints` | samples in and set-points out, in step, by DMA |
//! | `EnablePin`, `ChainPin`, `Reports` | the pins of drive and safety |
//! | `Serial`, `LinkTimer` | the link's wire, and its tick of 1 ms |
//! | `BlockMonitor` | the tick of 1 ms above all tasks |
//! | `FlashStore` | the settings' flash |
//! | `LedPin`, `ButtonPin` | |
//! | `reset_flags`, `disable`, `make_outputs_safe`, `feed_watchdog`, `supply_is_low` | from anywhere |
//! | `Registers`, `registers` | what the board's set-up has written, to be compared with later |
//! | `report_panic`, `report_fault` | those of [`report`] |

pub mod blocks;
mod control;
pub mod drive;
mod forecasts;
mod link;
pub mod log;
pub mod report;
pub mod retained;
mod start;
mod supervisor;
mod traps;

use shared::control::Unfit;

use super::board;
pub use control::Control;
pub use forecasts::Forecasts;
pub use link::Link;
pub use start::{Tasks, start};
pub use supervisor::Supervisor;

/// The board, set up and safe: the drive is off, nothing samples yet.
pub struct Board {
    /// Samples in, by DMA.
    pub sampler: board::AdcSampler,
    /// Set-points out, by DMA.
    pub set_points: board::SetPoints,
    /// The drive's enable line; a board that must not drive has none to give.
    pub enable: Option<board::EnablePin>,
    /// The input of the emergency-stop chain.
    pub chain: board::ChainPin,
    /// Checks that blocks are being served.
    pub block_monitor: board::BlockMonitor,
    /// The link's serial port.
    pub serial: board::Serial,
    /// Ticks the link task.
    pub link_timer: board::LinkTimer,
    /// The storage of the settings.
    pub store: board::FlashStore,
    /// The LED that shows the state.
    pub led: board::LedPin,
    /// The button that starts, stops, acknowledges and clears.
    pub button: board::ButtonPin,
    /// Bench mode is asked for.
    pub bench_asked: bool,
    /// Sensors or the emergency-stop chain are wired.
    pub wired: bool,
    /// What the power stage and the enable's relay report.
    pub reports: board::Reports,
    /// Why this board is not fit to drive a rig.
    pub unfit: Unfit,
}
