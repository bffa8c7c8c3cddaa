//! Shaker and sensors as a scenario writes them.

use serde::Deserialize;
use shared::settings::Settings;

use super::complaint::out_of_range;
use crate::sensors::{Errors, SensorParams};
use crate::shaker::ShakerParams;
use files::UserError;

/// The table `[shaker]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shaker {
    pub prescribed: Option<bool>,
    loop_hz: Option<f64>,
    loop_damping_ratio: Option<f64>,
    force_n: Option<f64>,
    feed_forward: Option<f64>,
    lag_ms: Option<f64>,
    droop_hz: Option<f64>,
    suspension_hz: Option<f64>,
    suspension_damping_ratio: Option<f64>,
}

/// The table `[sensors]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensors {
    noise_percent: Option<f64>,
    force_noise_n: Option<f64>,
    hammer_noise_um: Option<f64>,
    cart_noise_um: Option<f64>,
    force_offset_n: Option<f64>,
    hammer_offset_um: Option<f64>,
    cart_offset_um: Option<f64>,
    force_gain_percent: Option<f64>,
    hammer_gain_percent: Option<f64>,
    cart_gain_percent: Option<f64>,
    force_filter_hz: Option<f64>,
    displacement_filter_hz: Option<f64>,
    ringing_hz: Option<f64>,
    ringing_percent: Option<f64>,
    ringing_decay_ms: Option<f64>,
    /// What is wrong from the start: each as an event of kind `sensor-fault` without its time.
    #[serde(default)]
    pub defects: Vec<toml::Table>,
}

/// The value of `key` times `unit`, or `otherwise` if there is none. The range is in the key's unit.
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

/// The shaker, its defaults for what is left out.
pub fn shaker(file: &Shaker) -> Result<ShakerParams, UserError> {
    let d = ShakerParams::default();
    let ratio = (0.0, 10.0);
    Ok(ShakerParams {
        // For faster loops the plant's step in flight is too long.
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

/// The sensors, their defaults for what is left out.
pub fn sensors(file: &Sensors, settings: &Settings) -> Result<SensorParams, UserError> {
    let d = SensorParams::default();
    let share = pick("noise_percent", file.noise_percent, (0.0, 50.0), 0.01, 0.0)?;
    // Noise in percent is of what is typical: the strongest 1/1, a fifth of the force sensor's range, and A0.
    let typical_n = 3300.0 / 5.0 * f64::from(settings.force.unit_per_code.abs());
    let typical_m = settings.rig.amplitude_m;
    let corner = (10.0, 50_000.0);
    Ok(SensorParams {
        force: errors(
            ["force_offset_n", "force_gain_percent", "force_noise_n"],
            [
                file.force_offset_n,
                file.force_gain_percent,
                file.force_noise_n,
            ],
            1.0,
            share * typical_n,
        )?,
        hammer: errors(
            ["hammer_offset_um", "hammer_gain_percent", "hammer_noise_um"],
            [
                file.hammer_offset_um,
                file.hammer_gain_percent,
                file.hammer_noise_um,
            ],
            1e-6,
            share * typical_m,
        )?,
        cart: errors(
            ["cart_offset_um", "cart_gain_percent", "cart_noise_um"],
            [
                file.cart_offset_um,
                file.cart_gain_percent,
                file.cart_noise_um,
            ],
            1e-6,
            share * typical_m,
        )?,
        force_filter_hz: pick(
            "force_filter_hz",
            file.force_filter_hz,
            corner,
            1.0,
            d.force_filter_hz,
        )?,
        displacement_filter_hz: pick(
            "displacement_filter_hz",
            file.displacement_filter_hz,
            corner,
            1.0,
            d.displacement_filter_hz,
        )?,
        ..ringing(file, d)?
    })
}

/// The default sensors with the ringing of the file.
fn ringing(file: &Sensors, d: SensorParams) -> Result<SensorParams, UserError> {
    Ok(SensorParams {
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
        ..d
    })
}

/// Offset, gain error and noise of a sensor; `noise` where the file gives none.
fn errors(
    names: [&str; 3],
    values: [Option<f64>; 3],
    unit: f64,
    noise: f64,
) -> Result<Errors, UserError> {
    const REACH: f64 = 1e5;
    Ok(Errors {
        offset: pick(names[0], values[0], (-REACH, REACH), unit, 0.0)?,
        gain_error: pick(names[1], values[1], (-50.0, 100.0), 0.01, 0.0)?,
        noise: pick(names[2], values[2], (0.0, REACH), unit, noise)?,
    })
}
