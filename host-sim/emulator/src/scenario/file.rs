//! A scenario file, and the checks that turn it into a scenario that can be run.

use std::collections::BTreeMap;

use serde::Deserialize;
use shared::fault::Fault;
use shared::model::cart::CartDrive;
use shared::model::params::{ParamError, RigParams};
use shared::settings::{DriveKind, Settings};
use toml::Value;

use super::change::RigChange;
use super::complaint::{not_understood, out_of_range};
use super::definition::{Expect, LONGEST_S, Scenario};
use super::event;
use super::ground::GroundTable;
use super::hardware::{
    CartTable, MotorTable, SensorsTable, ShakerTable, motor, mounting, sensors, shaker,
};
use crate::cart::Mounting;
use crate::names::{BASINS, STATES, basin_name, state_name};
use files::decimal::comma_at;
use files::rigfile;
use files::settings_file::refusal;
use files::{UserError, line_at};

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
    aim: Aim,
    #[serde(default)]
    operator: Operator,
    #[serde(default)]
    shaker: ShakerTable,
    #[serde(default)]
    sensors: SensorsTable,
    #[serde(default)]
    cart: CartTable,
    motor: Option<MotorTable>,
    ground: Option<GroundTable>,
    #[serde(default)]
    events: Vec<toml::Table>,
    #[serde(default)]
    expect: Expected,
}

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

/// The table `[aim]`: the mean peak force to reach, and whether to seek the most power, not the strongest contact.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Aim {
    force_n: Option<f64>,
    force_ratio: Option<f64>,
    #[serde(default)]
    power: bool,
}

impl Aim {
    /// What `rig` is to aim at.
    fn of(&self, rig: &RigParams) -> Result<shared::settings::Aim, UserError> {
        let wanted = rigfile::force_wanted(self.force_n, self.force_ratio, rig)?;
        Ok(shared::settings::Aim {
            force_n: wanted.unwrap_or(0.0),
            power: self.power,
        })
    }
}

/// Who must be there, as the controller's settings say it.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Operator {
    heartbeat: bool,
    acknowledge: bool,
}

/// The scenario in `text`, called `name` unless it says otherwise; `place` begins complaints.
///
/// # Errors
/// It is not TOML, a key is unknown, or a value is out of its range.
pub fn parse(name: &str, text: &str, place: &str) -> Result<Scenario, UserError> {
    let file: File = toml::from_str(text).map_err(|e| {
        let line = line_at(text, e.span().map_or(0, |span| span.start));
        let mend = comma_at(text, line).map_or(String::new(), |write| format!("; {write}"));
        let why = not_understood(e.message());
        UserError::new(format!("{place}, line {line}: {why}{mend}"))
    })?;
    check(&file).map_err(|e| e.at(place))?;
    let expect = expect(&file.expect).map_err(|e| e.at(format!("{place}, [expect]")))?;
    let (true_rig, plain) = true_rig(file.true_rig, place)?;
    let prescribed = file.shaker.prescribed.unwrap_or(false);
    let shaker = shaker(&file.shaker).map_err(|e| e.at(format!("{place}, [shaker]")))?;
    let (mut believed, told) = match file.believed {
        Some(keys) => rigfile::believed_from_keys(keys, &format!("{place}, [believed]"))?,
        None => (plain, false),
    };
    let mut loop_left_out = None;
    if !told && !prescribed && file.motor.is_none() {
        match shaker.believed_by(&believed) {
            Ok(cart) => believed.cart = cart,
            Err(why) => {
                believed.cart = CartDrive::Prescribed;
                loop_left_out = Some(why);
            }
        }
    }
    let kind = match file.motor {
        Some(_) => DriveKind::Motor,
        None => DriveKind::Shaker,
    };
    let aim = file.aim.of(&believed).map_err(|e| e.at(place))?;
    let settings = settings(
        &believed,
        kind,
        aim,
        &file.limits,
        &file.trips,
        &file.operator,
    )
    .map_err(|e| e.at(format!("{place}, [limits], [trips] and [aim]")))?;
    let motor = file.motor.as_ref().map(|keys| motor(keys, &true_rig));
    let motor = motor
        .transpose()
        .map_err(|e| e.at(format!("{place}, [motor]")))?;
    let mounting = mounting(&file.cart).map_err(|e| e.at(format!("{place}, [cart]")))?;
    one_drive(prescribed, motor.is_some(), &mounting).map_err(|e| e.at(place))?;
    let mut events = Vec::new();
    for (i, mut table) in file.sensors.defects.clone().into_iter().enumerate() {
        let of_an_event = [("at_s", Value::Float(0.0)), ("kind", "sensor-fault".into())];
        for (key, value) in of_an_event {
            if table.insert(key.into(), value).is_some() {
                let what = format!("{key} stands in events alone; leave it out");
                let place = format!("{place}, [[sensors.defects]] {}", i + 1);
                return Err(UserError::new(what).at(place));
            }
        }
        let timed = event::timed(table, file.duration_s, &true_rig);
        events.push(timed.map_err(|e| e.at(format!("{place}, [[sensors.defects]] {}", i + 1)))?);
    }
    for (i, table) in file.events.into_iter().enumerate() {
        let timed = event::timed(table, file.duration_s, &true_rig);
        events.push(timed.map_err(|e| e.at(format!("{place}, event {}", i + 1)))?);
    }
    events.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    let ground = file.ground.map(|keys| keys.of(&true_rig)).transpose();
    let ground = ground.map_err(|e| e.at(format!("{place}, [ground]")))?;
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
        loop_left_out,
        shaker,
        prescribed,
        motor,
        mounting,
        ground,
        sensors: sensors(&file.sensors, &settings)
            .map_err(|e| e.at(format!("{place}, [sensors]")))?,
        events,
        expect,
    })
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
    let changes: toml::Table = RigChange::KEYS
        .iter()
        .filter_map(|key| keys.remove_entry(*key))
        .collect();
    let change = RigChange::deserialize(Value::Table(changes))
        .map_err(|e| not_understood(e.message()).at(&place))?;
    change.check().map_err(|e| e.at(&place))?;
    let plain = rigfile::from_keys(keys, &place)?;
    change.fits(&plain).map_err(|e| e.at(&place))?;
    let rig = change.apply(&plain, 1.0);
    rig.check().map_err(|e| UserError::from(e).at(&place))?;
    Ok((rig, plain))
}

