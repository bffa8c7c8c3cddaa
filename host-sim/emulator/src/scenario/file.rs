//! A scenario as it is written, and the way from there to one that can be run.

use std::collections::BTreeMap;

use serde::Deserialize;
use shared::fault::Fault;
use shared::model::params::{ParamError, RigParams};
use shared::settings::Settings;
use toml::Value;

use super::{Change, Expect, LONGEST_S, Scenario, event};
use crate::sensors::{Errors, SensorParams};
use crate::shaker::ShakerParams;
use files::UserError;
use files::rigfile::{self, nearest};

/// Slices per block where the file does not say: the first forecast is then done in one or two seconds of rig
/// time, about what a board has idle time for.
const SLICES: u32 = 20;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Option<String>,
    #[serde(default)]
    description: String,
    duration_s: f64,
    #[serde(default = "one")]
    seed: u64,
    block_ticks: Option<usize>,
    slices_per_block: Option<u32>,
    #[serde(default)]
    clock_ppm: f64,
    true_rig: BTreeMap<String, Value>,
    believed: Option<BTreeMap<String, Value>>,
    #[serde(default)]
    limits: Limits,
    #[serde(default)]
    trips: Trips,
    #[serde(default)]
    shaker: Shaker,
    #[serde(default)]
    sensors: Sensors,
    #[serde(default)]
    events: Vec<toml::Table>,
    #[serde(default)]
    expect: Expect,
}

/// States by the names scenarios give them.
const STATES: [&str; 8] = [
    "idle",
    "self-test",
    "ramp",
    "seek",
    "hold",
    "stop",
    "fault",
    "manual",
];

fn one() -> u64 {
    1
}

/// Declares a table of optional numbers.
macro_rules! numbers {
    ($table:ident { $($key:ident),* $(,)? }) => {
        #[derive(Default, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct $table { $($key: Option<f64>),* }
    };
}

numbers!(Limits {
    force_n,
    travel_mm,
    min_frequency_hz,
    max_frequency_hz,
    amplitude_mm,
});

numbers!(Trips {
    force_n,
    travel_mm,
    cart_mm,
    no_contact_s,
    regime_lost_s,
    link_timeout_s,
});

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Shaker {
    prescribed: Option<bool>,
    loop_hz: Option<f64>,
    loop_damping_ratio: Option<f64>,
    force_n: Option<f64>,
    feed_forward: Option<f64>,
    lag_ms: Option<f64>,
    droop_hz: Option<f64>,
    suspension_hz: Option<f64>,
    suspension_damping_ratio: Option<f64>,
}

numbers!(Sensors {
    noise_percent,
    force_noise_n,
    hammer_noise_um,
    cart_noise_um,
    force_offset_n,
    hammer_offset_um,
    cart_offset_um,
    force_gain_percent,
    hammer_gain_percent,
    cart_gain_percent,
    force_filter_hz,
    displacement_filter_hz,
    ringing_hz,
    ringing_percent,
    ringing_decay_ms,
});

/// The complaint of the TOML reader as one line, with the nearest word where one was not known.
pub fn complaint(message: &str) -> UserError {
    let line = message.lines().next().unwrap_or("not TOML");
    let mut quoted = line.split('`').skip(1).step_by(2);
    let unknown = line.starts_with("unknown");
    match (unknown, quoted.next()) {
        (true, Some(word)) => {
            let known: Vec<&str> = quoted.collect();
            let hint = nearest(word, known.iter().copied());
            let hint = match known.as_slice() {
                _ if !hint.is_empty() => hint,
                [] => "; it takes none".to_owned(),
                some => format!("; there are {}", some.join(", ")),
            };
            let what = if line.starts_with("unknown variant") {
                "word"
            } else {
                "key"
            };
            UserError::new(format!("there is no {what} '{word}' here{hint}"))
        }
        _ => {
            let mut line = line.replace('`', "'");
            for (machine, person) in [
                ("u64", "a whole number from 0"),
                ("u32", "a whole number from 0"),
                ("usize", "a whole number from 0"),
                ("f64", "a number"),
            ] {
                line = line.replace(
                    &format!("expected {machine}"),
                    &format!("expected {person}"),
                );
            }
            UserError::new(line)
        }
    }
}

