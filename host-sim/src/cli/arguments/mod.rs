//! Groups of options that several commands share. A command takes the groups it uses, so that clap refuses the others.

pub mod choice;
pub mod cycles;
pub mod drive;
pub mod engine;
pub mod ground;
pub mod output;
pub mod over;
pub mod range;
pub mod request;
pub mod rig;
pub mod uncertainty;
