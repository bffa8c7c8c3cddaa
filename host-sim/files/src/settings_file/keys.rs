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

/// A row of the tables below.
const fn key<T>(
    section: &'static str,
    name: &'static str,
    meaning: &'static str,
    place: fn(&mut Settings) -> &mut T,
) -> Key<T> {
    Key {
        section,
        name,
        meaning,
        place,
    }
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

/// Every number.
pub const NUMBERS: [Key<f32>; 27] = [
    key("force", "zero_code", "ADC code at 0 N", |s| {
        &mut s.force.zero_code
    }),
    key("force", "n_per_code", "newtons per ADC code", |s| {
        &mut s.force.unit_per_code
    }),
    key(
        "force",
        "uncertainty_percent",
        "of the calibration, of full scale (k = 2); 0: not known",
        |s| &mut s.calibration.force.uncertainty_percent,
    ),
    key("hammer", "zero_code", "ADC code at rest", |s| {
        &mut s.hammer.zero_code
    }),
    key("hammer", "m_per_code", "metres per ADC code", |s| {
        &mut s.hammer.unit_per_code
    }),
    key(
        "hammer",
        "uncertainty_percent",
        "of the calibration, of full scale (k = 2); 0: not known",
        |s| &mut s.calibration.hammer.uncertainty_percent,
    ),
    key("cart", "zero_code", "ADC code at rest", |s| {
        &mut s.cart.zero_code
    }),
    key("cart", "m_per_code", "metres per ADC code", |s| {
        &mut s.cart.unit_per_code
    }),
    key(
        "cart",
        "uncertainty_percent",
        "of the calibration, of full scale (k = 2); 0: not known",
        |s| &mut s.calibration.cart.uncertainty_percent,
    ),
    key("drive", "m_per_code", "cart metres per DAC code", |s| {
        &mut s.drive.m_per_code
    }),
    key("drive", "frequency_slew_hz_per_s", "fastest change", |s| {
        &mut s.drive.frequency_slew_hz_per_s
    }),
    key("drive", "amplitude_slew_m_per_s", "fastest change", |s| {
        &mut s.drive.amplitude_slew_m_per_s
    }),
    key("limits", "force_n", "largest contact force held", |s| {
        &mut s.limits.force_n
    }),
    key(
        "limits",
        "travel_m",
        "largest travel on the cart held",
        |s| &mut s.limits.travel_m,
    ),
    key(
        "limits",
        "min_frequency_hz",
        "lowest drive frequency",
        |s| &mut s.limits.min_frequency_hz,
    ),
    key(
        "limits",
        "max_frequency_hz",
        "highest drive frequency",
        |s| &mut s.limits.max_frequency_hz,
    ),
    key("limits", "amplitude_m", "largest cart amplitude", |s| {
        &mut s.limits.amplitude_m
    }),
    key("trips", "force_n", "contact force that switches off", |s| {
        &mut s.trips.force_n
    }),
    key("trips", "travel_m", "travel on the cart that does", |s| {
        &mut s.trips.travel_m
    }),
    key("trips", "cart_m", "cart displacement that does", |s| {
        &mut s.trips.cart_m
    }),
    key(
        "trips",
        "no_contact_s",
        "time without a forecast contact",
        |s| &mut s.trips.no_contact_s,
    ),
    key(
        "trips",
        "regime_lost_s",
        "time the regime may be lost",
        |s| &mut s.trips.regime_lost_s,
    ),
    key(
        "trips",
        "link_timeout_s",
        "silence of a link in command; 0: any",
        |s| &mut s.trips.link_timeout_s,
    ),
    key("detection", "on_n", "a contact begins above", |s| {
        &mut s.detection.on_n
    }),
    key("detection", "off_n", "and may end below", |s| {
        &mut s.detection.off_n
    }),
    key(
        "detection",
        "refractory_s",
        "having stayed there so long",
        |s| &mut s.detection.refractory_s,
    ),
    key(
        "aim",
        "force_n",
        "mean peak force wanted, or force_ratio in units of the weight; 0: as it comes",
        |s| &mut s.aim.force_n,
    ),
];

/// Every switch.
pub const SWITCHES: [Key<bool>; 5] = [
    key(
        "interlock",
        "relay",
        "the mirror contact of the enable's relay is wired to D8",
        |s| &mut s.interlock.relay,
    ),
    key(
        "interlock",
        "ready",
        "the power stage's \"ready\" is wired to D6",
        |s| &mut s.interlock.ready,
    ),
    key(
        "operator",
        "heartbeat",
        "automatic mode, too, needs a program that stays on the link",
        |s| &mut s.operator.heartbeat,
    ),
    key(
        "operator",
        "acknowledge",
        "an emergency stop must be acknowledged with the board's button",
        |s| &mut s.operator.acknowledge,
    ),
    key(
        "aim",
        "power",
        "the most impact power instead of the strongest contact",
        |s| &mut s.aim.power,
    ),
];

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