/// Whether what moves the cart is said once, and leaves the mounting something to do.
fn one_drive(prescribed: bool, motor: bool, mounting: &Mounting) -> Result<(), UserError> {
    if prescribed && motor {
        return Err(UserError::new(
            "prescribed = true and [motor] both move the cart; leave one out",
        ));
    }
    if prescribed && (mounting.friction.is_some() || mounting.stops.is_some()) {
        return Err(UserError::new(
            "with prescribed = true the cart knows no friction and no end stops; leave them out of [cart]",
        ));
    }
    Ok(())
}

fn settings(
    believed: &RigParams,
    kind: DriveKind,
    aim: shared::settings::Aim,
    limits: &Limits,
    trips: &Trips,
    operator: &Operator,
) -> Result<Settings, UserError> {
    let mut settings = Settings::for_rig(believed);
    settings.drive.kind = kind;
    settings.aim = aim;
    settings.operator.heartbeat = operator.heartbeat;
    settings.operator.acknowledge = operator.acknowledge;
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
    settings
        .check()
        .map_err(|error| in_the_file_s_units(&settings, error))?;
    Ok(settings)
}

/// Settings have lengths in m, and keys ending in `_m`; scenarios have mm.
fn in_the_file_s_units(settings: &Settings, error: ParamError) -> UserError {
    match error.key.strip_suffix("_m") {
        Some(key) => out_of_range(
            &format!("{key}_mm"),
            numerics::row::tidy(error.value * 1e3),
            error.must_be,
        ),
        None => refusal(settings, error),
    }
}

/// The table `[expect]`: what the run must end in, and bounds on its force, times and counts.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    final_state: Option<String>,
    #[serde(default)]
    faults: Vec<String>,
    min_force_share: Option<f64>,
    max_force_share: Option<f64>,
    min_share_from_start: Option<f64>,
    max_true_force_n: Option<f64>,
    max_true_cart_mm: Option<f64>,
    max_driven_with_fault_s: Option<f64>,
    hold_within_s: Option<f64>,
    basin: Option<String>,
    min_reseeks: Option<u16>,
    drive_off_within_ticks: Option<u64>,
    min_progress_um_per_s: Option<f64>,
}

fn expect(file: &Expected) -> Result<Expect, UserError> {
    let state = |given: &String| one_of("final_state", given, &STATES, state_name);
    let basin = |given: &String| one_of("basin", given, &BASINS, basin_name);
    let fault = |given: &String| one_of("faults", given, &Fault::ALL, Fault::name);
    let expect = Expect {
        final_state: file.final_state.as_ref().map(state).transpose()?,
        basin: file.basin.as_ref().map(basin).transpose()?,
        faults: file.faults.iter().map(fault).collect::<Result<_, _>>()?,
        min_force_share: file.min_force_share,
        max_force_share: file.max_force_share,
        min_share_from_start: file.min_share_from_start,
        max_true_force_n: file.max_true_force_n,
        max_true_cart_mm: file.max_true_cart_mm,
        max_driven_with_fault_s: file.max_driven_with_fault_s,
        hold_within_s: file.hold_within_s,
        min_reseeks: file.min_reseeks,
        drive_off_within_ticks: file.drive_off_within_ticks,
        min_progress_um_per_s: file.min_progress_um_per_s,
    };
    let share = (0.0, 2.0);
    let anything = (0.0, 1e9);
    for (key, value, (from, to)) in [
        ("min_force_share", file.min_force_share, share),
        ("max_force_share", file.max_force_share, (0.0, 100.0)),
        ("min_share_from_start", file.min_share_from_start, share),
        ("max_true_force_n", file.max_true_force_n, anything),
        ("max_true_cart_mm", file.max_true_cart_mm, anything),
        (
            "max_driven_with_fault_s",
            file.max_driven_with_fault_s,
            anything,
        ),
        ("hold_within_s", file.hold_within_s, anything),
        (
            "min_progress_um_per_s",
            file.min_progress_um_per_s,
            anything,
        ),
    ] {
        if let Some(value) = value
            && !(from..=to).contains(&value)
        {
            return Err(out_of_range(key, value, &format!("{from} to {to}")));
        }
    }
    Ok(expect)
}

/// The one of `known` that is called `given`.
fn one_of<T: Copy>(
    key: &str,
    given: &str,
    known: &[T],
    name: fn(T) -> &'static str,
) -> Result<T, UserError> {
    let found = known.iter().find(|one| name(**one) == given);
    found.copied().ok_or_else(|| {
        let names: Vec<_> = known.iter().map(|one| name(*one)).collect();
        let names = names.join(", ");
        UserError::new(format!("{key} is `{given}`, must be one of {names}"))
    })
}
