//! The controller's settings as a TOML file: units in the keys, and only what differs need be named.

use shared::settings::{Calibration, DriveKind, Settings};
use toml::{Table, Value};

use crate::UserError;
use crate::rigfile::{self, nearest};

/// Every number: section, key, meaning.
const NUMBERS: [(&str, &str, &str); 27] = [
    ("force", "zero_code", "ADC code at 0 N"),
    ("force", "n_per_code", "newtons per ADC code"),
    (
        "force",
        "uncertainty_percent",
        "of the calibration, of full scale (k = 2); 0: not known",
    ),
    ("hammer", "zero_code", "ADC code at rest"),
    ("hammer", "m_per_code", "metres per ADC code"),
    (
        "hammer",
        "uncertainty_percent",
        "of the calibration, of full scale (k = 2); 0: not known",
    ),
    ("cart", "zero_code", "ADC code at rest"),
    ("cart", "m_per_code", "metres per ADC code"),
    (
        "cart",
        "uncertainty_percent",
        "of the calibration, of full scale (k = 2); 0: not known",
    ),
    ("drive", "m_per_code", "cart metres per DAC code"),
    ("drive", "frequency_slew_hz_per_s", "fastest change"),
    ("drive", "amplitude_slew_m_per_s", "fastest change"),
    ("limits", "force_n", "largest contact force held"),
    ("limits", "travel_m", "largest travel on the cart held"),
    ("limits", "min_frequency_hz", "lowest drive frequency"),
    ("limits", "max_frequency_hz", "highest drive frequency"),
    ("limits", "amplitude_m", "largest cart amplitude"),
    ("trips", "force_n", "contact force that switches off"),
    ("trips", "travel_m", "travel on the cart that does"),
    ("trips", "cart_m", "cart displacement that does"),
    ("trips", "no_contact_s", "time without a forecast contact"),
    ("trips", "regime_lost_s", "time the regime may be lost"),
    (
        "trips",
        "link_timeout_s",
        "silence of a link in command; 0: any",
    ),
    ("detection", "on_n", "a contact begins above"),
    ("detection", "off_n", "and may end below"),
    ("detection", "refractory_s", "having stayed there so long"),
    (
        "aim",
        "force_n",
        "mean peak force wanted, or force_ratio in units of the weight; 0: as it comes",
    ),
];

/// Every switch: section, key, meaning.
const SWITCHES: [(&str, &str, &str); 5] = [
    (
        "interlock",
        "relay",
        "the mirror contact of the enable's relay is wired to D8",
    ),
    (
        "interlock",
        "ready",
        "the power stage's \"ready\" is wired to D6",
    ),
    (
        "operator",
        "heartbeat",
        "automatic mode, too, needs a program that stays on the link",
    ),
    (
        "operator",
        "acknowledge",
        "an emergency stop must be acknowledged with the board's button",
    ),
    (
        "aim",
        "power",
        "the most impact power instead of the strongest contact",
    ),
];

const SECTIONS: [&str; 11] = [
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

fn number<'a>(settings: &'a mut Settings, section: &str, key: &str) -> Option<&'a mut f32> {
    let Settings {
        rig: _,
        force,
        hammer,
        cart,
        drive,
        limits,
        trips,
        detection,
        operator: _,
        aim,
        interlock: _,
        calibration,
    } = settings;
    Some(match (section, key) {
        ("force", "zero_code") => &mut force.zero_code,
        ("force", "n_per_code") => &mut force.unit_per_code,
        ("hammer", "zero_code") => &mut hammer.zero_code,
        ("hammer", "m_per_code") => &mut hammer.unit_per_code,
        ("cart", "zero_code") => &mut cart.zero_code,
        ("cart", "m_per_code") => &mut cart.unit_per_code,
        ("force", "uncertainty_percent") => &mut calibration.force.uncertainty_percent,
        ("hammer", "uncertainty_percent") => &mut calibration.hammer.uncertainty_percent,
        ("cart", "uncertainty_percent") => &mut calibration.cart.uncertainty_percent,
        ("drive", "m_per_code") => &mut drive.m_per_code,
        ("drive", "frequency_slew_hz_per_s") => &mut drive.frequency_slew_hz_per_s,
        ("drive", "amplitude_slew_m_per_s") => &mut drive.amplitude_slew_m_per_s,
        ("limits", "force_n") => &mut limits.force_n,
        ("limits", "travel_m") => &mut limits.travel_m,
        ("limits", "min_frequency_hz") => &mut limits.min_frequency_hz,
        ("limits", "max_frequency_hz") => &mut limits.max_frequency_hz,
        ("limits", "amplitude_m") => &mut limits.amplitude_m,
        ("trips", "force_n") => &mut trips.force_n,
        ("trips", "travel_m") => &mut trips.travel_m,
        ("trips", "cart_m") => &mut trips.cart_m,
        ("trips", "no_contact_s") => &mut trips.no_contact_s,
        ("trips", "regime_lost_s") => &mut trips.regime_lost_s,
        ("trips", "link_timeout_s") => &mut trips.link_timeout_s,
        ("detection", "on_n") => &mut detection.on_n,
        ("detection", "off_n") => &mut detection.off_n,
        ("detection", "refractory_s") => &mut detection.refractory_s,
        ("aim", "force_n") => &mut aim.force_n,
        _ => return None,
    })
}