/// See [`super::parse`].
pub fn parse(name: &str, text: &str, place: &str) -> Result<Scenario, UserError> {
    let file: File = toml::from_str(text).map_err(|e| {
        let line = e.span().map_or(1, |s| {
            text[..s.start.min(text.len())].matches('\n').count() + 1
        });
        complaint(e.message()).at(format!("{place}, line {line}"))
    })?;
    check(&file).map_err(|e| e.at(place))?;
    expected(&file.expect).map_err(|e| e.at(format!("{place}, [expect]")))?;
    let (true_rig, plain) = true_rig(file.true_rig, place)?;
    let believed = match file.believed {
        Some(keys) => rigfile::from_keys(keys, &format!("{place}, [believed]"))?,
        None => plain,
    };
    let settings = settings(&believed, &file.limits, &file.trips)
        .map_err(|e| e.at(format!("{place}, [limits] and [trips]")))?;
    let mut events = Vec::new();
    for (i, table) in file.events.into_iter().enumerate() {
        let timed = event::timed(table, file.duration_s, &true_rig);
        events.push(timed.map_err(|e| e.at(format!("{place}, event {}", i + 1)))?);
    }
    events.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    Ok(Scenario {
        name: file.name.unwrap_or_else(|| name.to_owned()),
        description: file.description,
        duration_s: file.duration_s,
        seed: file.seed,
        block_ticks: file.block_ticks.unwrap_or(10),
        slices_per_block: file.slices_per_block.unwrap_or(SLICES),
        clock_ppm: file.clock_ppm,
        true_rig,
        settings,
        shaker: shaker(&file.shaker).map_err(|e| e.at(format!("{place}, [shaker]")))?,
        prescribed: file.shaker.prescribed.unwrap_or(false),
        sensors: sensors(&file.sensors, &settings)
            .map_err(|e| e.at(format!("{place}, [sensors]")))?,
        events,
        expect: file.expect,
    })
}

pub(super) fn out_of_range(key: &str, value: f64, must_be: &str) -> UserError {
    UserError::new(format!("{key} is {value}, must be {must_be}"))
}

fn check(file: &File) -> Result<(), UserError> {
    if !(file.duration_s > 0.0 && file.duration_s <= LONGEST_S) {
        return Err(out_of_range(
            "duration_s",
            file.duration_s,
            "above 0 and at most two days",
        ));
    }
    if let Some(ticks) = file.block_ticks
        && !(1..=shared::control::MAX_BLOCK).contains(&ticks)
    {
        return Err(out_of_range("block_ticks", ticks as f64, "1 to 32"));
    }
    if file.clock_ppm.is_nan() || file.clock_ppm.abs() > 10_000.0 {
        return Err(out_of_range("clock_ppm", file.clock_ppm, "within 10000"));
    }
    Ok(())
}

/// The rig of `[true_rig]`, and the same without its changes.
fn true_rig(
    mut keys: BTreeMap<String, Value>,
    place: &str,
) -> Result<(RigParams, RigParams), UserError> {
    let place = format!("{place}, [true_rig]");
    let changes: toml::Table = Change::KEYS
        .iter()
        .filter_map(|key| keys.remove_entry(*key))
        .collect();
    let change = Change::deserialize(Value::Table(changes))
        .map_err(|e| complaint(e.message()).at(&place))?;
    change.check().map_err(|e| e.at(&place))?;
    let plain = rigfile::from_keys(keys, &place)?;
    let rig = change.apply(&plain, 1.0);
    rig.check().map_err(|e| UserError::from(e).at(&place))?;
    Ok((rig, plain))
}

fn settings(believed: &RigParams, limits: &Limits, trips: &Trips) -> Result<Settings, UserError> {
    let mut settings = Settings::for_rig(believed);
    let put = |to: &mut f32, value: Option<f64>, unit: f64| {
        if let Some(value) = value {
            *to = (value * unit) as f32;
        }
    };
    let to = &mut settings.limits;
    put(&mut to.force_n, limits.force_n, 1.0);
    put(&mut to.travel_m, limits.travel_mm, 1e-3);
    put(&mut to.min_frequency_hz, limits.min_frequency_hz, 1.0);
    put(&mut to.max_frequency_hz, limits.max_frequency_hz, 1.0);
    put(&mut to.amplitude_m, limits.amplitude_mm, 1e-3);
    let to = &mut settings.trips;
    put(&mut to.force_n, trips.force_n, 1.0);
    put(&mut to.travel_m, trips.travel_mm, 1e-3);
    put(&mut to.cart_m, trips.cart_mm, 1e-3);
    put(&mut to.no_contact_s, trips.no_contact_s, 1.0);
    put(&mut to.regime_lost_s, trips.regime_lost_s, 1.0);
    put(&mut to.link_timeout_s, trips.link_timeout_s, 1.0);
    settings.check().map_err(in_the_file_s_units)?;
    Ok(settings)
}

/// Settings are in m, and so are their names; a scenario has mm.
fn in_the_file_s_units(error: ParamError) -> UserError {
    match error.key.strip_suffix("_m") {
        Some(key) => out_of_range(
            &format!("{key}_mm"),
            numerics::row::tidy(error.value * 1e3),
            error.must_be,
        ),
        None => error.into(),
    }
}

/// `key`'s value times `unit`, or what stands; within `from` and `to`, both in the key's unit.
fn pick(
    key: &str,
    value: Option<f64>,
    (from, to): (f64, f64),
    unit: f64,
    otherwise: f64,
) -> Result<f64, UserError> {
    match value {
        None => Ok(otherwise),
        Some(x) if (from..=to).contains(&x) => Ok(x * unit),
        Some(x) => Err(out_of_range(key, x, &format!("{from} to {to}"))),
    }
}

