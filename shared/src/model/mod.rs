//! The hammer's motion: parameters, equations, the switch at the impact surface, a tick of it all, and the
//! regime it ends in. Plain numbers in and out: nothing here knows a sensor, a controller or a message.

pub mod bit;
pub mod cart;
pub mod contact;
pub mod contacts;
pub mod drive;
pub mod number;
pub mod params;
pub mod regime;
pub mod rig;
pub mod scalar;
pub mod slider;
pub mod step;
pub mod switch;
pub mod tangent;
pub mod trig;
pub mod twin;