fn switch<'a>(settings: &'a mut Settings, section: &str, key: &str) -> Option<&'a mut bool> {
    match (section, key) {
        ("operator", "heartbeat") => Some(&mut settings.operator.heartbeat),
        ("operator", "acknowledge") => Some(&mut settings.operator.acknowledge),
        ("aim", "power") => Some(&mut settings.aim.power),
        ("interlock", "relay") => Some(&mut settings.interlock.relay),
        ("interlock", "ready") => Some(&mut settings.interlock.ready),
        _ => None,
    }
}

/// Settings as a file, every value with its meaning.
pub fn to_toml(settings: &Settings) -> String {
    let mut settings = *settings;
    let mut text = String::from(
        "# Settings of the controller. A file may name only what differs.\n# Send them with: host-sim link PORT set FILE.toml\n",
    );
    for section in SECTIONS {
        text.push_str(&format!("\n[{section}]\n"));
        match section {
            "rig" => text.push_str(&rigfile::lines_onto_any(&settings.rig)),
            "drive" => {
                let kind = kind_name(settings.drive.kind);
                text.push_str(&format!("kind = \"{kind}\"  # shaker or motor\n"));
            }
            _ => {}
        }
        if let Some(calibration) = calibration(&mut settings, section) {
            let day = day_text(calibration.day);
            text.push_str(&format!(
                "calibrated = \"{day}\"  # the day of the calibration, or never\n"
            ));
        }
        for (_, key, meaning) in SWITCHES.iter().filter(|(s, _, _)| *s == section) {
            if let Some(value) = switch(&mut settings, section, key) {
                text.push_str(&format!("{key} = {value}  # {meaning}\n"));
            }
        }
        for (_, key, meaning) in NUMBERS.iter().filter(|(s, _, _)| *s == section) {
            if let Some(value) = number(&mut settings, section, key) {
                // As few digits as make the same f32; a point makes it a TOML float.
                text.push_str(&format!("{key} = {value:?}  # {meaning}\n"));
            }
        }
    }
    text
}

/// `base` with the file `text` on top, checked as a whole.
///
/// # Errors
/// If the text is not TOML, a key is unknown, or a value is out of range.
pub fn overlay(base: &Settings, text: &str) -> Result<Settings, UserError> {
    let file: Table = toml::from_str(text).map_err(|e| {
        let start = e.span().map_or(0, |s| s.start.min(text.len()));
        let line = text[..start].lines().count().max(1);
        let what = e.message().lines().next().unwrap_or("not TOML").to_owned();
        UserError::new(format!(
            "line {line}: {what}; settings have sections like [trips] and lines like force_n = 300.0"
        ))
    })?;
    let mut settings = *base;
    let mut wanted = Wanted::default();
    for (section, value) in file {
        if !value.is_table() && !SECTIONS.contains(&section.as_str()) {
            return Err(UserError::new(format!(
                "{section} stands outside a section; settings have sections like [trips] (`host-sim link PORT get` prints them all), and a rig file goes with --rig FILE.toml"
            )));
        }
        if !SECTIONS.contains(&section.as_str()) {
            let hint = nearest(&section, SECTIONS.into_iter());
            return Err(UserError::new(format!(
                "there is no section [{section}]{hint}; `host-sim link PORT get` prints them all"
            )));
        }
        let Value::Table(entries) = value else {
            return Err(UserError::new(format!(
                "{section} must be a section: write [{section}] on a line of its own"
            )));
        };
        if section == "rig" {
            let rig = rigfile::with_table(&settings.rig, entries);
            settings.rig = rig.map_err(|e| e.at("[rig]"))?;
            continue;
        }
        for (key, value) in entries {
            match (section.as_str(), key.as_str()) {
                ("aim", "force_n") => wanted.force_n = Some(a_number(&section, &key, &value)?),
                ("aim", "force_ratio") => wanted.ratio = Some(a_number(&section, &key, &value)?),
                _ => set(&mut settings, &section, &key, &value)?,
            }
        }
    }
    // In units of the weight of the rig that the file leads to, wherever in it that stands.
    if let Some(force_n) = rigfile::force_wanted(wanted.force_n, wanted.ratio, &settings.rig)? {
        settings.aim.force_n = force_n;
    }
    settings.check()?;
    Ok(settings)
}

