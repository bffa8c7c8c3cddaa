//! How the rig is fed, and what a blow is.

/// How the rig follows the ground. The first three restore the gap; they differ in when and what they move, and their
/// answers differ by less than 1 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feed {
    /// At each drive phase 0 the cart is moved on by what was dug in the period. Hammer and ground stay where they are,
    /// so this can be done in contact, too.
    Cart,
    /// At each drive phase 0 the ground is brought back by what was dug, to a hammer that stays where it is in the cart. In
    /// contact it waits for the next phase 0.
    Ground,
    /// Steadily: through each period at the mean speed at which the last one dug.
    Steady,
    /// Steadily at this speed, m/s, whatever is dug: the gap sets itself.
    Speed(f64),
}

/// A contact with the ground, or a blow on the bit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroundBlow {
    /// When it began, s since the start.
    pub onset_s: f64,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// Speed of the hammer into the ground at onset, m/s.
    pub approach_speed_m_per_s: f64,
    /// How far the ground gave way in the blow, m.
    pub progress_m: f64,
    /// Largest contact force on the hammer, N.
    pub peak_force_n: f64,
    /// Largest force on the ground, N: the same without a bit.
    pub ground_force_n: f64,
    /// How often hammer and bit touched; once without a bit.
    pub contacts: u32,
    /// Energy that it took from the hammer, J.
    pub energy_lost_j: f64,
    /// Impulse of the contact force on the hammer, ∫F dt, N·s.
    pub impulse_n_s: f64,
}
