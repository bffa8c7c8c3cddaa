//! Which keys a settings file has, what each means, and where its value stands in the settings.

use shared::settings::{Calibration, Settings};

/// One key of a section, with a value of the kind `T`.
pub struct Key<T> {
    pub section: &'static str,
    pub name: &'static str,
    /// Stands behind the value in a written file.
    pub meaning: &'static str,
    pub place: fn(&mut Settings) -> &mut T,
}

/// A table of keys: section, key, meaning, and the place in the settings.
macro_rules! keys {
    ($($section:ident $name:ident: $meaning:literal, $first:ident$(.$rest:ident)*;)*) => {
        [$(Key {
            section: stringify!($section),
            name: stringify!($name),
            meaning: $meaning,
            place: |settings: &mut Settings| &mut settings.$first$(.$rest)*,
        }),*]
    };
}

/// The sections in the order in which they are written.
pub const SECTIONS: [&str; 11] = [
    "rig",
    "force",
    "hammer",
    "cart",
    "drive",
    "limits",
    "trips",
    "detection",
    "operator",
    "aim",
    "interlock",
];

/// The keys of all numbers, with their place in the settings.
pub const NUMBERS: [Key<f32>; 27] = keys! {
    force zero_code: "ADC code at 0 N", force.zero_code;
    force n_per_code: "newtons per ADC code", force.unit_per_code;
    force uncertainty_percent: "of the calibration, of full scale (k = 2); 0: not known", calibration.force.uncertainty_percent;
    hammer zero_code: "ADC code at rest", hammer.zero_code;
    hammer m_per_code: "metres per ADC code", hammer.unit_per_code;
    hammer uncertainty_percent: "of the calibration, of full scale (k = 2); 0: not known", calibration.hammer.uncertainty_percent;
    cart zero_code: "ADC code at rest", cart.zero_code;
    cart m_per_code: "metres per ADC code", cart.unit_per_code;
    cart uncertainty_percent: "of the calibration, of full scale (k = 2); 0: not known", calibration.cart.uncertainty_percent;
    drive m_per_code: "cart metres per DAC code", drive.m_per_code;
    drive frequency_slew_hz_per_s: "fastest change", drive.frequency_slew_hz_per_s;
    drive amplitude_slew_m_per_s: "fastest change", drive.amplitude_slew_m_per_s;
    limits force_n: "largest contact force", limits.force_n;
    limits travel_m: "largest travel of the hammer on the cart", limits.travel_m;
    limits min_frequency_hz: "lowest drive frequency", limits.min_frequency_hz;
    limits max_frequency_hz: "highest drive frequency", limits.max_frequency_hz;
    limits amplitude_m: "largest cart amplitude", limits.amplitude_m;
    trips force_n: "contact force that switches the drive off", trips.force_n;
    trips travel_m: "travel on the cart that switches the drive off", trips.travel_m;
    trips cart_m: "cart displacement that switches the drive off", trips.cart_m;
    trips no_contact_s: "longest time without a forecast contact", trips.no_contact_s;
    trips regime_lost_s: "longest time without the regime", trips.regime_lost_s;
    trips link_timeout_s: "longest silence of the program that steers; 0: no limit", trips.link_timeout_s;
    detection on_n: "a contact begins above", detection.on_n;
    detection off_n: "and may end below", detection.off_n;
    detection refractory_s: "after this time below", detection.refractory_s;
    aim force_n: "mean peak force wanted, or force_ratio in units of the weight; 0: none", aim.force_n;
};

/// The keys of all switches (true or false), with their place in the settings.
pub const SWITCHES: [Key<bool>; 5] = keys! {
    interlock relay: "the mirror contact of the enable's relay is wired to D8", interlock.relay;
    interlock ready: "the power stage's \"ready\" is wired to D6", interlock.ready;
    operator heartbeat: "automatic mode, too, needs signs of life from a program on the link", operator.heartbeat;
    operator acknowledge: "an emergency stop must be acknowledged with the board's button", operator.acknowledge;
    aim power: "the most impact power instead of the strongest contact", aim.power;
};

/// A section's keys in one of the tables.
pub fn of<'a, T>(table: &'a [Key<T>], section: &'a str) -> impl Iterator<Item = &'a Key<T>> {
    table.iter().filter(move |key| key.section == section)
}

/// The calibration that a sensor's section is about.
pub fn calibration<'a>(settings: &'a mut Settings, section: &str) -> Option<&'a mut Calibration> {
    let all = &mut settings.calibration;
    match section {
        "force" => Some(&mut all.force),
        "hammer" => Some(&mut all.hammer),
        "cart" => Some(&mut all.cart),
        _ => None,
    }
}