/// The two ways to say which force is wanted.
#[derive(Default)]
struct Wanted {
    force_n: Option<f64>,
    ratio: Option<f64>,
}

fn a_number(section: &str, key: &str, value: &Value) -> Result<f64, UserError> {
    rigfile::as_number(value)
        .ok_or_else(|| UserError::new(format!("{section}.{key} is {value}, must be a number")))
}

fn set(settings: &mut Settings, section: &str, key: &str, value: &Value) -> Result<(), UserError> {
    if (section, key) == ("drive", "kind") {
        let kinds = [DriveKind::Shaker, DriveKind::Motor];
        let named = kinds
            .into_iter()
            .find(|k| value.as_str() == Some(kind_name(*k)));
        settings.drive.kind = named.ok_or_else(|| {
            UserError::new(format!(
                "drive.kind is {value}, must be \"shaker\" or \"motor\""
            ))
        })?;
        return Ok(());
    }
    if let (Some(place), "calibrated") = (calibration(settings, section), key) {
        place.day = value.as_str().and_then(day).ok_or_else(|| {
            UserError::new(format!(
                "{section}.calibrated is {value}, must be a day such as \"2026-11-23\", or \"never\""
            ))
        })?;
        return Ok(());
    }
    if let Some(place) = switch(settings, section, key) {
        *place = value.as_bool().ok_or_else(|| {
            UserError::new(format!("{section}.{key} is {value}, must be true or false"))
        })?;
        return Ok(());
    }
    let mut known = *settings;
    let Some(place) = number(settings, section, key) else {
        let keys = NUMBERS.iter().filter(|(s, _, _)| *s == section);
        let keys = keys.map(|(_, key, _)| *key);
        let switches = SWITCHES.iter().filter(|(s, _, _)| *s == section);
        let ratio = (section == "aim").then_some("force_ratio");
        let calibrated = calibration(&mut known, section).map(|_| "calibrated");
        let keys = keys
            .chain(switches.map(|(_, key, _)| *key))
            .chain(ratio)
            .chain(calibrated);
        let hint = nearest(key, keys);
        return Err(UserError::new(format!(
            "there is no setting {section}.{key}{hint}; `host-sim link PORT get` prints them all"
        )));
    };
    *place = a_number(section, key, value)? as f32;
    Ok(())
}

/// The calibration that a sensor's section is about.
fn calibration<'a>(settings: &'a mut Settings, section: &str) -> Option<&'a mut Calibration> {
    let all = &mut settings.calibration;
    match section {
        "force" => Some(&mut all.force),
        "hammer" => Some(&mut all.hammer),
        "cart" => Some(&mut all.cart),
        _ => None,
    }
}

/// A day as its number: of "2026-11-23", 20261123. Whether there is such a day is checked with all settings.
fn day(text: &str) -> Option<u32> {
    if text == "never" {
        return Some(0);
    }
    let numbers: Vec<u32> = text
        .split('-')
        .map(|part| part.parse().ok())
        .collect::<Option<_>>()?;
    match numbers[..] {
        [year, month @ 0..100, date @ 0..100] if year < 10_000 => {
            Some(year * 10_000 + month * 100 + date)
        }
        _ => None,
    }
}

fn day_text(day: u32) -> String {
    match day {
        0 => "never".into(),
        _ => format!(
            "{:04}-{:02}-{:02}",
            day / 10_000,
            day / 100 % 100,
            day % 100
        ),
    }
}

