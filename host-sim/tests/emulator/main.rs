//! The emulator: plant, sensors, scenarios.

mod balances;
mod sensors;
mod stiff_limit;
mod support;