fn shaker(file: &Shaker) -> Result<ShakerParams, UserError> {
    let d = ShakerParams::default();
    let ratio = (0.0, 10.0);
    Ok(ShakerParams {
        // Above, the plant's step in flight is too long for the loop.
        loop_hz: pick("loop_hz", file.loop_hz, (1.0, 500.0), 1.0, d.loop_hz)?,
        loop_damping_ratio: pick(
            "loop_damping_ratio",
            file.loop_damping_ratio,
            (0.05, 2.0),
            1.0,
            d.loop_damping_ratio,
        )?,
        force_n: pick("force_n", file.force_n, (0.0, 1e6), 1.0, d.force_n)?,
        feed_forward: pick(
            "feed_forward",
            file.feed_forward,
            (0.0, 2.0),
            1.0,
            d.feed_forward,
        )?,
        lag_s: pick("lag_ms", file.lag_ms, (0.05, 100.0), 1e-3, d.lag_s)?,
        droop_hz: pick("droop_hz", file.droop_hz, (1.0, 3000.0), 1.0, d.droop_hz)?,
        suspension_hz: pick(
            "suspension_hz",
            file.suspension_hz,
            (0.1, 100.0),
            1.0,
            d.suspension_hz,
        )?,
        suspension_damping_ratio: pick(
            "suspension_damping_ratio",
            file.suspension_damping_ratio,
            ratio,
            1.0,
            d.suspension_damping_ratio,
        )?,
    })
}

fn sensors(file: &Sensors, settings: &Settings) -> Result<SensorParams, UserError> {
    let d = SensorParams::default();
    let share = pick("noise_percent", file.noise_percent, (0.0, 50.0), 0.01, 0.0)?;
    // Noise in percent is of what is typical: the strongest 1/1, a fifth of the force sensor's range, and A0.
    let typical_n = 3300.0 / 5.0 * f64::from(settings.force.unit_per_code.abs());
    let typical_m = settings.rig.amplitude_m;
    let gain = (-50.0, 100.0);
    let errors = |names: [&str; 3], values: [Option<f64>; 3], unit, typical, reach: f64| {
        Ok::<_, UserError>(Errors {
            offset: pick(names[0], values[0], (-reach, reach), unit, 0.0)?,
            gain_error: pick(names[1], values[1], gain, 0.01, 0.0)?,
            noise: pick(names[2], values[2], (0.0, reach), unit, share * typical)?,
        })
    };
    Ok(SensorParams {
        force: errors(
            ["force_offset_n", "force_gain_percent", "force_noise_n"],
            [
                file.force_offset_n,
                file.force_gain_percent,
                file.force_noise_n,
            ],
            1.0,
            typical_n,
            1e5,
        )?,
        hammer: errors(
            ["hammer_offset_um", "hammer_gain_percent", "hammer_noise_um"],
            [
                file.hammer_offset_um,
                file.hammer_gain_percent,
                file.hammer_noise_um,
            ],
            1e-6,
            typical_m,
            1e5,
        )?,
        cart: errors(
            ["cart_offset_um", "cart_gain_percent", "cart_noise_um"],
            [
                file.cart_offset_um,
                file.cart_gain_percent,
                file.cart_noise_um,
            ],
            1e-6,
            typical_m,
            1e5,
        )?,
        force_filter_hz: pick(
            "force_filter_hz",
            file.force_filter_hz,
            (10.0, 50_000.0),
            1.0,
            d.force_filter_hz,
        )?,
        displacement_filter_hz: pick(
            "displacement_filter_hz",
            file.displacement_filter_hz,
            (10.0, 50_000.0),
            1.0,
            d.displacement_filter_hz,
        )?,
        ringing_hz: pick(
            "ringing_hz",
            file.ringing_hz,
            (100.0, 20_000.0),
            1.0,
            d.ringing_hz,
        )?,
        ringing_share: pick(
            "ringing_percent",
            file.ringing_percent,
            (0.0, 200.0),
            0.01,
            d.ringing_share,
        )?,
        ringing_decay_s: pick(
            "ringing_decay_ms",
            file.ringing_decay_ms,
            (0.01, 100.0),
            1e-3,
            d.ringing_decay_s,
        )?,
    })
}

/// Whether what is expected can come.
fn expected(expect: &Expect) -> Result<(), UserError> {
    let one_of = |key: &str, given: &str, known: &[&str]| {
        if known.contains(&given) {
            return Ok(());
        }
        let known = known.join(", ");
        Err(UserError::new(format!(
            "{key} is `{given}`, must be one of {known}"
        )))
    };
    if let Some(state) = &expect.final_state {
        one_of("final_state", state, &STATES)?;
    }
    if let Some(basin) = &expect.basin {
        one_of("basin", basin, &["impact", "no-impact", "unknown"])?;
    }
    for fault in &expect.faults {
        one_of("faults", fault, &Fault::ALL.map(Fault::name))?;
    }
    match expect.min_force_share {
        Some(share) if !(0.0..=2.0).contains(&share) => Err(UserError::new(format!(
            "min_force_share is {share}, must be 0 to 2"
        ))),
        _ => Ok(()),
    }
}