fn kind_name(kind: DriveKind) -> &'static str {
    match kind {
        DriveKind::Shaker => "shaker",
        DriveKind::Motor => "motor",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
    use shared::model::params::{BEAM_150, PRESETS, RigParams, WIRES};
    use shared::settings::{DriveSettings, Interlock};

    #[test]
    fn what_is_written_reads_back_the_same_onto_any_base() {
        let base = Settings::for_rig(&BEAM_150);
        let held = CartDrive::Loop(ASSUMED_SHAKER);
        for (name, rig) in PRESETS {
            for (cart, other) in [(CartDrive::Prescribed, held), (held, CartDrive::Prescribed)] {
                let mut settings = Settings::for_rig(&RigParams { cart, ..rig });
                settings.operator.acknowledge = true;
                settings.interlock.relay = true;
                settings.calibration.hammer = Calibration {
                    day: 20_260_229,
                    uncertainty_percent: 0.5,
                };
                let text = to_toml(&settings);
                // The support of the file replaces the support of the base, and its shaker the base's.
                let rig = RigParams { cart: other, ..rig };
                let onto_its_kind = Settings { rig, ..base };
                assert_eq!(overlay(&onto_its_kind, &text).unwrap(), settings, "{name}");
            }
        }
    }

    /// The settings of `shared/src/link/store/layout-1.bin` as version 0.2.0 wrote them into a file.
    #[test]
    fn a_file_of_version_0_2_gives_the_settings_that_version_had() {
        let told = Settings {
            drive: DriveSettings {
                kind: DriveKind::Motor,
                frequency_slew_hz_per_s: 0.125,
                ..Settings::for_rig(&WIRES).drive
            },
            ..Settings::for_rig(&WIRES)
        };
        let text = include_str!("settings_file/version-0.2.toml");
        let read = overlay(&Settings::for_rig(&WIRES), text).unwrap();
        assert_eq!(read.rig.gap_m, 1.25e-3);
        assert_eq!(read.force.zero_code, 611.5);
        assert_eq!(read.hammer.unit_per_code, -told.hammer.unit_per_code);
        assert_eq!(read.drive, told.drive);
        assert_eq!(read.limits.min_frequency_hz, 1.365);
        assert_eq!(read.trips.link_timeout_s, 1.5);
        assert_eq!(read.detection.refractory_s, 1.75e-3);
        // What version 0.2.0 did not have stays as it is on the board.
        let base = Settings {
            interlock: Interlock {
                relay: true,
                ready: false,
            },
            ..Settings::for_rig(&WIRES)
        };
        assert!(overlay(&base, text).unwrap().interlock.relay);
    }

    #[test]
    fn a_shaker_is_given_changed_and_taken_away_and_an_absurd_one_refused() {
        let base = Settings::for_rig(&WIRES);
        let with = |base: &Settings, lines: &str| overlay(base, &format!("[rig]\n{lines}\n"));
        let held = with(&base, "shaker_loop_hz = 35").unwrap();
        let wanted = LoopParams {
            frequency_hz: 35.0,
            ..ASSUMED_SHAKER
        };
        assert_eq!(held.rig.cart, CartDrive::Loop(wanted));
        let damped = with(&held, "shaker_damping_ratio = 0.5\ncart_mass_kg = 7").unwrap();
        let wanted = LoopParams {
            damping_ratio: 0.5,
            ..wanted
        };
        assert_eq!(damped.rig.cart, CartDrive::Loop(wanted));
        let without = with(
            &damped,
            "shaker_loop_hz = \"prescribed\"\ncart_mass_kg = 5.38",
        )
        .unwrap();
        assert_eq!(without, base);
        let complaint = |lines: &str| with(&held, lines).unwrap_err().to_string();
        for (lines, line) in [
            (
                "shaker_loop_hz = 0.1",
                "shaker_loop_hz is 0.1, must be 1 to 500 for the controller",
            ),
            (
                "shaker_loop_hz = 1000",
                "shaker_loop_hz is 1000, must be 1 to 500",
            ),
            (
                "shaker_loop_hz = nan",
                "shaker_loop_hz is NaN, must be a number from",
            ),
            ("shaker_loop_hz = \"stiff\"", "must be a number"),
            (
                "shaker_damping_ratio = 0",
                "shaker_damping_ratio is 0, must be 0.05 to 5",
            ),
            (
                "shaker_damping_ratio = 10",
                "shaker_damping_ratio is 10, must be 0.05 to 5",
            ),
            (
                "cart_mass_kg = 0.001",
                "cart_mass_kg is 0.001, must be at least a fifth of mass_kg",
            ),
        ] {
            let found = complaint(lines);
            assert!(found.contains(line), "{found}");
        }
        let orphan = with(&base, "shaker_damping_ratio = 0.5").unwrap_err();
        assert!(
            orphan.to_string().contains("needs shaker_loop_hz"),
            "{orphan}"
        );
    }

    #[test]
    fn every_number_has_a_place_and_a_place_of_its_own() {
        let mut settings = Settings::for_rig(&WIRES);
        for (i, (section, key, _)) in NUMBERS.iter().enumerate() {
            *number(&mut settings, section, key).expect(key) = i as f32;
        }
        for (i, (section, key, _)) in NUMBERS.iter().enumerate() {
            assert_eq!(number(&mut settings, section, key), Some(&mut (i as f32)));
        }
    }

    #[test]
    fn a_file_names_only_what_differs_and_mistakes_are_told() {
        let base = Settings::for_rig(&WIRES);
        let new = overlay(&base, "[trips]\nforce_n = 450\n[rig]\ngap_mm = 1.0\n").unwrap();
        assert_eq!((new.trips.force_n, new.rig.gap_m), (450.0, 1e-3));
        assert_eq!(new.limits, base.limits);
        let complaint = |text: &str| overlay(&base, text).unwrap_err().to_string();
        assert!(
            complaint("[trips]\nforce = 1\n").contains("trips.force (did you mean 'force_n'?)")
        );
        assert!(complaint("[trip]\n").contains("did you mean 'trips'"));
        assert!(complaint("trips = 1\n").contains("must be a section"));
        assert!(complaint("[rig]\nmas_kg = 1\n").contains("[rig]: there is no parameter"));
        assert!(
            complaint("[trips]\nforce_n = 1.0\n").contains("trips.force_n is 1, must be at least")
        );
        assert!(complaint("[trips]\nforce_n = \"x\"\n").contains("must be a number"));
        assert!(complaint("[drive]\nkind = \"hand\"\n").contains("must be \"shaker\""));
        assert!(complaint("[trips\n").contains("line 1"));
        let new = overlay(&base, "[operator]\nheartbeat = true\n").unwrap();
        assert!(new.operator.heartbeat && !new.operator.acknowledge);
        let dated = overlay(&base, "[force]\ncalibrated = \"2026-11-23\"\n").unwrap();
        assert_eq!(dated.calibration.force.day, 20_261_123);
        assert!(complaint("[force]\ncalibrated = 2026\n").contains("must be a day"));
        assert!(complaint("[force]\ncalibrated = \"2026-13-01\"\n").contains("must be a day"));
        assert!(complaint("[cart]\ncalibratd = 1\n").contains("did you mean 'calibrated'"));
        assert!(complaint("[operator]\nheartbeat = 1\n").contains("must be true or false"));
        assert!(complaint("[operator]\nheart = true\n").contains("did you mean 'heartbeat'"));
    }

    #[test]
    fn the_force_wanted_is_in_newtons_or_in_units_of_the_weight() {
        let base = Settings::for_rig(&WIRES);
        let wanted = |text: &str| overlay(&base, text).unwrap().aim.force_n;
        assert_eq!(wanted("[aim]\nforce_n = 80\n"), 80.0);
        let twenty = wanted("[aim]\nforce_ratio = 20\n");
        assert_eq!(twenty, (20.0 * WIRES.weight_n()) as f32);
        // The weight of the rig of the same file, which stands after it or before.
        let text = "[aim]\nforce_ratio = 20\n[rig]\nmass_kg = 0.2\n";
        let heavier = wanted(text);
        let ratio = f64::from(heavier / twenty) * WIRES.mass_kg / 0.2;
        assert!((ratio - 1.0).abs() < 1e-6, "{heavier}");
        // What is not named stays.
        let asked = overlay(&base, "[aim]\nforce_n = 80\n").unwrap();
        let power = overlay(&asked, "[aim]\npower = true\n").unwrap();
        assert_eq!((power.aim.force_n, power.aim.power), (80.0, true));
        let complaint = |text: &str| overlay(&base, text).unwrap_err().to_string();
        assert_eq!(
            complaint("[aim]\nforce_n = 80\nforce_ratio = 20\n"),
            "[aim] has force_n and force_ratio; give one of them"
        );
        assert!(complaint("[aim]\nforce_ratio = 2000\n").contains("at most limits.force_n"));
        assert!(complaint("[aim]\nforce_ratio = true\n").contains("must be a number"));
        assert!(complaint("[aim]\nforce_rato = 2\n").contains("did you mean 'force_ratio'"));
    }
}
