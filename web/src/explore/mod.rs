//! What the page's part "Explore" computes.

mod map;
mod orbit;
mod pick;
mod rig;

use crate::Function;

/// The functions of the part "Explore" by their names.
pub const FUNCTIONS: &[(&str, Function)] = &[
    ("explore.rig", rig::rig),
    ("explore.choices", rig::choices),
    ("explore.map", map::map),
    ("explore.orbit", orbit::orbit),
    ("explore.neighbours", orbit::neighbours),
    ("explore.pick_first", pick::first),
    ("explore.pick", pick::pick),
];
