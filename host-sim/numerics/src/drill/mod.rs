//! The hammer on ground that gives way: how fast it drills.
//!
//! The ground is [`shared::model::slider`]: spring and dashpot on a massless slider that dry friction holds up to a
//! threshold Pf. The cart moves as prescribed or recoils, as the rig's parameters say. [`march`] integrates hammer and ground from drive phase 0 to drive phase 0
//! with every switch located; its phases are flight (the top relaxes), contact with the ground held, and contact with the
//! ground giving way.
//!
//! What repeats (coordinate, rate and compression, measured from the front of the ground) is kept apart from the
//! progress, which grows. So the section repeats, regimes are found as with a surface that stays, and the return map has
//! multipliers ([`orbit`]).

pub mod blow;
pub mod body;
mod contacts;
mod exits;
pub mod flow;
pub mod march;
pub mod orbit;
pub mod pick;
pub mod published;
mod run;
pub mod search;
mod state;
mod watch;

pub use blow::{Feed, GroundBlow};
pub use contacts::SAME_BLOW_S;
pub use march::Drill;
pub use run::{DrillPlan, DrillRow, DrillRun, DrillSetting, grid, run};
pub use search::{Among, Corner, DrillAnswer, DrillRuns, GroundUncertainty};

#[cfg(test)]
mod tests;
