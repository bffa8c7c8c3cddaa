//! The emulator: plant, sensors, scenarios; and the controller in it.

mod balances;
mod builtin;
mod drilling;
mod faults;
mod ground;
mod motor;
mod mounting;
mod operator;
mod random;
mod scenarios;
mod sensors;
mod stiff_limit;
mod support;
mod verdicts;
